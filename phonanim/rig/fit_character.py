"""Fit a rig to a character: find its speech shapes, and measure what they do."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from phonanim.errors import RigError
from phonanim.face.model import OUTER_LIPS, FaceModel
from phonanim.rig.face_points import complete_landmarks
from phonanim.rig.fit import fit_rig
from phonanim.rig.head import TONGUE, Head, load_head
from phonanim.rig.landmark_rig import LandmarkRig, control_partners, make_landmark_rig
from phonanim.rig.landmarks import MARK, MeshLandmarks, shipped_landmarks
from phonanim.rig.measuring import ALWAYS, ARKIT, SHAPE, measure
from phonanim.rig.morphs import plain_name
from phonanim.rig.motion import read_motion
from phonanim.rig.names import known_controls
from phonanim.rig.read import load_rig
from phonanim.rig.register import suggest_landmarks
from phonanim.rig.rig import Rig

# Shapes that move the lips but are not speech.
MOODS = frozenset({"happy", "angry", "sad", "relaxed", "surprised", "joy", "sorrow", "fun", "cheekpuff"})
LEAST_MOTION = 1.0  # mm of some lip point: a shape that moves less is not a speech shape
CANCELLING = 0.5  # of the two sides' motion: less remains where the sides cancel each other
ENOUGH_STEMS = 6  # share of the controls of the preset's mouth
EFFORT = 3.0  # mm², effort of any other shape at full weight
# Visemes by the names of Oculus, VRChat, VRM and VRoid, or by those that a table of names leads to: in sum at
# most 1.
VISEME = re.compile(
    r"(viseme|v|fclmth|mth)?(sil|pp|ff|th|dd|kk|ch|ss|nn|rr|aa|ih|ou|ee|oh|[aeiou])", re.IGNORECASE
)
SIDE = re.compile(r"(left|right)$")
OPENER = "jawopen"
ENOUGH_VISEMES = 5  # from which only visemes are used
ENOUGH_ARKIT = 10  # number of speech controls with ARKit's names from which only these are used


def fit_character(
    head: Head, face: FaceModel, name: str, spots: MeshLandmarks | None = None
) -> tuple[Rig, MeshLandmarks]:
    """A rig for a head with blendshapes, and its landmarks: suggested when not given, completed when few are.

    Raises RigError when the face cannot be found or no shape moves the lips.
    """
    arkit, head = load_rig("arkit"), head.without(TONGUE)
    if spots is None:
        spots = suggest_landmarks(load_head(), shipped_landmarks(), head)
    elif not set(face.indices.tolist()) <= set(spots.numbers.tolist()):
        spots = complete_landmarks(load_head(), shipped_landmarks(), head, spots)
    landmark_rig = make_landmark_rig(head, spots, face)
    rig = unfitted_rig(head, name, speech_controls(landmark_rig, face, arkit))
    mouth = measure(head, spots, face, speech_uses(rig.speech))
    return replace(fit_rig(rig, landmark_rig, face, read_motion().modes(face)), mouth=mouth), spots


def speech_uses(speech: tuple[str, ...]) -> dict[str, tuple[str, float]]:
    """When each control is used and its effort: ARKit's as in the preset, any other always.

    Weights of visemes add up to 1 at most.
    """
    stems = {SIDE.sub("", plain_name(name)): name for name in speech}
    known = {plain_name(name): uses for name, uses in ARKIT.items()}
    arkit = sum(stem in known for stem in stems) >= ENOUGH_STEMS
    own = {stem: (SHAPE if is_viseme(name) else ALWAYS, EFFORT) for stem, name in stems.items()}
    return {stem: known[stem] for stem in stems if stem in known} if arkit else own


def is_viseme(name: str) -> bool:
    """Whether a shape is a mouth of a sound, by its name."""
    return any(VISEME.fullmatch(known) for known in known_controls(name))


def unfitted_rig(head: Head, name: str, speech: tuple[str, ...]) -> Rig:
    """A head's shapes as controls from 0 to 1, not yet fitted."""
    zeros, ones = np.zeros(len(head.targets)), np.ones(len(head.targets))
    places = {plain_name(target): number for number, target in enumerate(head.targets)}
    rig = Rig(
        name, f"{name}, fitted", "phonanim rig fit", head.targets, zeros, ones, zeros, zeros, zeros[None][:0]
    )
    if "mouthclose" in places and "jawopen" in places:
        rig = replace(rig, at_most=((places["mouthclose"], places["jawopen"]),))
    return replace(rig, speech=speech)


def speech_controls(landmark_rig: LandmarkRig, face: FaceModel, arkit: Rig) -> tuple[str, ...]:
    """The speech controls: ARKit's by name, else visemes, else all that move the lips except for expressions.

    ARKit's are none without the one that opens the jaw. Pairs that pull the mouth to either side cancel each
    other and are left out. Raises RigError when no control is left.
    """
    known = {plain_name(name) for name in arkit.speech}
    named = tuple(name for name in landmark_rig.controls if plain_name(name) in known)
    if len(named) >= ENOUGH_ARKIT and OPENER in map(plain_name, named):
        return named
    lips = landmark_rig.shapes[:, face.rows(OUTER_LIPS)]
    both = lips + lips[control_partners(landmark_rig)]
    size = np.linalg.norm(lips, axis=(1, 2))
    moving = np.linalg.norm(lips, axis=2).max(axis=1) > LEAST_MOTION
    apart = np.linalg.norm(both, axis=(1, 2)) < CANCELLING * 2 * size
    chosen = tuple(
        name
        for name, speaks in zip(landmark_rig.controls, moving & ~apart, strict=True)
        if speaks and plain_name(name) not in MOODS
    )
    if not chosen:
        raise RigError(f"no shape of the head moves its lips; check its morph targets, or mark it: {MARK}")
    visemes = tuple(name for name in chosen if is_viseme(name))
    return visemes if len(visemes) >= ENOUGH_VISEMES else chosen
