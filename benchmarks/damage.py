"""Damage sound data at random places: trees of JSON and TOML, bytes, and the tree of a GLB file."""

from __future__ import annotations

import copy
import json
import random
import struct
from pathlib import Path
from typing import Any

from phonanim.media.glb import read_glb

NUMBERS = (-1, 0, 1, 2, 7, 255, 65536, 2**31, 10**10, 10**15, 10**400, -0.5, 0.5, 1e300, -1e300, 3e38)
NOT_FINITE = (float("nan"), float("inf"), float("-inf"))
TEXTS = ("", "x" * 300, "../victim", "/etc/passwd", "a\0b", "\ud800", "<!--<script>", "{{script}}", "ü")
OTHERS: tuple[Any, ...] = (None, True, False, [], {}, [[]], [0], [1e300], {"a": 1}, {"uri": "victim"})


def damage_tree(tree: Any, rng: random.Random, finite: bool = False) -> Any:
    """A copy of a tree with one to three values replaced, removed, repeated or nested."""
    tree = json.loads(json.dumps(tree))
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        tree = _damaged(tree, rng, finite)
    return tree


def _damaged(tree: Any, rng: random.Random, finite: bool) -> Any:
    if not isinstance(tree, (dict, list)) or not tree or rng.random() < 0.02:
        return nasty_value(rng, finite)
    key = rng.choice(list(tree)) if isinstance(tree, dict) else rng.randrange(min(len(tree), 40))
    chance = rng.random()
    if isinstance(tree[key], (dict, list)) and tree[key] and chance < 0.8:
        tree[key] = _damaged(tree[key], rng, finite)
    elif chance < 0.1:
        del tree[key]
    elif chance < 0.15 and isinstance(tree, list):
        tree.append(tree[key])
    elif chance < 0.2 and isinstance(tree, dict):
        tree[str(nasty_value(rng, finite))] = tree[key]
    else:
        tree[key] = nasty_value(rng, finite)
    return tree


def nasty_value(rng: random.Random, finite: bool = False) -> Any:
    """A value that no writer means."""
    kinds = (NUMBERS, TEXTS, OTHERS) if finite else (NUMBERS, NOT_FINITE, TEXTS, OTHERS)
    return copy.deepcopy(rng.choice(rng.choice(kinds)))


def damage_bytes(data: bytes, rng: random.Random) -> bytes:
    """Bytes cut short, changed, repeated or put together anew."""
    data = bytearray(data)
    for _ in range(rng.choice((1, 2, 8))):
        at = rng.randrange(max(len(data), 1))
        chance = rng.randrange(4)
        if chance == 0:
            del data[at:]
        elif chance == 1:
            data[at : at + 1] = bytes([rng.randrange(256)])
        elif chance == 2:
            data[at:at] = data[at : at + rng.randrange(64)]
        else:
            data[at : at + rng.randrange(8)] = rng.randbytes(rng.randrange(8))
    return bytes(data)


def write_glb(path: Path, source: Path, rng: random.Random, keys: tuple[str, ...] = ()) -> None:
    """A GLB file whose JSON is damaged, in one of the top-level `keys` where they are given."""
    glb = read_glb(source)
    tree = dict(glb.tree)
    if keys:
        key = rng.choice(keys)
        tree[key] = damage_tree(tree[key], rng, finite=True)
    else:
        tree = damage_tree(tree, rng, finite=True)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    binary = glb.binary if rng.random() < 0.8 else rng.randbytes(len(glb.binary))
    chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def to_toml(tree: Any) -> str:
    """A tree as TOML; keys and values that TOML has not are left out."""
    if not isinstance(tree, dict):
        return f"name = {_toml_value(tree)}\n"
    plain = [f"{json.dumps(k)} = {_toml_value(v)}" for k, v in tree.items() if v is not None]
    return "\n".join(plain) + "\n"


def _toml_value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml_value, value)) + "]"
    if isinstance(value, float):
        return {"nan": "nan", "inf": "inf", "-inf": "-inf"}.get(str(value), repr(value))
    return json.dumps(value)
