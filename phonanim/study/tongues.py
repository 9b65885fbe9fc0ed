"""Takes that differ in the tongue alone: its own, of another line, still (Medina 2023, section 3.3.3)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.errors import StudyError
from phonanim.exporters import load
from phonanim.media.audio import find_audio
from phonanim.pipeline import load_cached_rig
from phonanim.rig.read import rig_names

TONGUE = re.compile("tongue", re.IGNORECASE)
SYSTEMS = ("tongue", "mismatch", "null")
STILL = 1e-3  # largest change of a control that does not move


def load_with_sound(path: Path, sounds: Path | None = None) -> Animation:
    """A line with its recording: the one of the same stem in `sounds`, else beside the line.

    Raises StudyError where a line that had a recording has none now.
    """
    line = load(path)
    found = find_audio(sounds / path.name) if sounds else None
    found = found or find_audio(path) or line.audio
    if found is not None and not found.is_file():
        raise StudyError(f"{path}: its recording {found.name} is not beside it; name its folder by --sounds")
    return replace(line, audio=found)


def tongue_takes(animation: Animation, other: Animation) -> Mapping[str, Animation]:
    """Three takes of a line by SYSTEMS: its own tongue, that of another line, and none.

    The other tongue is stretched to the length of the line. The rest of the face is the same in all, and the
    jaw carries every tongue. Raises StudyError when a tongue does not move, or the lines have other channels.
    """
    rows = tongue_channels(animation)
    if other.channels != animation.channels:
        raise StudyError(
            f"two lines have other channels ({animation.rig}, {other.rig}); give lines of one rig"
        )
    return {
        "tongue": animation,
        "mismatch": with_tongue(animation, rows, stretch(other.values[:, rows], len(animation.values))),
        "null": with_tongue(animation, rows, np.tile(rest_of(animation)[rows], (len(animation.values), 1))),
    }


def tongue_channels(animation: Animation) -> NDArray[np.int64]:
    """The channels of the tongue, by their names. Raises StudyError when none of them moves."""
    rows = np.array([n for n, name in enumerate(animation.channels) if TONGUE.search(name)], np.int64)
    if len(rows) == 0 or float(np.ptp(animation.values[:, rows], axis=0).max()) < STILL:
        raise StudyError(
            f"the tongue of the rig {animation.rig} does not move; animate the lines with --rig arkit_tongue"
        )
    return rows


def with_tongue(animation: Animation, rows: NDArray[np.int64], curves: NDArray[np.floating]) -> Animation:
    """The animation with other curves of the tongue, (frames, rows)."""
    values = animation.values.copy()
    values[:, rows] = curves
    return replace(animation, values=values)


def stretch(curves: NDArray[np.floating], frames: int) -> NDArray[np.float64]:
    """Curves in another number of frames, from their first to their last, (before, n) -> (frames, n)."""
    places = np.linspace(0, len(curves) - 1, frames)
    return np.stack([np.interp(places, np.arange(len(curves)), curve) for curve in curves.T], axis=1)


def rest_of(animation: Animation) -> NDArray[np.floating]:
    """The value of each channel at rest: the rig's, or 0 for an unknown rig."""
    if animation.rig in rig_names():
        rig = load_cached_rig(animation.rig)
        known = dict(zip(rig.controls, rig.rest, strict=True))
        return np.array([known.get(name, 0.0) for name in animation.channels])
    return np.zeros(len(animation.channels))


def partners(count: int) -> Sequence[int]:
    """The line whose tongue each line gets: the next one, and the first for the last."""
    if count < 2:
        raise StudyError("a tongue of another line needs two lines or more")
    return [(number + 1) % count for number in range(count)]
