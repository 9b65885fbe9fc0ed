"""Overlays: expressions added to the speech without disturbing the lips.

During p b m f v sh zh ch jh, the mouth follows the speech alone. During all other phones, the mouth takes
half of an overlay. Brows, eyes and cheeks always take all of it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.style import is_stepped_rig
from phonanim.core.decode import read_json, read_toml
from phonanim.core.exact import sparse_product
from phonanim.core.files import content_hash
from phonanim.core.lexicon import find_tables
from phonanim.errors import OptionError
from phonanim.face.contacts import CONTACTS
from phonanim.options import Overlay
from phonanim.rig import Rig
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

EASE = 0.25  # seconds in which an overlay fades in and out
HOLD = 0.12  # seconds before and after a contact in which the mouth's overlay fades out and in
SHARE = 0.5  # share of an overlay that the mouth takes during speech; set by eye
LARGEST = 1e9  # of a value of a pose
MOVES = 1e-4  # of full weight; less counts as no motion
SILENT = INVENTORY.where(kind="silence")
BOUND = INVENTORY.mask(*(phone for contact in CONTACTS for phone in contact.phones))
# Controls that move the lips, besides those that the line's speech moves.
MOUTH = re.compile(r"jaw|mouth|lip|tongue|cheek_?puff|nose_?sneer|viseme", re.IGNORECASE)


def apply_overlays(
    values: NDArray[np.float32],
    rig: Rig,
    overlays: Sequence[Overlay],
    track: PhoneTrack,
    times: Array,
    load: Callable[[Path], Animation],
) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Add overlays to speech, (frames, controls) -> the same shape within limits, and notes.

    Offsets from rest are added; `load` reads an overlay that is an animation. Raises OptionError when an
    overlay cannot be read or does not fit the rig, and what `load` raises.
    """
    if is_stepped_rig(rig) or not overlays:
        return values, ()
    offsets, notes = np.zeros(values.shape), []
    for overlay in overlays:
        added, left = _offsets(overlay, rig, times, load)
        offsets += added
        notes += left
    offsets[:, mouth_controls(values, rig)] *= overlay_weight(track, times)[:, None]
    return limited(values, offsets, rig), tuple(notes)


def overlay_weight(track: PhoneTrack, times: Array) -> Array:
    """The share of an overlay that the mouth takes at instants, (frames,) seconds -> (frames,) 0 to 1."""
    silent, bound = SILENT[track.codes], BOUND[track.codes]
    spoken = SHARE + (1 - SHARE) * _eased(track.distance_to(~silent, times) / EASE)
    return np.asarray(np.minimum(spoken, _eased(track.distance_to(bound, times) / HOLD)))


def hash_overlays(overlays: Sequence[Overlay]) -> list[str]:
    """A hash of the contents of each overlay. Raises OptionError when one does not exist."""
    return [content_hash(find_overlay(overlay.source)) for overlay in overlays]


def is_pose(source: str) -> bool:
    """Whether an overlay is the name of a pose, shipped or on PHONANIM_PATH."""
    return source in find_tables("poses")


def find_overlay(source: str) -> Path:
    """The file of an overlay: a path, or the name of a pose. Raises OptionError, suggesting the nearest."""
    poses = find_tables("poses")
    if source in poses:
        return poses[source]
    if Path(source).is_file():
        return Path(source)
    near = get_close_matches(source, poses, n=1)
    hint = f"did you mean {near[0]}?" if near else f"name a file, or one of {', '.join(poses)}"
    raise OptionError(f"overlay {source}: there is no such file or pose; {hint}")


def mouth_controls(values: NDArray[np.float32], rig: Rig) -> NDArray[np.bool_]:
    """Which controls belong to the mouth: by their names, or because the speech moves them."""
    named = np.array([MOUTH.search(name) is not None for name in rig.controls])
    return np.asarray(named | (np.ptp(values, axis=0) > MOVES))


def _offsets(
    overlay: Overlay, rig: Rig, times: Array, load: Callable[[Path], Animation]
) -> tuple[Array, list[str]]:
    """What an overlay adds at instants, (frames, controls), and notes on what was left out."""
    path = find_overlay(overlay.source)
    pose = _read_pose(path)
    start, end = overlay.span or (-np.inf, np.inf)
    if pose is not None:
        base, offset = _posed(pose, rig, path)
        still = offset[None]
        notes: list[str] = []
    else:
        animation = load(path)
        start, end = max(start, float(animation.times[0])), min(end, float(animation.times[-1]))
        base, still, notes = _curves(animation, rig, path, times)
    weight = overlay.gain * _window(start, end, times)
    if not weight.any():
        notes.append(
            f"overlay {path}: shows nothing in a line of {times[-1]:.2f} s; give it another span or gain"
        )
    own = still if base is rig else sparse_product(still, own_table(rig))
    return weight[:, None] * own, notes


def _read_pose(path: Path) -> dict[str, Any] | None:
    """Control values of a TOML or JSON file, None if it is an animation. Raises OptionError."""
    if path.suffix.lower() not in (".toml", ".json"):
        return None
    try:
        pose = read_toml(path) if path.suffix.lower() == ".toml" else read_json(path)
    except (OSError, ValueError) as error:
        raise OptionError(f"overlay {path}: cannot be read: {error}") from error
    if not isinstance(pose, dict):
        raise OptionError(f"overlay {path}: is not a pose; write CONTROL = VALUE, as mouthSmileLeft = 0.5")
    return None if "format" in pose else pose


def _posed(pose: dict[str, Any], rig: Rig, path: Path) -> tuple[Rig, Array]:
    """The rig of a pose, this one or the one that it goes through, and its offsets from rest (controls,)."""
    base = _base(pose, rig)
    offset = np.zeros(len(base.controls))
    for name, value in pose.items():
        if name not in base.controls:
            near = get_close_matches(name, base.controls, n=1)
            hint = f"did you mean {near[0]}?" if near else f"write a pose of {rig.name}'s controls"
            raise OptionError(f"overlay {path}: {rig.name} has no control {name}; {hint}")
        column = base.controls.index(name)
        low, high = base.minimum[column], base.maximum[column]
        number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST
        if not number or not low <= value <= high:
            raise OptionError(
                f"overlay {path}: {name} = {value!r:.40}; give a number from {low:g} to {high:g}"
            )
        offset[column] = value - base.rest[column]
    return base, offset


def _curves(animation: Animation, rig: Rig, path: Path, times: Array) -> tuple[Rig, Array, list[str]]:
    """The rig of an animation, its offsets from rest at instants, and the channels that the rig lacks."""
    base = _base(animation.channels, rig)
    known = [name for name in animation.channels if name in base.controls]
    moving = {name for name in animation.channels if np.abs(animation.channel(name)).max() > MOVES}
    lost = [name for name in animation.channels if name in moving and name not in known]
    if not known:
        raise OptionError(
            f"overlay {path}: none of its channels ({', '.join(animation.channels[:3])} ...) is a control "
            f"of {rig.name}; choose another --rig"
        )
    offsets = np.zeros((len(times), len(base.controls)))
    for name in known:
        column = base.controls.index(name)
        offsets[:, column] = np.interp(times, animation.times, animation.channel(name)) - base.rest[column]
    note = f"overlay {path}: left out what {rig.name} has no control for: {', '.join(lost[:6])}"
    return base, offsets, [note + (" ..." if len(lost) > 6 else "")] if lost else []


def _base(names: Sequence[str] | dict[str, Any], rig: Rig) -> Rig:
    """The rig that has controls with these names: this one, or the one that it goes through."""
    behind = rig.through.rig if rig.through else rig
    return rig if any(name in rig.controls for name in names) else behind


def own_table(rig: Rig) -> Array:
    """How the other rig's controls move this one's. Overlays do not use shares of motion."""
    if rig.through is None:
        return np.eye(len(rig.controls))
    table = rig.through.table.copy()
    table[:, [share for share, _, _ in rig.through.shares]] = 0.0
    return table


def _window(start: float, end: float, times: Array) -> Array:
    """1 from start to end, with fades inside; no fade where the line itself begins or ends."""
    come = np.ones(len(times)) if start <= times[0] else _eased((times - start) / EASE)
    go = np.ones(len(times)) if end >= times[-1] else _eased((end - times) / EASE)
    return np.asarray(come * go)


def _eased(share: Array) -> Array:
    """From 0 to 1 with soft ends."""
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share**2 * (3 - 2 * share))


def limited(values: NDArray[np.float32], offsets: Array, rig: Rig) -> NDArray[np.float32]:
    """Controls with offsets within the limits; controls without an offset stay bit-identical."""
    moved = offsets.any(axis=0)
    result = values.copy()
    laid = np.clip(values[:, moved] + offsets[:, moved], rig.minimum[moved], rig.maximum[moved])
    result[:, moved] = np.where(offsets[:, moved] == 0, values[:, moved], laid)
    for low, high in rig.at_most:
        result[:, low] = np.minimum(result[:, low], result[:, high])
    return result
