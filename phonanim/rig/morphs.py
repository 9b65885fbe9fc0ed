"""Match channels to morph targets of a character's file, by their names or by VRM expressions."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import RigError
from phonanim.media.glb import Glb

SIDES = {"l": "left", "r": "right"}
# VRM 0.x calls the five vowels by their letters.
VRM0_NAMES = {
    "a": "aa",
    "i": "ih",
    "u": "ou",
    "e": "ee",
    "o": "oh",
    "blink_l": "blinkLeft",
    "blink_r": "blinkRight",
}


@dataclass(frozen=True)
class Morphs:
    """The morph targets of one node of the file `source`: their names, and the channels that move them.

    `binds` maps an expression to pairs of target and weight, for characters that group their targets; `rest`
    holds the weights that the character has without animation, zeros if it is empty.
    """

    source: str
    node: int
    names: tuple[str, ...]
    binds: dict[str, list[tuple[int, float]]] = field(default_factory=dict)
    rest: tuple[float, ...] = ()

    def moved(self, channels: tuple[str, ...]) -> list[tuple[int, int, float]]:
        """(channel, target, weight) for every target that some channel moves.

        Raises RigError when a channel matches two targets.
        """
        return [
            (column, target, weight)
            for column, channel in enumerate(channels)
            for target, weight in self.binds.get(channel) or self._named(channel)
        ]

    def weights(self, values: NDArray[np.float32], channels: tuple[str, ...]) -> NDArray[np.float64]:
        """Weights of every target, (frames, channels) -> (frames, targets); those at rest where unmoved."""
        weights = np.zeros((len(values), len(self.names)))
        moved = self.moved(channels)
        if self.rest:
            weights[:] = self.rest
            weights[:, [target for _, target, _ in moved]] = 0
        for column, target, weight in moved:
            weights[:, target] += weight * values[:, column]
        return weights

    @cached_property
    def _by_name(self) -> dict[str, list[int]]:
        places: dict[str, list[int]] = {}
        for number, name in enumerate(self.names):
            places.setdefault(plain_name(name), []).append(number)
        return places

    def _named(self, channel: str) -> list[tuple[int, float]]:
        """The target with a channel's exact name, or with the same plain name."""
        alike = self._by_name.get(plain_name(channel), [])
        exact = [i for i in alike if self.names[i] == channel]
        found = exact or alike
        if len(found) > 1:
            names = " and ".join(repr(self.names[i]) for i in found[:2])
            raise RigError(
                f"{self.source}: the channel {channel} fits two morph targets, {names}; rename one"
            )
        return [(i, 1.0) for i in found]


def plain_name(name: str) -> str:
    """The plain form of a name, without what programs add: `head.jawOpen`, `JawOpen` and `jaw_open` match.

    A side at the end is written in full, so that `eyeBlink_L` is `eyeBlinkLeft`.
    """
    last = name.rsplit(".", 1)[-1]
    side = re.fullmatch(r"(.+[a-z])_?([LR])|(.+)_([lr])", last)
    if side:
        stem, letter = (side[1], side[2]) if side[1] else (side[3], side[4])
        last = stem + SIDES[letter.lower()]
    return re.sub(r"[\s_]", "", last).lower()


def find_morphs(glb: Glb) -> list[Morphs]:
    """Every node whose mesh has morph targets. Raises RigError when there is none."""
    meshes = glb.tree.get("meshes", [])
    nodes = [(i, n["mesh"]) for i, n in enumerate(glb.tree.get("nodes", [])) if "mesh" in n]
    nodes = [(node, mesh) for node, mesh in nodes if has_targets(meshes[mesh])]
    if not nodes:
        raise RigError(f"{glb.source}: has no morph targets; export the character with its shape keys")
    binds = _expressions(glb.tree)
    found = []
    for node, mesh in nodes:
        rest = _rest(glb.tree, node, meshes[mesh])
        found.append(Morphs(glb.source, node, target_names(meshes[mesh]), binds.get(node, {}), rest))
    for morphs in found:
        for name, pairs in morphs.binds.items():
            if any(target >= len(morphs.names) for target, _ in pairs):
                raise RigError(f"{glb.source}: its expression {name!r} moves a target that is not there")
    return found


def has_targets(mesh: dict[str, Any]) -> bool:
    """Whether a mesh has morph targets."""
    return bool(mesh["primitives"] and mesh["primitives"][0].get("targets"))


def target_names(mesh: dict[str, Any]) -> tuple[str, ...]:
    """The names of a mesh's targets, "" for unnamed ones."""
    first = mesh["primitives"][0]
    extras = [part["extras"] for part in (mesh, first) if isinstance(part.get("extras"), dict)]
    listed: list[Any] = next((e["targetNames"] for e in extras if isinstance(e.get("targetNames"), list)), [])
    return (*map(str, listed), *[""] * len(first["targets"]))[: len(first["targets"])]


def _rest(tree: dict[str, Any], node: int, mesh: dict[str, Any]) -> tuple[float, ...]:
    """The weights of a node without animation: its own, or its mesh's; empty where they are no such list."""
    weights = tree["nodes"][node].get("weights", mesh.get("weights", []))
    fits = isinstance(weights, list) and len(weights) == len(mesh["primitives"][0]["targets"])
    if not fits or not all(isinstance(weight, (int, float)) and -9 < weight < 9 for weight in weights):
        return ()
    return tuple(map(float, weights))


def moving_morphs(glb: Glb, channels: tuple[str, ...]) -> list[Morphs]:
    """The targets that some channel moves. Raises RigError when there are none."""
    found = [morphs for morphs in find_morphs(glb) if morphs.moved(channels)]
    if not found:
        shown = ", ".join(channels[:3])
        raise RigError(
            f"{glb.source}: has no morph target named like {shown} ...; "
            "name a --character that has them, or choose another --rig"
        )
    return found


def _expressions(tree: dict[str, Any]) -> dict[int, dict[str, list[tuple[int, float]]]]:
    """VRM expressions by node: the targets of each, and their weights at full expression."""
    found: dict[int, dict[str, list[tuple[int, float]]]] = {}
    extensions = tree.get("extensions", {})
    for name, expression in _vrm1(extensions.get("VRMC_vrm", {})):
        for bind in expression.get("morphTargetBinds", []):
            targets = found.setdefault(bind["node"], {}).setdefault(name, [])
            targets.append((bind["index"], float(bind.get("weight", 1.0))))
    by_mesh: dict[int, list[int]] = {}
    for node, entry in enumerate(tree.get("nodes", [])):
        by_mesh.setdefault(entry.get("mesh", -1), []).append(node)
    for group in extensions.get("VRM", {}).get("blendShapeMaster", {}).get("blendShapeGroups", []):
        preset = str(group.get("presetName", "unknown"))
        name = VRM0_NAMES.get(preset, group.get("name", "") if preset == "unknown" else preset)
        for bind in group.get("binds", []):
            for node in by_mesh.get(bind["mesh"], []):
                targets = found.setdefault(node, {}).setdefault(name, [])
                targets.append((bind["index"], float(bind.get("weight", 100.0)) / 100))
    return found


def _vrm1(extension: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    expressions = extension.get("expressions", {})
    return [*expressions.get("preset", {}).items(), *expressions.get("custom", {}).items()]
