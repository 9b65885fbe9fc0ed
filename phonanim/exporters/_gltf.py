"""Animations in binary glTF (`.glb` and `.vrm`): add them to a character's file, and read them back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.keys import reduce_curves
from phonanim.core.decode import DAMAGE
from phonanim.core.files import atomic_path
from phonanim.errors import OutputError, RigError
from phonanim.exporters._curves import estimate_rate, merge_target_curves
from phonanim.exporters._take import build_take, check_times, sample_curves, take_grid
from phonanim.exporters._twin import without_twin
from phonanim.media.glb import Glb, glb_bytes, kept_glb, read_glb
from phonanim.media.gltf import WIDTHS
from phonanim.rig.head import TONGUE
from phonanim.rig.morphs import Morphs, find_morphs, moving_morphs
from phonanim.rig.neck import TURNS, find_bone, turns_of
from phonanim.speech.alignment import pack_intervals

FLOAT = 5126
TURN_KEYS = 10.0  # degrees of error of the head that are allowed per unit of weight error of other curves
SPAN = 0.02  # seconds by which the ends of the tracks of one animation may differ
ROUNDING = 1e-6  # seconds: a key that is stored as float32 may be this far after its frame


def add_to_character(animation: Animation, path: Path, character: Path, keys: float | None) -> None:
    """Write a character's file with the animation added; see `glb.write`. Raises RigError, OutputError."""
    glb = kept_glb(character)
    with atomic_path(path) as partial:
        partial.write_bytes(add_animation(glb, animation, path.name.split(".")[0], keys))


def add_animation(glb: Glb, animation: Animation, name: str, keys: float | None = None) -> bytes:
    """The bytes of a character's file with one more animation, or with this one in the place of our last one.

    An animation of the same name that phonanim wrote before is taken out first.
    """
    glb = without_twin(glb, name)
    tracks = moving_morphs(glb, animation.channels)
    binary = Appended(glb)
    samplers = [
        key_sampler(binary, animation, morphs.weights(animation.values, animation.channels), keys)
        for morphs in tracks
    ]
    channels = [
        {"sampler": number, "target": {"node": morphs.node, "path": "weights"}}
        for number, morphs in enumerate(tracks)
    ]
    turns, bone = turns_of(animation.values, animation.channels), find_bone(glb)
    if turns is not None and bone is not None:
        channels.append({"sampler": len(samplers), "target": {"node": bone.node, "path": "rotation"}})
        near = None if keys is None else np.radians(TURN_KEYS * keys) / 2
        samplers.append(key_sampler(binary, animation, bone.rotations(turns), near, "VEC4"))
    added = {"name": name, "samplers": samplers, "channels": channels, "extras": take_extras(animation)}
    return binary.file({"animations": [*glb.tree.get("animations", []), added]})


def take_extras(animation: Animation) -> dict[str, Any]:
    """What stands beside the curves, as the `extras` of a glTF animation."""
    return {
        "fps": animation.fps,
        "start": animation.start,
        "rig": animation.rig,
        "phones": pack_intervals(animation.phones),
        "words": pack_intervals(animation.words),
        "audio": animation.audio.name if animation.audio else None,
        "provenance": animation.provenance,
    }


def key_sampler(
    binary: Appended,
    animation: Animation,
    weights: NDArray[np.float64],
    keys: float | None,
    kind: str = "SCALAR",
) -> dict[str, Any]:
    """A track of weights, (frames, targets), or of other vectors a frame: every frame, or reduced keys."""
    times = animation.times - min(0.0, animation.start)  # glTF has no time before zero
    if keys is not None:
        reduced = reduce_curves(weights, keys)
        times, weights = times[reduced.frames], reduced.values
    return {
        "input": binary.accessor(times.astype("<f4"), bounds=True),
        "output": binary.accessor(weights.astype("<f4").ravel(), kind=kind),
        "interpolation": "LINEAR",
    }


class Appended:
    """A character's file with more data at the end of its binary chunk."""

    def __init__(self, glb: Glb) -> None:
        self.glb = glb
        self.pieces = [glb.binary, b"\0" * (-len(glb.binary) % 4)]
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def accessor(self, values: NDArray[np.float32], bounds: bool = False, kind: str = "SCALAR") -> int:
        """Append scalars, (n,), or elements of another `kind`, and return the number of their accessor."""
        offset = sum(map(len, self.pieces))
        self.pieces.append(values.tobytes())
        view = len(self.glb.tree.get("bufferViews", [])) + len(self.views)
        self.views.append({"buffer": 0, "byteOffset": offset, "byteLength": values.nbytes})
        limits = {"min": [float(values.min())], "max": [float(values.max())]} if bounds else {}
        count = len(values) // WIDTHS[kind]
        spec = {"bufferView": view, "componentType": FLOAT, "count": count, "type": kind, **limits}
        self.accessors.append(spec)
        return len(self.glb.tree.get("accessors", [])) + len(self.accessors) - 1

    def file(self, changes: dict[str, Any]) -> bytes:
        """The bytes of the whole file, with these top-level entries of its JSON replaced."""
        tree = {**self.glb.tree, **changes}
        tree["bufferViews"] = [*tree.get("bufferViews", []), *self.views]
        tree["accessors"] = [*tree.get("accessors", []), *self.accessors]
        first, *others = tree.get("buffers") or [{}]
        if "uri" in first:
            raise RigError(
                f"{self.glb.source}: its first buffer is outside the file; "
                "pack it with: npx @gltf-transform/cli copy IN.glb OUT.glb"
            )
        tree["buffers"] = [{**first, "byteLength": sum(map(len, self.pieces))}, *others]
        return glb_bytes(tree, self.pieces)


def read(path: Path) -> Animation:
    """Read the last animation that moves morph targets, by their names.

    If a program wrote one animation per mesh, earlier animations of other meshes with the same length are
    included. Keys that are not on a regular grid are interpolated onto one. Raises RigError when the file is
    damaged, OutputError when it has no such animation or two meshes disagree.
    """
    glb = read_glb(path)
    morphs = {found.node: found for found in find_morphs(glb)}
    try:
        tracks = _tracks(glb, morphs)
        if tracks:
            return _animation(glb, tracks, morphs, path)
    except DAMAGE as error:
        raise OutputError(f"{path}: its animation is damaged: {error}; export it again") from error
    raise OutputError(f"{path}: has no animation of named morph targets; export it with its shape keys")


@dataclass(frozen=True)
class Track:
    """Weights of one node: the sampler, its keys in seconds, and the extras of its animation."""

    node: int
    sampler: dict[str, Any]
    clock: NDArray[np.float64]
    extras: dict[str, Any]


def _tracks(glb: Glb, morphs: dict[int, Morphs]) -> list[Track]:
    """The last track of each node that is as long as the last one of all, in the order of the file."""
    found: dict[int, Track] = {}
    for entry in reversed(glb.tree.get("animations", [])):
        extras = entry.get("extras", {}) if isinstance(entry.get("extras", {}), dict) else {}
        for channel in entry["channels"]:
            node = channel["target"].get("node")
            if channel["target"]["path"] != "weights" or node not in morphs or node in found:
                continue
            sampler = entry["samplers"][channel["sampler"]]
            track = Track(node, sampler, glb.accessor(sampler["input"])[:, 0].astype(float), extras)
            check_times(track.clock, f"the animation of node {node}")
            if all(_as_long(track, other) for other in found.values()):
                found[node] = track
    return list(found.values())


def _as_long(one: Track, other: Track) -> bool:
    return bool(np.allclose(one.clock[[0, -1]], other.clock[[0, -1]], atol=SPAN))


def _animation(glb: Glb, tracks: list[Track], morphs: dict[int, Morphs], path: Path) -> Animation:
    extras, clock = tracks[0].extras, max((track.clock for track in tracks), key=len)
    if len(clock) < 2 and "fps" not in extras:
        raise OutputError(f"{path}: its animation has only one key, so there is no motion to read")
    fps = extras["fps"] if "fps" in extras else estimate_rate(clock)
    width = sum(len(morphs[track.node].names) for track in tracks)
    grid = take_grid(clock[0], clock[-1], fps, width, path)
    curves: dict[str, NDArray[np.floating]] = {}
    for track in tracks:
        names = morphs[track.node].names
        sampled = sample_track(glb, track, len(names), grid)
        for name, curve in zip(names, sampled, strict=True):
            curves[name] = merge_target_curves(curves.get(name), curve, name, path)
    if not any(
        curves[name].any() for name in TONGUE if name in curves
    ):  # channels of the package's head, which few rigs move
        curves = {name: curve for name, curve in curves.items() if name not in TONGUE}
    curves |= head_turns(glb, grid)
    values = np.empty((len(grid), len(curves)), np.float32)
    for column, curve in enumerate(curves.values()):
        values[:, column] = curve
    return build_take(values, list(curves), fps, extras.get("start", clock[0]), extras, path)


def head_turns(glb: Glb, grid: NDArray[np.float64]) -> dict[str, NDArray[np.floating]]:
    """Degrees of the head at instants, by channel, from the last animation that rotates its bone."""
    bone = find_bone(glb)
    for entry in reversed(glb.tree.get("animations", []) if bone else []):
        for channel in entry["channels"]:
            if (
                bone
                and channel["target"].get("node") == bone.node
                and channel["target"]["path"] == "rotation"
            ):
                sampler = entry["samplers"][channel["sampler"]]
                clock = glb.accessor(sampler["input"])[:, 0].astype(float)
                rotations = sample_track(glb, Track(bone.node, sampler, clock, {}), 4, grid)
                turns = bone.turns(rotations.T / np.linalg.norm(rotations.T, axis=1, keepdims=True))
                return dict(zip(TURNS, turns.T, strict=True))
    return {}


def sample_track(glb: Glb, track: Track, count: int, grid: NDArray[np.float64]) -> NDArray[np.floating]:
    """(targets, frames): keys on a grid of seconds, interpolated as the sampler declares."""
    sampler, keys = track.sampler, track.clock
    values = glb.accessor(sampler["output"]).astype(float).reshape(len(keys), -1, count)
    interpolation = sampler.get("interpolation", "LINEAR")
    if interpolation == "LINEAR" and len(keys) == len(grid) and np.allclose(keys, grid, atol=1e-4):
        return np.asarray(values[:, 0].T)
    first = np.clip(np.searchsorted(keys, grid + ROUNDING, side="right") - 1, 0, len(keys) - 1)
    if interpolation == "STEP":
        return np.asarray(values[first, 0].T)
    if interpolation == "LINEAR":
        return sample_curves(grid, [(keys, curve) for curve in values[:, 0].T]).T
    after = np.minimum(first + 1, len(keys) - 1)
    return _cubic(grid - keys[first], keys[after] - keys[first], values[first], values[after]).T


def _cubic(
    past: NDArray[np.float64],
    length: NDArray[np.float64],
    left: NDArray[np.float64],
    right: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Cubic Hermite spans (glTF 2.0, appendix C.5), `past` seconds after their first key: (n, targets).

    `left` and `right` are (n, 3, targets): slope before, value and slope after the keys on both sides.
    """
    length = np.where(length > 0, length, 1)[:, None]
    t = np.clip(past[:, None] / length, 0, 1)
    u = 1 - t
    values = left[:, 1] * (1 + 2 * t) * u**2 + right[:, 1] * (3 - 2 * t) * t**2
    return np.asarray(values + length * t * u * (left[:, 2] * u - right[:, 0] * t))
