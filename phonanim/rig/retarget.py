"""Motion -> a rig's controls: articulation solved on its mouth, or a map from the reference face's modes.

The maps are the eight poses of Taylor 2017, section 6, or a finer one.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import Articulation, articulate
from phonanim.core.exact import sparse_product
from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.rig.accents import add_accents, read_accents
from phonanim.rig.measures import USES
from phonanim.rig.pronounce import pronounce
from phonanim.rig.reference import move_to_face
from phonanim.rig.rig import HingeMap, Rig, Through, pose_map
from phonanim.rig.tongue import place_tongue, read_tongue
from phonanim.rig.visemes import shape_weights, speak
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack

How = Literal["auto", "articulation", "poses", "direct", "solve"]
LEAST = 0.01  # controls below this count as zero in a share
BLOCK = 4096  # frames per block, so that their data fit in the cache


def retarget(
    modes: NDArray[np.floating],
    face: FaceModel,
    rig: Rig,
    how: How = "auto",
    track: PhoneTrack | None = None,
    times: NDArray[np.float64] | None = None,
    accents: bool = True,
    articulation: Articulation | None = None,
) -> NDArray[np.float32]:
    """Shape parameters of the reference face -> control values, (frames, m) -> (frames, controls).

    "articulation" solves the rig's own mouth for the `articulation` of these frames. "auto" does so where
    there is an articulation and the rig has mouth measures, else it uses the finest map of modes available.
    "poses" is Taylor 2017, equations 2 and 3; "direct" is the rig's own finer map; "solve" fits the landmarks
    of the rig's head, frame by frame. Rigs of mouth shapes choose shapes by the phones of `track` at `times`
    (frames,) seconds. Other rigs place their tongue by phones and, when moved by modes, add accents for what
    landmarks cannot show, unless `accents` is off. Values keep the rig's limits. Where the rig was made for
    the shipped face, the modes of any other face are first expressed in its modes, by their common landmarks.
    Raises RigError when the rig lacks the map or was made for a face that is neither.
    """
    if how in ("auto", "articulation") and articulation is not None and rig.speaks:
        return _articulated(articulation, rig, track, times)
    if how == "articulation":
        raise RigError(f"rig {rig.name} {_why_silent(rig)}")
    modes, face = move_to_face(modes, face, rig.face, f"rig {rig.name}")
    if rig.visemes is not None:
        return limit_controls(shape_weights(modes, face, rig, track, times), rig)
    if rig.through is not None:
        values = move_through(retarget(modes, face, rig.through.rig, how, track, times, accents), rig.through)
    else:
        values = _solved(modes, face, rig) if how == "solve" else _mapped(modes, face, rig, how)
    if track is not None and times is not None:
        values = _spoken(values, rig, track, times, accents)
    return limit_controls(values, rig)


def pronounce_on(
    articulation: Articulation, rig: Rig, track: PhoneTrack, times: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Controls of any rig by articulation alone, the tongue too, (frames, channels) mm -> (frames, controls).

    Raises RigError for a rig that articulation cannot move, and for one of mouth shapes without phones.
    """
    if not rig.speaks:
        raise RigError(f"rig {rig.name} {_why_silent(rig)}")
    through = rig.through.rig if rig.through else rig
    if through.visemes is not None and not track.codes.any():
        raise RigError(f"rig {rig.name} shows mouths of phones; give an alignment, or another --rig")
    return _articulated(articulation, rig, track, times)


def _articulated(
    articulation: Articulation, rig: Rig, track: PhoneTrack | None, times: NDArray[np.float64] | None
) -> NDArray[np.float32]:
    """Controls by articulation, and the tongue by phones."""
    if rig.articulated:
        columns = [articulation.channels.index(name) for name in rig.controls]
        return articulation.values[:, columns].astype(np.float32)
    if rig.visemes is not None:
        return limit_controls(speak(articulation, rig, track, times), rig)
    if rig.mouth is not None:
        values = pronounce(articulation, rig, rig.mouth)
    elif rig.through is not None:
        values = move_through(_articulated(articulation, rig.through.rig, track, times), rig.through)
    if track is not None and times is not None:
        values = _spoken(values, rig, track, times, False, articulation)
    return limit_controls(values, rig)


def _why_silent(rig: Rig) -> str:
    if rig.speaks:
        return "is moved by phones and needs an alignment; use --retarget auto"
    return "does not know the measures of its mouth; use --retarget auto, or phonanim rig fit"


def _spoken(
    values: NDArray[np.float32],
    rig: Rig,
    track: PhoneTrack,
    times: NDArray[np.float64],
    accents: bool,
    articulation: Articulation | None = None,
) -> NDArray[np.float32]:
    """Add what depends on phones to controls, in place: accents, and the tongue."""
    if accents and rig.accents is not None:
        values = add_accents(values, read_accents(rig.accents, rig.controls), track, times)
    if rig.tongue is not None:
        mouth = articulate(track, times) if articulation is None else articulation
        values = place_tongue(values, read_tongue(rig.tongue, rig.controls), mouth)
    return values


def _mapped(modes: NDArray[np.floating], face: FaceModel, rig: Rig, how: How) -> NDArray[np.float32]:
    mapping = _mapping(rig, how)
    standardized = (np.asarray(modes) / face.std).astype(np.float32)[:, : mapping.loads.shape[1]]
    if standardized.shape[1] != mapping.loads.shape[1]:
        raise RigError(
            f"rig {rig.name} maps {mapping.loads.shape[1]} modes and the model's face has {len(face.std)}; "
            "use the model that the rig was made for"
        )
    values = np.empty((len(standardized), len(rig.controls)), np.float32)
    for start in range(0, len(values), BLOCK):
        block = slice(start, start + BLOCK)
        values[block] = mapping(standardized[block])
    return values


def move_through(values: NDArray[np.float32], through: Through) -> NDArray[np.float32]:
    """Convert another rig's controls to this rig's, (frames, other's) -> (frames, own)."""
    own = sparse_product(values, through.table)
    for control, part, whole in through.shares:
        own[:, control] = values[:, part] / np.maximum(values[:, whole], LEAST)
    return own


def _mapping(rig: Rig, how: How) -> HingeMap:
    if rig.direct is not None and how != "poses":
        return rig.direct
    if how == "direct":
        raise RigError(
            f"rig {rig.name} has no direct map; use --retarget poses, or fit one: phonanim rig fit"
        )
    if not rig.posed:
        raise RigError(
            f"rig {rig.name} has no poses; use --retarget direct, or fill them in: phonanim rig new"
        )
    return pose_map(rig)


def _solved(modes: NDArray[np.floating], face: FaceModel, rig: Rig) -> NDArray[np.float32]:
    """Frame by frame on the rig's own head (Medina 2023, section 3.3)."""
    from phonanim.rig.character import load_character
    from phonanim.rig.landmark_rig import make_landmark_rig
    from phonanim.rig.landmarks import read_landmarks
    from phonanim.rig.motion import closed_face, read_motion
    from phonanim.rig.solve import solve

    if rig.head is None or rig.landmarks is None:
        raise RigError(f"rig {rig.name} has no head to solve on; use --retarget auto, or phonanim rig fit")
    landmark_rig = make_landmark_rig(load_character(rig.head), read_landmarks(rig.landmarks), face)
    closed = closed_face(face, read_motion().modes(face))
    return solve(face.instance(modes), face, landmark_rig, rig, closed).astype(np.float32)


def limit_sum(values: NDArray[np.float32], channels: tuple[str, ...], rig: Rig) -> NDArray[np.float32]:
    """Shapes that add up, such as visemes, in sum at most 1: all of a frame fall alike.

    (frames, channels) -> the same. Silence has the rest. Unchanged where a rig has no such shapes.
    """
    if rig.mouth is None:
        return values
    adding = rig.mouth.uses[:, USES.index("shared")]
    names = [name for group, adds in zip(rig.mouth.names, adding, strict=True) if adds for name in group]
    shared = np.isin(channels, names)
    total = values[:, shared].sum(axis=1, keepdims=True)
    limited = np.where(shared, values / np.maximum(total, 1.0), values).astype(np.float32)
    if rig.visemes is not None:
        silent = np.isin(channels, rig.controls[rig.visemes.of[INVENTORY.code(SILENCE), 0]])
        rest = np.clip(1.0 - limited[:, shared].sum(axis=1, keepdims=True), 0.0, 1.0)
        limited = np.where(silent, np.minimum(limited, rest), limited).astype(np.float32)
    return limited


def limit_controls(values: NDArray[np.float32], rig: Rig) -> NDArray[np.float32]:
    """Clip to the limits, in place; then limit controls that may not exceed another."""
    np.clip(values, rig.minimum.astype(np.float32), rig.maximum.astype(np.float32), out=values)
    for low, high in rig.at_most:
        np.minimum(values[:, low], values[:, high], out=values[:, low])
    return values
