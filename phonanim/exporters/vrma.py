"""VRM animation (VRMC_vrm_animation 1.0): expressions by name and the turns of the head, for any VRM.

A program that shows a VRM sets the weights of all expressions itself in every frame, so that glTF animation
of the meshes has no effect there. This file animates the expressions: the x of a node's translation is the
weight of the expression.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE
from phonanim.core.files import atomic_path
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OutputError
from phonanim.exporters._curves import estimate_rate
from phonanim.exporters._gltf import (
    TURN_KEYS,
    Appended,
    Track,
    head_turns,
    key_sampler,
    sample_track,
    take_extras,
)
from phonanim.exporters._take import build_take, check_times, take_grid
from phonanim.media.glb import Glb, read_glb
from phonanim.rig.morphs import find_morphs, plain_name
from phonanim.rig.neck import is_turn, quaternions, turns_of

SUMMARY = "VRM animation: expressions by name and the head, for any VRM 0.x or 1.0"
EXTENSION = "VRMC_vrm_animation"
MOUTHS, BLINKS = ("aa", "ih", "ou", "ee", "oh"), ("blink", "blinkLeft", "blinkRight")
FEELINGS = ("happy", "angry", "sad", "relaxed", "surprised", "neutral")
PRESETS = frozenset((*MOUTHS, *BLINKS, *FEELINGS))  # of VRM 1.0, without the gaze, which the format excludes
GAZE = frozenset(("lookUp", "lookDown", "lookLeft", "lookRight"))


def write(animation: Animation, path: Path, character: Path | None = None, keys: float | None = None) -> None:
    """Write the channels as expressions; their weights are limited to 0 .. 1, as the format demands.

    With a `character`, a GLB or VRM, only its expressions are written, as it spells them. With `keys`, frames
    are left out if linear interpolation is within that error. Raises OutputError when no channel is an
    expression of the character or the destination cannot be written, RigError when the character cannot be
    read.
    """
    named = match_expressions(animation.channels, path, character)
    bones = skeleton_nodes()
    binary = Appended(Glb({}, b"", str(path)))
    targets, samplers = _keyed(binary, animation, list(named.values()), bones, keys)
    tree = _tree(bones, list(named))
    channels = [{"sampler": number, "target": target} for number, target in enumerate(targets)]
    take = {"name": path.name.split(".")[0], "samplers": samplers, "channels": channels}
    with atomic_path(path) as partial:
        partial.write_bytes(binary.file({**tree, "animations": [{**take, "extras": take_extras(animation)}]}))


def read(path: Path) -> Animation:
    """Read the expressions and the head of the first animation. Raises RigError, OutputError."""
    glb = read_glb(path)
    try:
        found = glb.tree.get("extensions", {}).get(EXTENSION, {}).get("expressions", {})
        names = {
            place["node"]: name
            for group in ("preset", "custom")
            for name, place in found.get(group, {}).items()
        }
        tracks = _tracks(glb, names)
        if tracks:
            return _animation(glb, tracks, path)
    except DAMAGE as error:
        raise OutputError(f"{path}: its animation is damaged: {error}; export it again") from error
    raise OutputError(f"{path}: has no animation of VRM expressions; export it as VRM animation")


def match_expressions(channels: tuple[str, ...], path: Path, character: Path | None) -> dict[str, str]:
    """The channel of each expression that is written. Raises OutputError when there is none."""
    faces = [name for name in channels if not is_turn(name) and name not in GAZE]
    if character is None:
        return {name: name for name in faces}
    groups = find_morphs(read_glb(character))
    known = dict.fromkeys(name for morphs in groups for name in morphs.binds if name not in GAZE)
    exact = {name: name for name in known if name in faces}
    taken = {plain_name(name) for name in exact}
    plain = {plain_name(name): name for name in faces if plain_name(name) not in taken}
    alike = {name: plain[plain_name(name)] for name in known if plain_name(name) in plain}
    if not exact and not alike:
        has = f"its expressions are {', '.join(list(known)[:8])}" if known else "it has no VRM expression"
        raise OutputError(
            f"{path}: no channel of the rig is an expression of {character}: {has}; "
            "choose another --rig, such as vrm"
        )
    return {name: exact.get(name) or alike[name] for name in known if name in exact or name in alike}


def _keyed(
    binary: Appended,
    animation: Animation,
    curves: list[str],
    bones: list[dict[str, Any]],
    keys: float | None,
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Targets and samplers: the nodes of the curves, which follow the bones, then the head where it turns."""
    targets, samplers = [], []
    for number, curve in enumerate(curves, len(bones)):
        shift = np.zeros((len(animation.values), 3))
        shift[:, 0] = np.clip(animation.channel(curve), 0, 1)
        targets.append({"node": number, "path": "translation"})
        samplers.append(key_sampler(binary, animation, shift, keys, "VEC3"))
    turns = turns_of(animation.values, animation.channels)
    if turns is not None:
        near = None if keys is None else np.radians(TURN_KEYS * keys) / 2
        head = next(number for number, bone in enumerate(bones) if bone["name"] == "head")
        targets.append({"node": head, "path": "rotation"})
        samplers.append(key_sampler(binary, animation, quaternions(turns), near, "VEC4"))
    return targets, samplers


def _tree(bones: list[dict[str, Any]], names: list[str]) -> dict[str, Any]:
    """The file without its animation: bones, then a node for each expression."""
    places = {name: {"node": number} for number, name in enumerate(names, len(bones))}
    groups = {
        "preset": {name: place for name, place in places.items() if name in PRESETS},
        "custom": {name: place for name, place in places.items() if name not in PRESETS},
    }
    humanoid = {"humanBones": {bone["name"]: {"node": number} for number, bone in enumerate(bones)}}
    return {
        "asset": {"version": "2.0", "generator": "phonanim"},
        "scene": 0,
        "scenes": [{"nodes": [0, *(place["node"] for place in places.values())]}],
        "nodes": [*bones, *({"name": name} for name in names)],
        "extensionsUsed": [EXTENSION],
        "extensions": {
            EXTENSION: {
                "specVersion": "1.0",
                "humanoid": humanoid,
                "expressions": {kind: found for kind, found in groups.items() if found},
            }
        },
    }


def skeleton_nodes() -> list[dict[str, Any]]:
    """The bones that every VRM has, as nodes in its T-pose, metres, the hips first."""
    with (LEXICON / "formats" / "vrm_skeleton.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    names = [row["bone"] for row in rows]
    nodes: list[dict[str, Any]] = [
        {"name": row["bone"], "translation": [float(row[axis]) for axis in "xyz"]} for row in rows
    ]
    for number, row in enumerate(rows):
        if row["parent"]:
            nodes[names.index(row["parent"])].setdefault("children", []).append(number)
    return nodes


def _tracks(glb: Glb, names: dict[int, str]) -> dict[str, Track]:
    """The keys of each expression in the first animation."""
    found: dict[str, Track] = {}
    for entry in glb.tree.get("animations", [])[:1]:
        for channel in entry["channels"]:
            name = names.get(channel["target"].get("node", -1))
            if name is None or channel["target"]["path"] != "translation":
                continue
            sampler = entry["samplers"][channel["sampler"]]
            clock = glb.accessor(sampler["input"])[:, 0].astype(float)
            check_times(clock, f"the expression {name}")
            extras = entry.get("extras", {}) if isinstance(entry.get("extras", {}), dict) else {}
            found[name] = Track(channel["target"]["node"], sampler, clock, extras)
    return found


def _animation(glb: Glb, tracks: dict[str, Track], path: Path) -> Animation:
    clock = max((track.clock for track in tracks.values()), key=len)
    extras = next(iter(tracks.values())).extras
    if len(clock) < 2 and "fps" not in extras:
        raise OutputError(f"{path}: its animation has only one key, so there is no motion to read")
    fps = extras["fps"] if "fps" in extras else estimate_rate(clock)
    first = min(track.clock[0] for track in tracks.values())
    last = max(track.clock[-1] for track in tracks.values())
    grid = take_grid(first, last, fps, len(tracks), path)
    curves: dict[str, NDArray[np.floating]] = {
        name: sample_track(glb, track, 3, grid)[0] for name, track in tracks.items()
    }
    curves |= head_turns(glb, grid)
    values = np.stack(list(curves.values()), axis=1).astype(np.float32)
    return build_take(values, list(curves), fps, extras.get("start", first), extras, path, "vrm")
