"""Match channels to morph targets of a character's file, by their names or by VRM expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE
from phonanim.errors import RigError
from phonanim.media.glb import Glb
from phonanim.rig.names import match_shapes
from phonanim.rig.names import plain_name as plain_name

STILL = 1e-6  # metres: a shape that moves all points less is empty
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
    holds the weights that the character has without animation, zeros if it is empty; `present` are the names
    of all shapes of the file that move something, None for those of this node.
    """

    source: str
    node: int
    names: tuple[str, ...]
    binds: dict[str, list[tuple[int, float]]] = field(default_factory=dict)
    rest: tuple[float, ...] = ()
    present: frozenset[str] | None = None

    def moved(self, channels: tuple[str, ...]) -> list[tuple[int, int, float]]:
        """(channel, target, weight) for every target that some channel moves.

        Raises RigError when a channel matches two targets.
        """
        present = frozenset(filter(None, self.names)) if self.present is None else self.present
        names = tuple(name if name in present else "" for name in self.names)
        unbound = tuple(channel for channel in channels if not self.binds.get(channel))
        columns = [channels.index(channel) for channel in unbound]
        bound = [
            (column, target, weight)
            for column, channel in enumerate(channels)
            for target, weight in self.binds.get(channel, ())
        ]
        named = match_shapes(names, unbound, present, self.source)
        return sorted([*bound, *((columns[place], target, share) for place, target, share in named)])

    def weights(self, values: NDArray[np.float32], channels: tuple[str, ...]) -> NDArray[np.float64]:
        """Weights of every target, (frames, channels) -> (frames, targets); those at rest where unmoved."""
        weights = np.zeros((len(values), len(self.names)))
        moved = self.moved(channels)
        if self.rest:
            weights[:] = self.rest
            weights[:, [target for _, target, _ in moved]] = 0
        for column, target, weight in moved:
            weights[:, target] += weight * values[:, column]
        lessened = [target for _, target, weight in moved if weight < 0]
        weights[:, lessened] = np.maximum(weights[:, lessened], 0)
        return weights


def find_morphs(glb: Glb) -> list[Morphs]:
    """Every node whose mesh has morph targets. Raises RigError when there is none."""
    meshes = glb.tree.get("meshes", [])
    nodes = [(i, n["mesh"]) for i, n in enumerate(glb.tree.get("nodes", [])) if "mesh" in n]
    nodes = [(node, mesh) for node, mesh in nodes if has_targets(meshes[mesh])]
    if not nodes:
        raise RigError(f"{glb.source}: has no morph targets; export the character with its shape keys")
    binds = _expressions(glb.tree)
    named = {mesh: target_names(meshes[mesh], glb.tree.get("accessors", [])) for _, mesh in nodes}
    moving = {mesh: moving_targets(glb, meshes[mesh]) for mesh in named}
    shapes = {
        name for mesh, rows in moving.items() for name, moves in zip(named[mesh], rows, strict=True) if moves
    }
    present = frozenset(filter(None, shapes or {name for names in named.values() for name in names}))
    found = []
    for node, mesh in nodes:
        rest = _rest(glb.tree, node, meshes[mesh])
        found.append(Morphs(glb.source, node, named[mesh], binds.get(node, {}), rest, present))
    for morphs in found:
        for name, pairs in morphs.binds.items():
            if any(target >= len(morphs.names) for target, _ in pairs):
                raise RigError(f"{glb.source}: its expression {name!r} moves a target that does not exist")
    return found


def has_targets(mesh: dict[str, Any]) -> bool:
    """Whether a mesh has morph targets."""
    return bool(mesh["primitives"] and mesh["primitives"][0].get("targets"))


def target_names(mesh: dict[str, Any], accessors: Sequence[dict[str, Any]] = ()) -> tuple[str, ...]:
    """The names of a mesh's targets, in its extras or else on its accessors; "" for unnamed ones."""
    first = mesh["primitives"][0]
    targets = first.get("targets", ())
    extras = [part["extras"] for part in (mesh, first) if isinstance(part.get("extras"), dict)]
    listed: list[Any] = next((e["targetNames"] for e in extras if isinstance(e.get("targetNames"), list)), [])
    if not listed:
        places = [target.get("POSITION", -1) for target in targets]
        listed = [accessors[i].get("name", "") if 0 <= i < len(accessors) else "" for i in places]
    return (*map(str, listed), *[""] * len(targets))[: len(targets)]


def moving_targets(glb: Glb, mesh: dict[str, Any]) -> list[bool]:
    """Whether each target of a mesh moves any of its points."""
    return [
        any(
            _moves(glb, part["targets"][row])
            for part in mesh["primitives"]
            if row < len(part.get("targets", ()))
        )
        for row in range(len(mesh["primitives"][0]["targets"]))
    ]


def _moves(glb: Glb, target: dict[str, int]) -> bool:
    """Whether a target moves points, by the limits of its accessor or else by its values."""
    if "POSITION" not in target:
        return False
    try:
        spec = glb.tree["accessors"][target["POSITION"]]
        limits = [*spec.get("min", ()), *spec.get("max", ())]
        values = np.abs(limits if len(limits) == 6 else glb.accessor(target["POSITION"]))
        return bool(values.max(initial=0) > STILL)
    except (RigError, *DAMAGE):
        return True  # compressed or damaged: what reads the points says so


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
            "name a --character that has them, choose another --rig, or give their names as --names"
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
