"""Mouths of any model in each way that it can be moved: by its lips alone, and with articulation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import CHANNELS, Articulation
from phonanim.articulation.blend import blend_articulation, blend_channels, lip_channels
from phonanim.articulation.from_audio import (
    AudioArticulation,
    can_predict_articulation,
    fit_audio_articulation,
)
from phonanim.articulation.table import Targets
from phonanim.core.catalog import DEFAULT_MODEL
from phonanim.corpus.corpus import Corpus
from phonanim.evaluation.legibility import Reading
from phonanim.evaluation.surfaces import landmark_lips
from phonanim.face import contacts
from phonanim.face.model import FaceModel
from phonanim.media.audio import Sound, read_sound
from phonanim.pipeline import load_model
from phonanim.regressors import Model
from phonanim.rig import load_rig
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.retarget import retarget
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Curves = dict[str, Array]
ArticulationOf = Callable[[Model], AudioArticulation | None]
CHIN = 152  # MediaPipe's number
ALONE, BY_PHONES, BY_SOUND = "lips alone", "phones", "sound"


@dataclass(frozen=True)
class Line:
    """Something said: phones, instants (frames,) seconds, and its sound if there is one."""

    track: PhoneTrack
    times: Array
    sound: Sound | None


@dataclass(frozen=True)
class Mouth:
    """A mouth that says a line: `curves` of channels (frames,) mm, and ARKit `values` (frames, controls)."""

    curves: Curves
    values: NDArray[np.float32]


def mouths(
    model: Model, line: Line, articulation: AudioArticulation | None, targets: Targets
) -> dict[str, Mouth]:
    """One model's mouth in each way that it can be moved."""
    rig, face = load_rig("arkit"), load_model(DEFAULT_MODEL).face  # the rig knows the modes of this face
    shown = model.face.instance(model.regressor.predict(line.track, line.times, line.sound))
    modes = face.project(shown).astype(np.float32)
    closed = contacts.enforce_lip_contacts(modes, line.track, face, line.times)
    shapes, rest = face.instance(closed), contacts.closed_shape(face)
    alone = retarget(closed, face, rig, "auto", line.track, line.times)
    found = {ALONE: Mouth(face_curves(shapes, face), alone)}
    ways = {BY_PHONES: blend_articulation(shapes, face, rest, line.track, line.times, targets=targets)}
    if articulation is not None and line.sound is not None:
        seen = face.instance(modes)  # without closures, which need phones
        said, silent, rounded = articulation.at(line.sound, line.times)
        ways[BY_SOUND] = Articulation(blend_channels(said, seen, face, rest, silent, rounded))
    for way, moved in ways.items():
        values = retarget(closed, face, rig, "auto", line.track, line.times, articulation=moved)
        found[way] = Mouth({name: moved.channel(name) for name in CHANNELS}, values)
    return found


def face_curves(shapes: Array, face: FaceModel) -> Curves:
    """Channels that a learned face shows; its jaw is the chin."""
    return lip_channels(shapes, face) | {"jaw": -shapes[:, face.landmark(CHIN), 1]}


def head_lips(values: NDArray[np.float32]) -> Curves:
    """Lip curves of the shipped head, moved by ARKit controls."""
    head, spots = load_head(), shipped_landmarks()
    weights = head.weights(values, load_rig("arkit").controls)
    points = spots.of(head.vertices) + np.tensordot(weights, spots.of(head.deltas), axes=1)
    return landmark_lips(1000 * points, spots.numbers)


def listener(corpus: Corpus) -> ArticulationOf:
    """Articulation from sound for an audio-driven model, fitted once for each encoder."""

    @lru_cache(maxsize=4)
    def fitted(encoder: str) -> AudioArticulation:
        clips = corpus.clips_of("train").tolist()
        sounds = ((corpus.tracks[c], corpus.times(c), read_sound(corpus.audio[c])) for c in clips)
        return fit_audio_articulation(encoder, sounds)

    def articulation_of(model: Model) -> AudioArticulation | None:
        encoder = getattr(model.regressor.config, "encoder", "")
        predicts = model.regressor.input_modality == "audio" and can_predict_articulation(encoder)
        return fitted(encoder) if predicts else None

    return articulation_of


def pooled(readings: list[Reading]) -> Reading:
    """The phones of several lines together."""
    parts = ("right", "log_p", "said")
    return Reading(*(np.concatenate([getattr(one, part) for one in readings]) for part in parts))
