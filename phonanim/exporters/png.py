"""A plot of the curves under the waveform, the words and the phones."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.media.audio import read_audio
from phonanim.media.pixels import Color, Image, draw_text, fill, shortened, text_width, write_png
from phonanim.rig.neck import is_turn
from phonanim.speech.alignment import Interval
from phonanim.speech.labels import is_silent

SUMMARY = "plot of the liveliest curves under waveform, words and phones"
PAPER, PANEL, GRID = (252, 252, 253), (232, 235, 240), (214, 218, 226)
INK, FAINT, WAVE_INK = (20, 22, 28), (92, 99, 112), (122, 136, 160)
COLORS: tuple[Color, ...] = (  # told apart by colour-blind readers (Okabe and Ito 2008)
    (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (184, 120, 0), (46, 140, 196),
)  # fmt: skip
GUTTER, MARGIN, TITLE, WAVE, LABELS, LANE, RULER = 170, 24, 40, 70, 24, 52, 26  # pixels
PIXELS_PER_SECOND, NARROWEST, WIDEST = 260, 900, 8000
STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0)  # seconds between marks
MARK_ROOM = 60  # pixels
LOWEST_SCALE = 0.1
STILL = 1e-3  # a curve with less motion is not shown
TURN = 20.0  # degrees of the head that count as much as full weight of a control
SIDE = re.compile(r"Left|Right|left|right|(?<=[a-z_.])[LR](?=$|[_.])|(?<=[_.])[lr](?=$|[_.])")
SAME = 0.02  # a left and a right curve with less between them share a lane


@dataclass(frozen=True)
class Axis:
    """Time across the picture: `start` to `end` seconds over `width` pixels from column `left`."""

    start: float
    end: float
    left: int
    width: int

    def x(self, time: float) -> float:
        """The column of a time."""
        return self.left + (time - self.start) / (self.end - self.start) * self.width

    def times(self) -> NDArray[np.float64]:
        """The time at the edges of each column, (width + 1,)."""
        return np.linspace(self.start, self.end, self.width + 1)


def write(animation: Animation, path: Path, lanes: int = 12) -> None:
    """Draw the `lanes` channels that move most: controls on one scale, turns of the head on another.

    The two sides of a face are one lane where they move alike.

    Raises AudioError or MissingExtraError when there is a recording that cannot be read, OutputError when
    the destination cannot be written.
    """
    names = most_moving_channels(animation, lanes)
    axis = _axis(animation)
    sound = read_audio(animation.audio) if animation.audio else None
    height = 2 * MARGIN + TITLE + (WAVE if sound else 0) + 2 * LABELS + LANE * len(names) + RULER
    image = np.full((height, axis.left + axis.width + MARGIN, 3), PAPER, np.uint8)
    y = draw_title(image, animation)
    draw_ruler(image, axis, y)
    if sound:
        draw_wave(image, axis, y, *sound)
        y += WAVE
    y = draw_labels(image, axis, y, animation.words)
    y = draw_labels(image, axis, y, animation.phones)
    scales = {turns: _scale(animation, [n for n in names if is_turn(n) == turns]) for turns in (True, False)}
    for place, name in enumerate(names):
        scale = scales[is_turn(name)]
        draw_lane(image, axis, y + place * LANE, animation, name, COLORS[place % len(COLORS)], scale)
    write_png(image, path)


def _scale(animation: Animation, names: list[str]) -> tuple[float, float]:
    """The least and the greatest value of some channels, zero included."""
    shown = np.stack([animation.channel(name) for name in names]) if names else np.zeros((1, 1))
    return min(0.0, float(shown.min())), max(LOWEST_SCALE, float(shown.max()))


def most_moving_channels(animation: Animation, count: int) -> list[str]:
    """The channels with the widest range, the widest first; equal ones in the rig's order.

    Of a left and a right channel that move alike, the first is returned.
    """
    ranges = np.ptp(animation.values, axis=0)
    ranges = ranges / np.array([TURN if is_turn(name) else 1.0 for name in animation.channels])
    found: list[str] = []
    for i in np.argsort(-ranges, kind="stable"):
        name = animation.channels[i]
        if len(found) == count or ranges[i] <= STILL:
            break
        if not any(move_alike(animation, name, other) for other in found):
            found.append(name)
    return found


def move_alike(animation: Animation, name: str, other: str) -> bool:
    """Whether two channels are the left and the right of one control, and follow the same curve."""
    if name == other or SIDE.sub("", name) != SIDE.sub("", other):
        return False
    apart = np.abs(animation.channel(name) - animation.channel(other)).max()
    return bool(apart < SAME)


def lane_name(animation: Animation, name: str) -> str:
    """The name of a channel; without its side if the lane stands for both sides."""
    both = any(move_alike(animation, name, other) for other in animation.channels)
    return f"{SIDE.sub('', name)} L R" if both else name


def _axis(animation: Animation) -> Axis:
    labels = (*animation.words, *animation.phones)
    times = animation.times
    end = max(float(times[-1]), float(times[0]) + 1 / animation.fps, *(label.end for label in labels), 0.0)
    start = min(float(times[0]), 0.0)
    width = int(np.clip((end - start) * PIXELS_PER_SECOND, NARROWEST, WIDEST))
    return Axis(start, end, MARGIN + GUTTER, width)


def draw_title(image: Image, animation: Animation) -> int:
    """The name of the line; returns the row below."""
    name = str(animation.provenance.get("input", animation.rig))
    facts = f"{animation.rig} · {animation.fps:g} fps · {len(animation.values) / animation.fps:.2f} s"
    right = image.shape[1] - MARGIN
    draw_text(image, facts, right, MARGIN - 3, FAINT, align=1.0)
    room = right - MARGIN - text_width(facts) - 10
    draw_text(image, shortened(name, room, "large"), MARGIN, MARGIN - 6, INK, "large")
    return MARGIN + TITLE


def draw_ruler(image: Image, axis: Axis, top: int) -> None:
    """Lines at round times through all lanes, and the times at the bottom."""
    per_pixel = (axis.end - axis.start) / axis.width
    step = next((s for s in STEPS if s / per_pixel > MARK_ROOM), STEPS[-1])
    bottom = image.shape[0] - MARGIN - RULER
    for mark in np.arange(np.ceil(axis.start / step), np.floor(axis.end / step) + 1) * step:
        fill(image, axis.x(mark), top, 1, bottom - top, GRID)
        draw_text(image, f"{mark:g} s", axis.x(mark), bottom + 6, FAINT, align=0.5)


def draw_wave(image: Image, axis: Axis, top: int, samples: NDArray[np.float32], rate: int) -> None:
    """The range of the samples in each column, scaled so that the loudest fills the strip."""
    edges = np.clip((axis.times() * rate).astype(int), 0, len(samples))
    peak = max(float(np.abs(samples).max()), 1e-6)
    middle, half = top + WAVE / 2, WAVE / 2 - 4
    for column, (first, last) in enumerate(pairwise(edges)):
        piece = samples[first:last] if last > first else np.zeros(1, np.float32)
        high, low = (float(v) / peak * half for v in (piece.max(), piece.min()))
        fill(image, axis.left + column, middle - high, 1, max(1.0, high - low), WAVE_INK)


def draw_labels(image: Image, axis: Axis, top: int, intervals: tuple[Interval, ...]) -> int:
    """A box per label; returns the row below, which is `top` when there are none."""
    for interval in intervals:
        if is_silent(interval.label):
            continue
        left, right = round(axis.x(interval.start)), round(axis.x(interval.end))
        fill(image, left + 1, top + 1, right - left - 1, LABELS - 2, PANEL)
        if text_width(interval.label) < right - left:
            draw_text(image, interval.label, (left + right) / 2, top + 5, INK, align=0.5)
    return top + LABELS if intervals else top


def draw_lane(
    image: Image,
    axis: Axis,
    top: int,
    animation: Animation,
    name: str,
    color: Color,
    scale: tuple[float, float],
) -> None:
    """One curve, filled down to zero, with its name and range on the left."""
    values = animation.channel(name).astype(float)
    low, high = scale
    curve = np.append(np.interp(axis.times(), animation.times, values), 0.0)
    *rows, zero = top + 6 + (LANE - 12) * (high - curve) / (high - low)
    blend_curve(image[:, axis.left : axis.left + axis.width], np.array(rows), float(zero), color)
    fill(image, axis.left, zero, axis.width, 1, GRID)
    draw_text(image, shortened(lane_name(animation, name), GUTTER - 12), MARGIN, top + 8, color)
    unit = "°" if is_turn(name) else ""
    draw_text(image, f"{values.min():.2f} to {values.max():.2f}{unit}", MARGIN, top + 26, FAINT)


def blend_curve(image: Image, rows: NDArray[np.float64], rest: float, color: Color) -> None:
    """Draw an anti-aliased line of two pixels on a picture, and a tint between it and `rest`.

    `rows` (width + 1,) are the heights of the line at the columns' edges.
    """
    upper, lower = np.minimum(rows[:-1], rows[1:]), np.maximum(rows[:-1], rows[1:])
    top = max(0, int(min(upper.min(), rest)) - 2)
    bottom = min(len(image), int(max(lower.max(), rest)) + 3)
    row = np.arange(top, bottom)[:, None] + 0.5
    outside = np.maximum(np.maximum(upper - row, row - lower), 0)
    slope = np.abs(rows[1:] - rows[:-1])
    line = np.clip(1.5 - outside / np.sqrt(1 + slope**2), 0, 1)
    middle = (upper + lower) / 2
    inside = (row > np.minimum(middle, rest)) & (row < np.maximum(middle, rest))
    amount = np.maximum(line, 0.22 * inside)[..., None]
    piece = image[top:bottom]
    piece[:] = np.rint(piece + amount * (np.array(color) - piece))
