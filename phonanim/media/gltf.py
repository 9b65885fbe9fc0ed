"""Check the JSON of a glTF file before it is used: types, references, sizes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from phonanim.core.decode import (
    MAX_RATIO,
    MAX_UNPACKED,
    DecodeError,
    decode_list,
    decode_number,
    decode_table,
    decode_text,
)

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

MAX_COUNT = 1 << 40  # of a size or an offset
MAX_PLACE = 1e6  # of a position (metres), a scale or an element of a matrix
MAX_NODES, MAX_LEVELS = 20_000, 256
MAX_TARGETS = 2048  # of a mesh; film heads have about 900
MAX_PARTS = 200_000  # accessors used by all meshes of all nodes
WORTH = 8  # bytes per number in memory


@dataclass(frozen=True, slots=True)
class Ref:
    """The index of an item of a top-level list."""

    to: str


@dataclass(frozen=True, slots=True)
class Vector:
    """A list of `size` numbers."""

    size: int


# The parts of each table that the reader uses: a type, a table of types, or a list of one type. A key that
# ends in `!` is required; `*` stands for every key. Everything else in a file is kept unchecked.
PART = {"bufferView!": Ref("bufferViews"), "byteOffset": int}
EXPRESSION = {"*": {"morphTargetBinds": [{"node!": Ref("nodes"), "index!": int, "weight": float}]}}
PRIMITIVE = {
    "attributes!": {"*": Ref("accessors")},
    "indices": Ref("accessors"),
    "material": Ref("materials"),
    "targets": [{"*": Ref("accessors")}],
}
NODE = {
    "name": str,
    "mesh": Ref("meshes"),
    "skin": int,
    "children": [Ref("nodes")],
    "matrix": Vector(16),
    "rotation": Vector(4),
    "scale": Vector(3),
    "translation": Vector(3),
}
BONE = {"node!": Ref("nodes")}
VRM_BIND = {"mesh!": Ref("meshes"), "index!": int, "weight": float}
SCHEMA: dict[str, Any] = {
    "buffers": [{"byteLength": int, "uri": str}],
    "bufferViews": [
        {"buffer": int, "byteOffset": int, "byteLength": int, "byteStride": int, "extensions": dict}
    ],
    "accessors": [
        {
            "bufferView": Ref("bufferViews"),
            "byteOffset": int,
            "componentType!": frozenset(COMPONENTS),
            "type!": frozenset(WIDTHS),
            "count!": int,
            "normalized": bool,
            "sparse": {
                "count!": int,
                "indices!": {**PART, "componentType!": frozenset({5121, 5123, 5125})},
                "values!": PART,
            },
        }
    ],
    "materials": [
        {"name": str, "pbrMetallicRoughness": {"baseColorFactor": Vector(4), "baseColorTexture": dict}}
    ],
    "images": [{"uri": str}],
    "meshes": [{"primitives!": [PRIMITIVE]}],
    "nodes": [NODE],
    "skins": [{"joints!": [Ref("nodes")]}],
    "extensionsUsed": [str],
    "animations": [
        {
            "samplers!": [{"input!": Ref("accessors"), "output!": Ref("accessors"), "interpolation": str}],
            "channels!": [{"sampler!": int, "target!": {"node": Ref("nodes"), "path!": str}}],
        }
    ],
    "extensions": {
        "VRMC_vrm": {
            "expressions": {"preset": EXPRESSION, "custom": EXPRESSION},
            "humanoid": {"humanBones": {"head": BONE}},
        },
        "VRMC_vrm_animation": {
            "expressions": {"preset": {"*": BONE}, "custom": {"*": BONE}},
            "humanoid": {"humanBones": {"head": BONE}},
        },
        "VRM": {
            "humanoid": {"humanBones": [{**BONE, "bone": str}]},
            "blendShapeMaster": {"blendShapeGroups": [{"presetName": str, "name": str, "binds": [VRM_BIND]}]},
        },
    },
}


def check_tree(tree: Any, size: int) -> None:
    """Raise DecodeError, which names the place, if the JSON of a file of `size` bytes is not valid glTF."""
    _check(tree, SCHEMA, "its JSON", tree)
    for number, spec in enumerate(tree.get("accessors", ())):
        _check_accessor(spec, f"accessors[{number}]", size)
    for number, mesh in enumerate(tree.get("meshes", ())):
        counts = {len(primitive.get("targets", ())) for primitive in mesh["primitives"]}
        if len(counts) != 1 or max(counts) > MAX_TARGETS:
            raise DecodeError(f"meshes[{number}] has not one count of targets, up to {MAX_TARGETS}")
    _check_nodes(tree.get("nodes", ()))
    parts = [_parts(mesh) for mesh in tree.get("meshes", ())]
    numbers = [spec["count"] * WIDTHS[spec["type"]] for spec in tree.get("accessors", ())]
    needed = [sum(numbers[index] for index in indices) for indices in parts]
    drawn = [node["mesh"] for node in tree.get("nodes", ()) if "mesh" in node]
    if sum(len(parts[mesh]) for mesh in drawn) > MAX_PARTS:
        raise DecodeError(f"its nodes draw more than {MAX_PARTS} accessors")
    check_room(sum(needed[mesh] for mesh in drawn) * WORTH, size)


def check_room(needed: float, size: int) -> None:
    """Raise DecodeError when a file of `size` bytes would need far more memory than its size."""
    room = max(MAX_UNPACKED, MAX_RATIO * size)
    if needed > room:
        raise DecodeError(f"its meshes would take {needed / 1e6:.0f} MB, of {room / 1e6:.0f} for such a file")


def external_files(tree: dict[str, Any]) -> list[str]:
    """The addresses of images and buffers that are outside the file."""
    entries = [*tree.get("images", ()), *tree.get("buffers", ())]
    return [entry["uri"] for entry in entries if not entry.get("uri", "data:").startswith("data:")]


def _check(value: Any, kind: Any, place: str, tree: Any) -> None:
    if isinstance(kind, dict):
        _check_table(value, kind, place, tree)
    elif isinstance(kind, list):
        for number, item in enumerate(decode_list(value, place)):
            _check(item, kind[0], f"{place}[{number}]", tree)
    elif isinstance(kind, Ref):
        _check_whole(value, place, len(tree.get(kind.to, ())) - 1)
    elif isinstance(kind, Vector):
        _check_vector(value, place, kind.size)
    elif isinstance(kind, frozenset):
        if not isinstance(value, (int, str)) or value not in kind:
            raise DecodeError(f"{place} is none that glTF has")
    else:
        CHECKS[kind](value, place)


def _check_vector(value: Any, place: str, size: int) -> None:
    if len(decode_list(value, place)) != size:
        raise DecodeError(f"{place} is not a list of {size} numbers")
    for item in value:
        _check_number(item, place)


def _check_table(value: Any, kind: Mapping[str, Any], place: str, tree: Any) -> None:
    decode_table(value, place)
    if "*" in kind:
        for key, item in value.items():
            _check(item, kind["*"], f"{place}.{key}", tree)
        return
    for key, what in kind.items():
        name = key.removesuffix("!")
        if name in value:
            _check(value[name], what, name if value is tree else f"{place}.{name}", tree)
        elif name != key:
            raise DecodeError(f"{place} has no {name}")


def _check_number(value: Any, place: str) -> None:
    decode_number(value, place, -MAX_PLACE, MAX_PLACE)


def _check_truth(value: Any, place: str) -> None:
    if not isinstance(value, bool):
        raise DecodeError(f"{place} is not true or false")


def _check_whole(value: Any, place: str, most: int = MAX_COUNT) -> None:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= most:
        raise DecodeError(f"{place} is {value!r:.40}; it is a whole number from 0 to {most}")


def _check_accessor(spec: dict[str, Any], place: str, size: int) -> None:
    """Limit the size of an accessor without data; other accessors are limited by the file."""
    needed = spec["count"] * WIDTHS[spec["type"]] * WORTH
    check_room(needed, size)
    if "sparse" in spec and spec["sparse"]["count"] > spec["count"]:
        raise DecodeError(f"{place} is sparse with more values than it has")


def _check_nodes(nodes: list[dict[str, Any]]) -> None:
    """Check that every node has at most one parent, and none is below itself or nested too deep."""
    if len(nodes) > MAX_NODES:
        raise DecodeError(f"it has {len(nodes)} nodes; a character has up to {MAX_NODES}")
    parents: dict[int, int] = {}
    for number, node in enumerate(nodes):
        for child in node.get("children", ()):
            if child in parents:
                raise DecodeError(f"nodes[{child}] has two parents")
            parents[child] = number
    for number in range(len(nodes)):
        at = number
        for _ in range(MAX_LEVELS):
            if at not in parents:
                break
            at = parents[at]
        else:
            raise DecodeError(f"nodes[{number}] is below itself, or below more than {MAX_LEVELS} others")


def _parts(mesh: dict[str, Any]) -> list[int]:
    """The accessors that a mesh uses, repeated for each use."""
    return [
        index
        for primitive in mesh["primitives"]
        for index in (
            *primitive["attributes"].values(),
            *([primitive["indices"]] if "indices" in primitive else ()),
            *(index for target in primitive.get("targets", ()) for index in target.values()),
        )
    ]


CHECKS: dict[type, Callable[[Any, str], object]] = {
    int: _check_whole,
    float: _check_number,
    bool: _check_truth,
    str: decode_text,
    dict: decode_table,
}
