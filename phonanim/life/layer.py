"""The life layer: the curves of all behaviours, applied to a rig's controls."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.overlay import MOUTH, SHARE, limited, overlay_weight, own_table
from phonanim.animation.style import is_stepped_rig
from phonanim.core.exact import sparse_product
from phonanim.errors import OptionError
from phonanim.life import blinks, breath, brows, gaze, head
from phonanim.life.chance import seed_of
from phonanim.life.emotion import emotion_names, emotion_offsets, emotion_pose
from phonanim.life.shapes import fade
from phonanim.options import Emotion, Options
from phonanim.rig.morphs import plain_name
from phonanim.rig.neck import TURNS
from phonanim.rig.rig import Rig
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.prosody import Prosody

Array = NDArray[np.float64]

BEHAVIOURS = ("blinks", "gaze", "head", "brows", "breath")
BACK = 6.0  # seconds of the past that it uses
ACROSS, RISE, SINK = 25.0, 20.0, 25.0  # degrees of an eye turn at full weight of a control
LIDS = 0.12  # extra lid closure for eyes that look fully down
LOWERED = 0.3  # lid closure that looking fully down itself causes, 1 is shut
WIDE = 0.25  # lid opening for eyes that look fully up
OUTER = 0.8  # share of the inner brow's height that the outer brow follows
SIDES = ("Left", "Right")
OURS = re.compile(
    r"eye(blink|look|wide|squint)|brow(inner|outer|down)|head(yaw|pitch|roll)|blink|look(up|down|left|right)$"
)
# Controls with other names, in plain form, and the ARKit controls whose mean they take.
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
    """The gain of each behaviour (1 if not named), the seed, and the position of the listener."""

    seed: int
    gains: Mapping[str, float] = field(default_factory=dict)
    look_at: tuple[float, float, float] | None = None
    blink_seed: int | None = None
    emotions: tuple[Emotion, ...] = ()

    def gain(self, name: str) -> float:
        """The gain of a behaviour."""
        return self.gains.get(name, 1.0)

    def moves(self, rig: Rig) -> bool:
        """Whether it changes any control of a rig."""
        alive = bool(self.emotions) or any(self.gain(name) > 0 for name in BEHAVIOURS)
        return alive and lively(rig)


def life_curves(life: Life, prosody: Prosody, times: Array, turns_head: bool = True) -> dict[str, Array]:
    """Curves of ARKit's controls, offsets from rest by name, (frames,) each; those of TURNS in degrees.

    When the head turns, the eyes turn back, so that they keep looking at the same place.
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
        **dict(zip(TURNS, (pitch, turned.yaw, turned.roll), strict=True)),
        **_eyes(eyes_left, eyes_up, shut),
        **_brows(life, prosody, times, soft, shut),
        "noseSneerLeft": breath.NOSTRILS * inhale,
        "noseSneerRight": breath.NOSTRILS * inhale,
        "jawOpen": breath.JAW * inhale,
        "chest": breath.CHEST * chest,
    }


def _eyes(left: Array, up: Array, shut: Array) -> dict[str, Array]:
    """Curves of eyes and lids, from gaze in degrees to the left and up and the closure of the lids."""
    outer, inner = np.clip(left / ACROSS, 0, 1), np.clip(-left / ACROSS, 0, 1)
    high, low = np.clip(up / RISE, 0, 1), np.clip(-up / SINK, 0, 1)
    lids = shut * (1 - LOWERED * low) + (1 - shut) * LIDS * low
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
    raised, lowered = brows.curves(life.seed, prosody, times)
    up, down = gain * raised, gain * lowered + blinks.BROW * shut
    outer = {f"browOuterUp{side}": OUTER * up for side in SIDES}
    return {"browInnerUp": up, **outer, **{f"browDown{side}": down for side in SIDES}}


def life_of(options: Options, line: str) -> Life:
    """The life settings that the options set, for a line with this name.

    Raises OptionError for an unknown behaviour or emotion.
    """
    given = options.life if isinstance(options.life, Mapping) else dict.fromkeys(BEHAVIOURS, options.life)
    for kind, names, known in (
        ("behaviour", given, BEHAVIOURS),
        ("emotion", [emotion.name for emotion in options.emotions], emotion_names()),
    ):
        for name in names:
            check_name(kind, name, known)
    gains = dict(given)
    if options.blinks is not None and not gains.get("blinks", 1.0):
        gains["blinks"] = 1.0
    seed = seed_of(line) if options.life_seed is None else options.life_seed
    return Life(seed, gains, options.look_at, options.blinks, options.emotions)


def check_name(kind: str, name: str, known: Sequence[str], place: str = "") -> None:
    """Raise OptionError, suggesting the nearest name, for an unknown name."""
    if name not in known:
        near = get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"choose {', '.join(known)}"
        raise OptionError(f"{place}there is no {kind} {name!r}; {hint}")


def add_life(
    values: NDArray[np.float32], rig: Rig, life: Life, prosody: Prosody, times: Array, free: Array
) -> NDArray[np.float32]:
    """Add the layer to controls, (frames, controls) -> the same shape within the rig's limits.

    `free` (frames,), 0 to 1, is how much the mouth is free to move. Rigs of mouth shapes do not change.
    """
    if not len(times) or not lively(rig):
        return values
    return limited(values, life_offsets(rig, life, prosody, times, free), rig)


def life_offsets(rig: Rig, life: Life, prosody: Prosody, times: Array, free: Array) -> Array:
    """What the layer adds to a rig's controls, (frames, controls)."""
    base = rig.through.rig if rig.through else rig
    columns = plain_names(base.controls)
    offsets = emotion_offsets(life.emotions, base, times)
    if any(life.gain(name) > 0 for name in BEHAVIOURS):
        curves = life_curves(life, prosody, times, plain_name(TURNS[0]) in plain_names(rig.controls))
        known = {name: parts for name, parts in ALIASES.items() if name in columns}
        curves |= {name: np.mean([curves[x] for x in parts], axis=0) for name, parts in known.items()}
        for name, curve in curves.items():
            if name.lower() in columns:
                offsets[:, columns[name.lower()]] += curve
    offsets[:, _of_mouth(base.controls)] *= free[:, None]
    return offsets if rig.through is None else sparse_product(offsets, own_table(rig))


@lru_cache(maxsize=32)
def plain_names(controls: tuple[str, ...]) -> dict[str, int]:
    """The column of each control, by its plain name."""
    return {plain_name(name): column for column, name in enumerate(controls)}


@lru_cache(maxsize=32)
def _of_mouth(controls: tuple[str, ...]) -> list[int]:
    """The columns of controls that speech moves."""
    return [column for column, name in enumerate(controls) if MOUTH.search(name)]


def mouth_freedom(prosody: Prosody, track: PhoneTrack, times: Array) -> Array:
    """How much the mouth is free to move, (frames,) 0 to 1: by phones, or by audio where there are none."""
    if len(track.codes) > 1:
        return overlay_weight(track, times)
    return np.asarray(1 - (1 - SHARE) * prosody.speaking(times))


def lively(rig: Rig) -> bool:
    """Whether a rig has a control that life moves; rigs of mouth shapes have none."""
    base = rig.through.rig if rig.through else rig
    return rig.visemes is None and any(OURS.match(name) for name in plain_names(base.controls))


def idle_life(options: Options, rig: Rig) -> tuple[str, ...]:
    """Notes on behaviours that were set by name but that the rig has no control for."""
    names = plain_names((rig.through.rig if rig.through else rig).controls)
    missing = []
    if options.blinks is not None and not any("blink" in name for name in names):
        missing.append("control that blinks, so blinks have no effect")
    if options.look_at is not None and not any("look" in name for name in names):
        missing.append("eyes that turn, so gaze has no effect")
    if options.emotions and not any(set(emotion_pose(one.name)) & names.keys() for one in options.emotions):
        missing.append("control for any of the emotions, so it shows none")
    return () if is_stepped_rig(rig) else tuple(f"{rig.name} has no {what}" for what in missing)
