"""The layer: the curves of all behaviours, and what of them a rig's controls take."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.life import blinks, breath, brows, gaze, head
from phonanim.life.shapes import fade
from phonanim.rig.morphs import plain_name
from phonanim.rig.rig import Rig, Through
from phonanim.speech.prosody import Prosody

Array = NDArray[np.float64]

BEHAVIOURS = ("blinks", "gaze", "head", "brows", "breath")
HEAD = ("headPitch", "headYaw", "headRoll")  # controls in degrees
BACK = 6.0  # seconds of the past that it looks at
ACROSS, RISE, SINK = 25.0, 20.0, 25.0  # degrees that the eyes turn at full weight of a control
LIDS = 0.35  # of the way down at which the upper lid follows eyes that look fully down
WIDE = 0.25  # how far the lids open for eyes that look fully up
OUTER = 0.8  # of the inner brow's height that the outer brow takes
SIDES = ("Left", "Right")
OURS = re.compile(
    r"eye(blink|look|wide|squint)|brow(inner|outer|down)|head(yaw|pitch|roll)|blink|look(up|down|left|right)$"
)
MOUTH = ("jawOpen", "noseSneerLeft", "noseSneerRight")  # what moves lips as well
# Controls of other names, as they read, and the ones of ARKit that they are the mean of.
ALIASES = {
    "blink": ("eyeBlinkLeft", "eyeBlinkRight"),
    "blinkleft": ("eyeBlinkLeft",),
    "blinkright": ("eyeBlinkRight",),
    "lookup": ("eyeLookUpLeft",),
    "lookdown": ("eyeLookDownLeft",),
    "lookleft": ("eyeLookOutLeft",),
    "lookright": ("eyeLookOutRight",),
}


@dataclass(frozen=True, slots=True)
class Life:
    """How much of each behaviour there is (1 if not named), by which seed, and where the listener is."""

    seed: int
    gains: Mapping[str, float] = field(default_factory=dict)
    look_at: tuple[float, float, float] | None = None
    blink_seed: int | None = None

    def gain(self, name: str) -> float:
        """The gain of a behaviour."""
        return self.gains.get(name, 1.0)


def life_curves(life: Life, prosody: Prosody, times: Array, turns_head: bool = True) -> dict[str, Array]:
    """Curves of ARKit's controls, offsets from rest by name, (frames,) each; those of HEAD in degrees.

    Where the head turns, the eyes turn back, so that they stay where they look.
    """
    soft = fade(times, prosody.duration, prosody.ahead)
    at = life.look_at or gaze.FRONT
    looks = gaze.look(life.seed, prosody, times, at)
    turned = head.turn(life.seed, prosody, times, (looks.onsets, looks.places), gaze.direction(at))
    turned = turned.scaled(soft * life.gain("head") * turns_head)
    eyes_left = life.gain("gaze") * (soft * looks.left - turned.yaw)
    eyes_up = life.gain("gaze") * (soft * looks.up + turned.pitch)
    shut = np.zeros(len(times))
    if life.gain("blinks") > 0:
        shifts = (looks.onsets, looks.sizes * life.gain("gaze"))
        seed = life.seed if life.blink_seed is None else life.blink_seed
        shut = np.minimum(blinks.closed(seed, prosody, times, shifts) * life.gain("blinks"), 1.0)
    inhale, chest = breath.inhaled(life.seed, prosody, times)
    inhale, chest = inhale * life.gain("breath"), chest * life.gain("breath")
    pitch = turned.pitch - breath.LIFT * inhale * turns_head
    return {
        **dict(zip(HEAD, (pitch, turned.yaw, turned.roll), strict=True)),
        **_eyes(eyes_left, eyes_up, shut),
        **_brows(life, prosody, times, soft, shut),
        "noseSneerLeft": breath.NOSTRILS * inhale,
        "noseSneerRight": breath.NOSTRILS * inhale,
        "jawOpen": breath.JAW * inhale,
        "chest": breath.CHEST * chest,
    }


def _eyes(left: Array, up: Array, shut: Array) -> dict[str, Array]:
    """Eyes and lids, from degrees to the left and up and how far the lids are shut."""
    outer, inner = np.clip(left / ACROSS, 0, 1), np.clip(-left / ACROSS, 0, 1)
    high, low = np.clip(up / RISE, 0, 1), np.clip(-up / SINK, 0, 1)
    lids = shut + (1 - shut) * LIDS * low
    curves = {
        "eyeLookOutLeft": outer,
        "eyeLookInRight": outer,
        "eyeLookInLeft": inner,
        "eyeLookOutRight": inner,
    }
    for side in SIDES:
        curves[f"eyeLookUp{side}"] = high
        curves[f"eyeLookDown{side}"] = low
        curves[f"eyeBlink{side}"] = lids
        curves[f"eyeWide{side}"] = WIDE * high * (1 - shut)
        curves[f"eyeSquint{side}"] = blinks.SQUINT * shut
    return curves


def _brows(life: Life, prosody: Prosody, times: Array, soft: Array, shut: Array) -> dict[str, Array]:
    gain = life.gain("brows") * soft
    up = gain * brows.raised(life.seed, prosody, times)
    down = gain * brows.lowered(life.seed, prosody, times) + blinks.BROW * shut
    outer = {f"browOuterUp{side}": OUTER * up for side in SIDES}
    return {"browInnerUp": up, **outer, **{f"browDown{side}": down for side in SIDES}}


def add_life(
    values: NDArray[np.float32],
    rig: Rig,
    life: Life,
    prosody: Prosody,
    times: Array,
    freedom: Array | None = None,
) -> NDArray[np.float32]:
    """Add the layer to controls, (frames, controls) -> the same shape within the rig's limits.

    `freedom` (frames,), 0 to 1, is how much the mouth is free to move; without it, breath leaves it alone.
    Rigs of mouth shapes, and controls that the rig lacks, are left as they are.
    """
    if not len(times) or not lively(rig):
        return values
    base = rig.through.rig if rig.through else rig
    columns = {plain_name(name): column for column, name in enumerate(base.controls)}
    curves = life_curves(
        life, prosody, times, turns_head=plain_name(HEAD[0]) in map(plain_name, rig.controls)
    )
    offsets = np.zeros((len(times), len(base.controls)))
    for name, curve in curves.items():
        if plain_name(name) in columns:
            free = (0.0 if freedom is None else freedom) if name in MOUTH else 1.0
            offsets[:, columns[plain_name(name)]] = curve * free
    for name, sources in ALIASES.items():
        if name in columns:
            offsets[:, columns[name]] = np.mean([curves[source] for source in sources], axis=0)
    return limited(values, offsets if rig.through is None else offsets @ own_table(rig.through), rig)


def lively(rig: Rig) -> bool:
    """Whether a rig has a control that life moves; rigs of mouth shapes have none."""
    base = rig.through.rig if rig.through else rig
    return rig.visemes is None and any(OURS.match(plain_name(name)) for name in base.controls)


def own_table(through: Through) -> Array:
    """How controls of the rig behind move a rig's own, but for shares, which are of the speech alone."""
    table = through.table.copy()
    table[:, [share for share, _, _ in through.shares]] = 0.0
    return table


def limited(values: NDArray[np.float32], offsets: Array, rig: Rig) -> NDArray[np.float32]:
    """Controls with offsets within the limits; what has no offset stays as it was, to the bit."""
    moved = offsets.any(axis=0)
    result = values.copy()
    added = np.clip(values[:, moved] + offsets[:, moved], rig.minimum[moved], rig.maximum[moved])
    result[:, moved] = np.where(offsets[:, moved] == 0, values[:, moved], added)
    for low, high in rig.at_most:
        result[:, low] = np.minimum(result[:, low], result[:, high])
    return result
