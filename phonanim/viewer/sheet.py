"""The contact sheet: the mouth at each phone of a line, in one picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.media.pixels import Image, draw_text, fill, paste, shortened, text_width, write_png
from phonanim.rig.head import Head, load_dressed_head
from phonanim.rig.portrait import load_portrait
from phonanim.rig.render import View, lower_face, render
from phonanim.speech.alignment import Interval
from phonanim.speech.labels import is_silent

MARGIN, GAP, TITLE, CAPTION = 24, 10, 40, 62  # pixels
PAPER, INK, FAINT, ACCENT = (252, 252, 253), (20, 22, 28), (92, 99, 112), (213, 94, 0)


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture of the sheet: a frame of the animation, and its label ("" for silence)."""

    frame: int
    time: float
    phone: str
    word: str


def save_sheet(
    animation: Animation,
    path: Path,
    character: Path | None = None,
    pictures: int = 40,
    columns: int = 8,
    size: int = 170,
) -> None:
    """Draw the lower face at the middle of each phone, at most `pictures` of them, and write a PNG.

    If a line has more phones, evenly spaced ones are shown; without phones, evenly spaced frames.
    `character` is a GLB or VRM to draw, from its hair to its chin, in place of the shipped head. Raises
    RigError when the head has none of the channels, OutputError when the file cannot be written.
    """
    head = load_dressed_head()
    view = lower_face(head, size)
    if character is not None:
        portrait = load_portrait(character, animation.channels, size, size, view.yaw)
        head, view = portrait.head, portrait.view
    shots = choose_shots(animation, pictures)
    frames = animation.values[[shot.frame for shot in shots]]
    shapes = head.shape(head.weights(frames, animation.channels))
    columns = max(1, min(columns, len(shots)))
    write_png(compose_sheet(animation, shots, shapes, head, view, columns), path)


def choose_shots(animation: Animation, count: int) -> list[Shot]:
    """The instants to show, at most `count`, in order."""
    spoken = [phone for phone in animation.phones if not is_silent(phone.label)]
    if spoken:
        middles = np.array([(phone.start + phone.end) / 2 for phone in spoken])
        frames = np.rint((middles - animation.start) * animation.fps)
    else:
        frames = np.arange(len(animation.values))
    kept = np.unique(np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int))
    chosen = np.clip(frames[kept], 0, len(animation.values) - 1).astype(int)
    labels = [spoken[i].label if spoken else "" for i in kept]
    times = animation.times[chosen]
    words = [label_at(animation.words, time) for time in (middles[kept] if spoken else times)]
    return [Shot(int(f), float(t), p, w) for f, t, p, w in zip(chosen, times, labels, words, strict=True)]


def label_at(intervals: tuple[Interval, ...], time: float) -> str:
    """The label of the interval at an instant, "" without one or in silence."""
    label = next((i.label for i in intervals if i.start <= time < i.end), "")
    return "" if is_silent(label) else label


def compose_sheet(
    animation: Animation,
    shots: list[Shot],
    shapes: NDArray[np.float64],
    head: Head,
    view: View,
    columns: int,
) -> Image:
    """The whole sheet, (height, width, 3)."""
    rows = -(-len(shots) // columns)
    step = (view.width + GAP, view.height + CAPTION)
    width = 2 * MARGIN + columns * step[0] - GAP
    sheet = np.full((MARGIN + TITLE + rows * step[1], width, 3), PAPER, np.uint8)
    draw_title(sheet, animation)
    for number, (shot, shape) in enumerate(zip(shots, shapes, strict=True)):
        row, column = divmod(number, columns)
        x, y = MARGIN + column * step[0], MARGIN + TITLE + row * step[1]
        paste(sheet, render(shape, head, view), x, y)
        draw_text(sheet, shot.phone, x + 2, y + view.height + 5, INK, "large")
        draw_text(sheet, f"{shot.time:.2f} s", x + view.width - 2, y + view.height + 9, FAINT, align=1.0)
        if column == 0:
            draw_words(sheet, shots[number : number + columns], x, y + view.height + 30, step[0])
    return sheet


def draw_title(sheet: Image, animation: Animation) -> None:
    """The title: the file on the left, the figures on the right."""
    name = str(animation.provenance.get("input", animation.audio.name if animation.audio else ""))
    seconds = len(animation.values) / animation.fps
    facts = f"{animation.rig} · {animation.fps:g} fps · {seconds:.2f} s"
    right = sheet.shape[1] - MARGIN
    draw_text(sheet, facts, right, MARGIN - 3, FAINT, align=1.0)
    room = right - MARGIN - text_width(facts) - GAP
    draw_text(sheet, shortened(name, room, "large"), MARGIN, MARGIN - 6, INK, "large")


def draw_words(sheet: Image, shots: list[Shot], x: int, y: int, step: int) -> None:
    """A bar below the pictures of a word, and the word in its middle."""
    first = 0
    for last in range(1, len(shots) + 1):
        if last < len(shots) and shots[last].word == shots[first].word:
            continue
        left, width = x + first * step, (last - first) * step - GAP
        if shots[first].word:
            fill(sheet, left, y, width, 2, ACCENT)
            word = shortened(shots[first].word, width)
            draw_text(sheet, word, left + width / 2, y + 5, ACCENT, align=0.5)
        first = last
