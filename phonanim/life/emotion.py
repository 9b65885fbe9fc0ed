"""Emotions set by the user: poses of lexicon/emotions that fade in, blend and fade out over spans of a line.

The poses are basic emotions in action units (Ekman and Friesen 1978, Facial Action Coding System). A rig uses
the controls that it has. Speech has priority at the mouth, as with overlays.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON
from phonanim.options import Emotion
from phonanim.rig.morphs import plain_name
from phonanim.rig.rig import Rig
from phonanim.speech.prosody import eased

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Array = NDArray[np.float64]

FOLDER = LEXICON / "emotions"
BLEND = 0.6  # seconds of the transition between emotions, half of them before the instant


@cache
def emotion_names() -> tuple[str, ...]:
    """The names of the emotions."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


@cache
def emotion_pose(name: str) -> dict[str, float]:
    """The controls of an emotion at full weight, by ARKit's names in their plain form."""
    with (FOLDER / f"{name}.toml").open("rb") as file:
        return {plain_name(control): float(value) for control, value in tomllib.load(file).items()}


def weight(emotion: Emotion, times: Array) -> Array:
    """The weight of an emotion at instants, (frames,) seconds -> (frames,)."""
    if emotion.span is None:
        return np.full(len(times), emotion.weight)
    start, end = emotion.span
    rising = eased((times - start) / BLEND + 0.5)
    return np.asarray(emotion.weight * rising * eased((end - times) / BLEND + 0.5))


def emotion_offsets(emotions: Sequence[Emotion], rig: Rig, times: Array) -> Array:
    """What emotions add to a rig's controls, (frames, controls); of overlapping spans, the maximum."""
    offsets = np.zeros((len(times), len(rig.controls)))
    names = [plain_name(name) for name in rig.controls] if emotions else []
    for name in dict.fromkeys(emotion.name for emotion in emotions):
        most: Array | None = None
        for emotion in (emotion for emotion in emotions if emotion.name == name):
            own = weight(emotion, times)
            most = own if most is None else np.maximum(most, own, out=most)
        pose = emotion_pose(name)
        moved = np.array([pose.get(control, 0.0) for control in names])
        offsets += np.asarray(most)[:, None] * moved
    return offsets
