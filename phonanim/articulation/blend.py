"""Blend a learned face with phone targets: the face gives the timing, the targets separate the phones.

A landmark tracker cannot measure the jaw and, with one camera, hardly measures lip protrusion. These channels
and the upper lip therefore come from phones alone. Lip gap and width are the mean of the learned face and the
targets. In silence only the targets count, because a learned face at rest is not quite closed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS, Articulation
from phonanim.articulation.closures import enforce_contacts
from phonanim.articulation.table import Targets, read_targets
from phonanim.articulation.trajectories import articulate, kernel_sums
from phonanim.face.model import UPPER_LIP_INNER, FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.speech.gestures import GESTURES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

LEARNED = {"lip_gap": 0.45, "lip_width": 0.5}
"""Share of the learned face in each channel. Targets have the rest, and all of a channel not named here."""
ROUNDED_OWN = 0.7
"""Reduction of the learned face's share of the width in rounded gestures, which it rounds too little."""
CLEAR = 1.5  # mm between the lower lip and the teeth, at least, away from f and v
HUSH = 0.06  # seconds: the spread of silence in time


def blend_articulation(
    shapes: NDArray[np.floating],
    face: FaceModel,
    closed: Array,
    track: PhoneTrack,
    times: Array,
    contacts: bool = True,
    quickness: float = 1.0,
    targets: Targets | None = None,
) -> Articulation:
    """Articulation from a predicted face and phones, (frames, landmarks, 3) mm -> (frames, channels).

    `closed` (landmarks, 3) is the face at rest with closed lips; `times` (frames,) are rising seconds.
    Contacts of lips and teeth are enforced unless `contacts` is off. With more `quickness`, gestures begin
    and end faster. `targets` are those of the lexicon by default.
    """
    targets = targets or read_targets()
    if quickness != 1.0:
        targets = replace(targets, sigma=targets.sigma / quickness)
    values = articulate(track, times, targets, contacts=False).values
    silent, rounded = silence_and_rounding(track, times)
    values = blend_channels(values, shapes, face, closed, silent, rounded)
    if contacts:
        enforce_contacts(values, track, times)
    return Articulation(values)


def silence_and_rounding(track: PhoneTrack, times: Array) -> tuple[Array, Array]:
    """How silent and how rounded phones are around instants, (frames,) seconds -> (frames,) each, 0 to 1."""
    rounding = GESTURES.articulation[:, GESTURES.columns.index("rounding")].astype(np.float64)
    weights = np.stack([np.arange(len(rounding)) == GESTURES.names.index("sil"), rounding])
    silent, rounded = kernel_sums(track, times, HUSH, weights)
    return silent, rounded


def blend_channels(
    values: Array, shapes: NDArray[np.floating], face: FaceModel, closed: Array, silent: Array, rounded: Array
) -> Array:
    """Targets (frames, channels) mm with the learned lips of `shapes` blended in, as a new array.

    `silent` and `rounded` (frames,), 0 to 1, say where the learned lips count less.
    """
    blended = values.copy()
    seen, rest = lip_channels(shapes, face), lip_channels(closed[None], face)
    for name, most in LEARNED.items():
        place, share = CHANNELS.index(name), most * (1 - silent)
        if name == "lip_width":
            share *= 1 - ROUNDED_OWN * np.clip(rounded, 0, 1)
        blended[:, place] = share * (seen[name] - rest[name]) + (1 - share) * values[:, place]
    gap, teeth = CHANNELS.index("lip_gap"), CHANNELS.index("lower_lip_to_teeth")
    change = blended[:, gap] - values[:, gap]
    # The lower lip follows the gap, but does not reach the teeth where the phones do not ask for it.
    blended[:, teeth] = np.maximum(values[:, teeth] + change, np.minimum(values[:, teeth], CLEAR))
    return blended


def lip_channels(shapes: NDArray[np.floating], face: FaceModel) -> dict[str, Array]:
    """The channels that landmarks show, (frames, landmarks, 3) mm -> (frames,) each, not relative to rest."""
    upper = face.rows((UPPER_LIP_INNER,))[0]
    return {
        "lip_gap": lip_aperture(shapes, face),
        "lip_width": lip_width(shapes, face),
        "protrusion": lip_protrusion(shapes, face),
        "upper_lip": np.asarray(shapes[:, upper, 1], np.float64),
    }
