"""Hostile files: sound ones of every kind, damaged at random places, and those that somebody crafts."""

from __future__ import annotations

import copy
import json
import random
import shutil
import struct
import wave
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.core.catalog import SHIPPED as MODELS
from phonanim.exporters import save
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.pipeline import animate
from phonanim.rig.head import SHIPPED as HEAD
from phonanim.rig.read import FILES, find_rig

ROOT = Path(__file__).resolve().parent.parent
LINE = ROOT / "examples" / "line.TextGrid"
Attack = list[str]  # the arguments of a command

NUMBERS = (-1, 0, 1, 2, 7, 255, 65536, 2**31, 10**10, 10**15, 10**400, -0.5, 0.5, 1e300, -1e300, 3e38)
NOT_FINITE = (float("nan"), float("inf"), float("-inf"))
TEXTS = ("", "x" * 300, "../victim", "/etc/passwd", "a\0b", "\ud800", "<!--<script>", "{{script}}", "ü")
OTHERS: tuple[Any, ...] = (None, True, False, [], {}, [[]], [0], [1e300], {"a": 1}, {"uri": "victim"})


@dataclass(frozen=True)
class Samples:
    """Sound files to damage: a folder of takes, and the trees of what is stored as JSON."""

    folder: Path
    port: int

    @property
    def url(self) -> str:
        """An address at which every connection is counted."""
        return f"http://127.0.0.1:{self.port}/a.wav"


def make_samples(folder: Path, port: int) -> Samples:
    """Write sound files, and import all that the commands import, so that a fork starts at once."""
    folder.mkdir(parents=True)
    take = animate(LINE, rig="arkit", fps=25)
    for suffix in ("json", "npz", "track.json", "csv", "glb", "usda"):
        save(take, folder / f"a.{suffix}")
    (folder / "head.glb").write_bytes(small_character())
    return Samples(folder, port)


def small_character() -> bytes:
    """A character of one triangle with the shape jawOpen."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 80}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "accessors": [
            {"bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR", "normalized": False},
        ],
        "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1]}}],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 0},
                        "indices": 1,
                        "material": 0,
                        "targets": [{"POSITION": 0}],
                    }
                ],
                "extras": {"targetNames": ["jawOpen"]},
            }
        ],
        "nodes": [
            {"mesh": 0, "name": "face", "translation": [0, 0, 0], "rotation": [0, 0, 0, 1]},
            {"children": [0], "scale": [1, 1, 1]},
        ],
        "skins": [{"joints": [1]}],
        "images": [{"uri": "data:image/png;base64,"}],
        "extensions": {
            "VRMC_vrm": {
                "expressions": {
                    "preset": {"aa": {"morphTargetBinds": [{"node": 0, "index": 0, "weight": 1.0}]}}
                }
            }
        },
    }
    return glb_bytes(tree, points.tobytes() + np.arange(3, dtype="<u2").tobytes() + bytes(38))


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


def take(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A take of one of the formats that can be read, to another."""
    suffix = rng.choice(("json", "npz", "track.json", "csv", "glb", "usda"))
    source, path = samples.folder / f"a.{suffix}", folder / f"a.{suffix}"
    if rng.random() < 0.2 or suffix == "usda":
        path.write_bytes(damage_bytes(source.read_bytes(), rng))
    elif suffix in ("json", "track.json"):
        path.write_text(json.dumps(damage_tree(json.loads(source.read_text()), rng)))
    elif suffix == "npz":
        with np.load(source) as stored:
            arrays = dict(stored)
        about = damage_tree(json.loads(str(arrays["about"])), rng)
        if rng.random() < 0.4:
            name = rng.choice(list(arrays))
            arrays[name] = rng.choice((np.zeros((0, 3)), np.array("x"), arrays[name].T, np.zeros(3, "c8")))
        else:
            arrays["about"] = np.array(json.dumps(about))
        np.savez(path, **arrays)
    elif suffix == "glb":
        write_glb(path, source, rng, ("animations",))
    else:
        rows = [line.split(",") for line in source.read_text().splitlines()]
        row = rng.choice(rows)
        row[rng.randrange(len(row))] = str(nasty_value(rng)).encode("utf-8", "replace").decode()
        path.write_text("\n".join(map(",".join, rows)) + "\n")
    out = rng.choice(("o.csv", "o.npz", "o.html", "o.glb", "o.track.json", "o.json", "o.anim"))
    return ["convert", path.name, "-o", out]


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


def character(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A character to show or to animate."""
    if rng.random() < 0.15:
        (folder / "c.glb").write_bytes(damage_bytes((samples.folder / "head.glb").read_bytes(), rng))
    else:
        write_glb(folder / "c.glb", samples.folder / "head.glb", rng)
    out = rng.choice(("o.html", "o.glb", "o.usda"))
    if rng.random() < 0.1:
        return ["rig", "fit", "c.glb", "-o", "mine.toml"]
    return ["convert", str(samples.folder / "a.npz"), "-o", out, "--character", "c.glb"]


def rig(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A rig with its tables."""
    import tomllib

    name = rng.choice(("arkit", "metahuman", "oculus15", "vrm"))
    source = find_rig(name)
    tree = tomllib.loads(source.read_text("utf-8"))
    for key in (*FILES, "table"):
        if key in tree:
            data = (source.parent / tree[key]).read_bytes()
            tree[key] = Path(tree[key]).name
            (folder / tree[key]).write_bytes(damage_bytes(data, rng) if rng.random() < 0.2 else data)
    text = to_toml(damage_tree(tree, rng))
    data = text.encode("utf-8", "replace")
    (folder / "mine.toml").write_bytes(damage_bytes(data, rng) if rng.random() < 0.2 else data)
    return ["animate", str(LINE), "-o", "o.json", "--fps", "25", "--rig", "mine.toml"]


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


def model(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A model: its card, its face or its weights."""
    from safetensors.numpy import load_file, save_file

    shutil.copytree(MODELS / "default", folder / "m")
    chance = rng.random()
    if chance < 0.5:
        card = json.loads((folder / "m/model.json").read_text())
        (folder / "m/model.json").write_text(json.dumps(damage_tree(card, rng)))
    else:
        path = folder / "m" / rng.choice(("face.safetensors", "weights.safetensors"))
        if chance < 0.6:
            path.write_bytes(damage_bytes(path.read_bytes(), rng))
        else:
            tensors = load_file(path)
            name = rng.choice(list(tensors))
            array = tensors[name]
            others = (
                array.ravel(),
                array[:0],
                array.astype("f8"),
                array.astype("i4"),
                array * 0,
                array[None],
            )
            tensors[name] = np.ascontiguousarray(rng.choice(others))
            save_file(tensors, path)
    return ["animate", str(LINE), "-o", "o.json", "--fps", "25", "--model", "m"]


def ledger(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A ledger that an earlier run did not write."""
    (folder / "lines").mkdir()
    (folder / "lines/a.txt").write_text("nothing")
    (folder / "lines/t.csv").write_text("id,alignment\na,missing.TextGrid\n")
    (folder / "out").mkdir()
    facts = {
        "frames": 3,
        "seconds": 0.1,
        "phones": 2,
        "flags": [{"check": "a", "text": "b", "severity": 0.5}],
    }
    outcome = {
        "id": "a",
        "place": "t.csv row 2",
        "origin": {"alignment": ["a", "b"], "options": {"model": "default", "rig": "arkit"}},
        "outputs": {"a.csv": "0" * 64},
        "facts": facts,
        "error": "",
    }
    lines = [json.dumps(damage_tree(outcome, rng)) for _ in range(5)]
    (folder / "out/ledger.jsonl").write_bytes(damage_bytes("\n".join(lines).encode(), rng) + b"\n")
    command = rng.choice(("batch", "audit"))
    extra = ["-o", "out", "--workers", "1"] if command == "batch" else ["out"]
    return [command, "lines/t.csv", *extra]


def table(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A table of lines."""
    row = {"id": "a", "alignment": str(LINE), "rig": "arkit", "fps": "25", "gain": "jawOpen=1", "smooth": "0"}
    row |= {
        "overlay": "smile",
        "language": "auto",
        "intensity": "1",
        "timecode": "01:00:00:00",
        "style": "calm",
    }
    row |= {"output": "x/y", "model": "default", "speaker": "s", "tier": "phones", "audio": "a.wav"}
    kept = {key: row[key] for key in ("id", "alignment", *rng.sample(list(row), 4))}
    lines = [json.dumps(damage_tree(kept, rng)) for _ in range(4)]
    data = "\n".join(lines).encode()
    (folder / "t.jsonl").write_bytes(damage_bytes(data, rng) if rng.random() < 0.2 else data)
    return ["batch", "t.jsonl", "-o", "out", "--dry-run"]


def edits(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """Edits of an animator, or a pose."""
    if rng.random() < 0.5:
        (folder / "p.json").write_text(
            json.dumps(damage_tree({"mouthSmileLeft": 0.5, "browInnerUp": 1}, rng))
        )
        return ["animate", str(LINE), "-o", "o.json", "--rig", "arkit", "--fps", "25", "--overlay", "p.json"]
    edit = {"channel": "jawOpen", "kind": "offset", "start": 0.5, "end": 1.0, "fade": [0.1, 0.1]}
    tree = {
        "format": "phonanim edits 1",
        "rig": "arkit",
        "error": 0.01,
        "phones": [["AA", 0.0, 1.0]],
        "edits": [{**edit, "keys": [[0.5, 0.1], [1.0, 0.2]]}],
    }
    (folder / "e.json").write_text(json.dumps(damage_tree(tree, rng)))
    return ["animate", str(LINE), "-o", "o.json", "--rig", "arkit", "--fps", "25", "--edits", "e.json"]


KINDS: dict[str, Callable[[Samples, Path, random.Random], Attack]] = {
    "take": take,
    "character": character,
    "rig": rig,
    "model": model,
    "ledger": ledger,
    "table": table,
    "edits": edits,
}


def _take_of(**changes: Any) -> Callable[[Samples, Path], Attack]:
    def craft(samples: Samples, folder: Path) -> Attack:
        tree = json.loads((samples.folder / "a.json").read_text())
        changed = {k: samples.url if v == "URL" else v for k, v in changes.items()}
        (folder / "a.json").write_text(json.dumps({**tree, **changed}))
        return ["convert", "a.json", "-o", "o.html"]

    return craft


def _written(name: str, data: bytes | str, *command: str) -> Callable[[Samples, Path], Attack]:
    def craft(samples: Samples, folder: Path) -> Attack:
        (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
        return [part.replace("A.npz", str(samples.folder / "a.npz")) for part in command]

    return craft


def bomb(samples: Samples, folder: Path) -> Attack:
    """An archive of some MB that unpacks to 400 MB."""
    header = {"descr": "<f4", "fortran_order": False, "shape": (10**9 // 52, 52)}
    with (
        zipfile.ZipFile(folder / "a.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("values.npy", "w", force_zip64=True) as member,
    ):
        np.lib.format.write_array_header_1_0(member, header)
        for _ in range(100):
            member.write(bytes(1 << 22))
    return ["convert", "a.npz", "-o", "o.csv"]


def linked_output(samples: Samples, folder: Path) -> Attack:
    """A planted link at the output."""
    (folder / "o.csv").symlink_to("victim")
    return ["convert", str(samples.folder / "a.npz"), "-o", "o.csv"]


def linked_ledger(samples: Samples, folder: Path) -> Attack:
    """Planted links in the folder of a batch."""
    (folder / "out").mkdir()
    for name in ("ledger.jsonl", "report.json", "report.html", "summary.txt"):
        (folder / "out" / name).symlink_to("../victim")
    (folder / "t.csv").write_text("id,alignment\na,missing.TextGrid\n")
    return ["batch", "t.csv", "-o", "out", "--workers", "1"]


def slow_wave(samples: Samples, folder: Path) -> Attack:
    """A recording at one sample a second, beside a line."""
    shutil.copy(LINE, folder / "a.TextGrid")
    with wave.open(str(folder / "a.wav"), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(1)
        stream.writeframes(bytes(2_000_000))
    return ["animate", "a.TextGrid", "-o", "o.html", "--fps", "25"]


def loop(samples: Samples, folder: Path) -> Attack:
    """Links that lead back, in a pattern."""
    (folder / "lines").mkdir()
    for name in ("x", "y"):
        (folder / "lines" / name).symlink_to(".")
    (folder / "lines/a.TextGrid").write_text("x")
    return ["batch", "lines/**/*.TextGrid", "-o", "out", "--dry-run"]


def collision(samples: Samples, folder: Path) -> Attack:
    """A line that has the name of the report."""
    (folder / "t.jsonl").write_text(json.dumps({"id": "report", "alignment": str(LINE)}) + "\n")
    return ["batch", "t.jsonl", "-o", "out", "--format", "json", "--workers", "1"]


def through(samples: Samples, folder: Path) -> Attack:
    """A rig that goes through itself."""
    (folder / "m.csv").write_text("from,to,weight\na,a,1\n")
    (folder / "m.toml").write_text('through = "m.toml"\ntable = "m.csv"\n[controls]\na = [0, 0, 1]\n')
    return ["animate", str(LINE), "-o", "o.json", "--rig", "m.toml"]


def own_child(samples: Samples, folder: Path) -> Attack:
    """A character whose node is below itself."""
    glb = read_glb(samples.folder / "head.glb")
    glb.tree["nodes"][0]["children"] = [1]
    (folder / "c.glb").write_bytes(glb_bytes(glb.tree, glb.binary))
    return ["rig", "fit", "c.glb", "-o", "mine.toml"]


def fetching(samples: Samples, folder: Path) -> Attack:
    """A character with a picture elsewhere."""
    glb = read_glb(HEAD)
    glb.tree["images"] = [{"uri": samples.url}]
    (folder / "c.glb").write_bytes(glb_bytes(glb.tree, glb.binary))
    return ["convert", str(samples.folder / "a.npz"), "-o", "o.html", "--character", "c.glb"]


TRACK = '{"format": "openfacefx.track", "version": 1, "fps": 60, "channels": [{"name": "a", "keys": %s}]}'
CRAFTED: dict[str, Callable[[Samples, Path], Attack]] = {
    **{f"take: fps {value}": _take_of(fps=value) for value in (-1, 0, 1e300, float("nan"), float("inf"))},
    **{f"take: start {value}": _take_of(start=value) for value in (1e300, float("nan"), float("-inf"))},
    **{f"take: audio {value}": _take_of(audio=value) for value in ("URL", "../victim", "/etc/passwd")},
    **{
        f"take: keys {keys[:20]}": _written(
            "a.track.json", TRACK % keys, "convert", "a.track.json", "-o", "o.csv"
        )
        for keys in ("[[1e12, 1]]", "[[0, 0], [999999, 1]]", "[]", "[[1, 0], [0, 1]]")
    },
    "take: depth": _written("a.json", "[" * 10**6, "convert", "a.json", "-o", "o.csv"),
    "take: unpacks to 400 MB": bomb,
    "take: onto a link": linked_output,
    "rig: depth": _written("a.toml", "a = " + "[" * 10**5, "animate", str(LINE), "--rig", "a.toml"),
    "rig: through itself": through,
    "rig: endless": lambda samples, folder: ["animate", str(LINE), "-o", "o.json", "--rig", "/dev/zero"],
    "character: its own child": own_child,
    "character: fetches": fetching,
    "ledger: onto links": linked_ledger,
    "table: links that lead back": loop,
    "table: the name of the report": collision,
    "table: long cells": _written(
        "t.jsonl",
        json.dumps({"id": "a", "alignment": "x" * 5000}),
        "batch",
        "t.jsonl",
        "-o",
        "o",
        "--dry-run",
    ),
    "sound: 1 Hz": slow_wave,
}
