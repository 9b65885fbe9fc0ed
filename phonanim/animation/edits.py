"""Edits: an animator's changes to a line, which are applied again when the line is made again.

An edit covers one span of one channel. It is anchored to the phones that were spoken there: where a new
alignment moves the phones, the times of the edit are warped in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.keys import reduce_curves
from phonanim.errors import OptionError
from phonanim.rig import Rig
from phonanim.rig.morphs import plain_name
from phonanim.rig.neck import TURNS
from phonanim.speech.alignment import Interval
from phonanim.speech.anchors import Anchors, match_takes
from phonanim.speech.labels import is_silent

Array = NDArray[np.float64]
Kind = Literal["offset", "replace"]

ERROR = 1e-3  # of full weight
FADE = 0.1  # seconds in which an edit fades in and out
MARGIN = 0.99  # share of the error for the keys; the rest is for rounding in files
ROUNDING = 1e-6  # seconds
MOST_STEPS = 300_000_000  # edits times frames and phones: 5000 edits of a line of ten minutes
HEAD = frozenset(map(plain_name, TURNS))


@dataclass(frozen=True, slots=True)
class Edit:
    """One channel from `start` to `end` (s): `values` at `times` (s), linear between, added or replacing.

    It fades in within `fade[0]` seconds of the start and out within `fade[1]` of the end. A fade of 0 is
    used where the line itself begins or ends.
    """

    channel: str
    kind: Kind
    start: float
    end: float
    fade: tuple[float, float]
    times: tuple[float, ...]
    values: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.channel} {self.start:.2f}-{self.end:.2f} s"


@dataclass(frozen=True, slots=True)
class Edits:
    """The edits of one line of a rig; they reproduce the edited curves within `error`.

    `phones` are the phones of the edited line; the times of the edits refer to them.
    """

    rig: str
    error: float
    phones: tuple[Interval, ...]
    edits: tuple[Edit, ...]


def diff_animations(
    base: Animation, edited: Animation, kind: Kind = "offset", error: float = ERROR, fade: float = FADE
) -> Edits:
    """The edits from one animation to the other: applied to `base`, they give `edited`.

    Differences up to `error` are ignored. Raises OptionError when the channels or the lengths differ.
    """
    _check_pair(base, edited)
    margin = max(round(fade * base.fps), 1)
    found = []
    for channel in (name for name in base.channels if name in edited.channels):
        before = base.channel(channel).astype(np.float64)
        after = _at(edited, channel, len(before), base.fps)
        curve = after - before if kind == "offset" else after
        for first, last in _groups(np.abs(after - before) > MARGIN * error, 2 * margin):
            found.append(_edit(base, channel, kind, curve, (first, last), margin, MARGIN * error))
    return Edits(base.rig, error, base.phones or edited.phones, tuple(found))


def apply_edits(
    animation: Animation, edits: Edits, rig: Rig, read: tuple[Interval, ...] = ()
) -> tuple[Animation, tuple[str, ...]]:
    """Apply the edits within the limits of the rig. Also returns a note for each edit that did not fit.

    Where the animation or the edits have no phones, edits keep their times. `read` are the phones of the line
    before they were corrected, which edits may have been made on.
    """
    _check_work(edits, animation)
    notes = []
    if edits.rig != animation.rig:
        notes.append(f"the edits were made on the rig {edits.rig}, this line moves {animation.rig}")
    known = set(animation.channels) & set(rig.controls)
    if foreign := sorted({edit.channel for edit in edits.edits} - known):
        notes.append(f"edits of {', '.join(foreign)} were left out: {rig.name} has no such channel")
    values = animation.values.astype(np.float64)
    anchors = match_takes(edits.phones, read, animation.phones or edits.phones)
    for edit in (edit for edit in edits.edits if edit.channel in known):
        if why := _misfit(edit, edits.phones, anchors, animation):
            notes.append(f"edit {edit} was left out: {why}")
            continue
        column = animation.channels.index(edit.channel)
        curve = _applied(edit, anchors, values[:, column], animation.times)
        values[:, column] = limited = _limited(curve, edit.channel, rig)
        if np.abs(curve - limited).max() > edits.error:
            notes.append(f"edit {edit} reaches beyond the limits of {rig.name} and was cut there")
    return animation.with_values(values.astype(np.float32)), tuple(notes)


def moved_edit(edit: Edit, anchors: Anchors) -> Edit:
    """An edit on the time of another take of its line."""
    start, full, less, end = anchors.moved(
        (edit.start, edit.start + edit.fade[0], edit.end - edit.fade[1], edit.end)
    ).tolist()
    times = tuple(anchors.moved(edit.times).tolist())
    return replace(edit, start=start, end=end, fade=(full - start, end - less), times=times)


def _check_work(edits: Edits, animation: Animation) -> None:
    """Raise OptionError for edits that would take long to apply."""
    steps = len(edits.edits) * (len(animation.values) + len(edits.phones))
    if steps > MOST_STEPS:
        raise OptionError(
            f"there are {len(edits.edits)} edits of {len(edits.phones)} phones for {len(animation.values)} "
            "frames, which is too much work; edit the line in parts"
        )


def _check_pair(base: Animation, edited: Animation) -> None:
    if odd := sorted(_moving(base, edited) | _moving(edited, base)):
        raise OptionError(f"only one of the two animations has {odd[0]}; compare two of the same rig")
    lengths = [(len(one.values) - 1) / one.fps for one in (base, edited)]
    if abs(lengths[0] - lengths[1]) > 1 / min(base.fps, edited.fps):
        raise OptionError(
            f"one animation lasts {lengths[0]:.2f} s and the other {lengths[1]:.2f} s; "
            "compare two of the same line"
        )


def _moving(animation: Animation, other: Animation) -> set[str]:
    """The channels that only one animation has and moves. Channels that a format or mesh lacks are 0.

    Turns of the head, which many formats lack, do not count.
    """
    return {
        name
        for name in animation.channels
        if name not in other.channels and plain_name(name) not in HEAD and animation.channel(name).any()
    }


def _at(animation: Animation, channel: str, frames: int, fps: float) -> Array:
    """A channel at frames of another rate, counted from its own start; end values are held."""
    curve = animation.channel(channel)
    return np.interp(np.arange(frames) / fps, np.arange(len(curve)) / animation.fps, curve)


def _groups(changed: NDArray[np.bool_], gap: int) -> Iterator[tuple[int, int]]:
    """First and last frame of each run of changes; a run may contain gaps of up to `gap` frames."""
    places = np.flatnonzero(changed)
    if len(places):
        for group in np.split(places, np.flatnonzero(np.diff(places) > gap) + 1):
            yield int(group[0]), int(group[-1])


def _edit(
    base: Animation, channel: str, kind: Kind, curve: Array, core: tuple[int, int], margin: int, error: float
) -> Edit:
    """The edit for one run of changes, with soft edges on the unchanged frames around it."""
    first, last = max(core[0] - margin, 0), min(core[1] + margin, len(curve) - 1)
    keys = reduce_curves(curve[first : last + 1, None], error)
    times = base.start + (first + keys.frames) / base.fps
    return Edit(
        channel=channel,
        kind=kind,
        start=float(times[0]),
        end=float(times[-1]),
        fade=((core[0] - first) / base.fps, (last - core[1]) / base.fps),
        times=tuple(times.tolist()),
        values=tuple(keys.values[:, 0].tolist()),
    )


def _misfit(edit: Edit, phones: tuple[Interval, ...], anchors: Anchors, animation: Animation) -> str:
    """Why an edit cannot be applied to this line, or "" if it can."""
    first, last = edit.start + edit.fade[0], edit.end - edit.fade[1]
    gone = [
        phone.label
        for place, phone in enumerate(phones)
        if place not in anchors.found
        and phone.start <= last
        and phone.end > first
        and not is_silent(phone.label)
    ]
    if gone:
        return f"{' '.join(gone)} is no longer spoken there"
    start, end = anchors.moved((edit.start, edit.end))
    line_start, line_end = animation.times[[0, -1]]
    if end < line_start - ROUNDING or start > line_end + ROUNDING:
        return f"it would be at {start:.2f} s, outside the line of {line_end:.2f} s"
    return ""


def _applied(edit: Edit, anchors: Anchors, curve: Array, times: Array) -> Array:
    weight = _weight(edit, anchors, times)
    change = np.interp(times, anchors.moved(edit.times), edit.values)
    return curve + weight * (change if edit.kind == "offset" else change - curve)


def _weight(edit: Edit, anchors: Anchors, times: Array) -> Array:
    """The weight of an edit at each time, 0 to 1.

    If an edit began at the start of its line and the line now starts earlier, it fades in before its start.
    The end is handled in the same way.
    """
    come, go = edit.fade
    start, full, less, end = anchors.moved((edit.start, edit.start + come, edit.end - go, edit.end))
    start, end = (start if come else start - FADE), (end if go else end + FADE)
    return np.interp(times, (start, full, less, end), (0.0, 1.0, 1.0, 0.0))


def _limited(curve: Array, channel: str, rig: Rig) -> Array:
    control = rig.controls.index(channel)
    return np.clip(curve, rig.minimum[control], rig.maximum[control])
