"""Hostile files of the kinds that animate: sound ones, damaged at random places."""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.damage import damage_bytes, damage_tree, nasty_value, to_toml, write_glb
from phonanim.animation.animation import Animation
from phonanim.core.catalog import SHIPPED as MODELS
from phonanim.errors import MissingExtraError
from phonanim.exporters import needed_rig, readable_suffixes, save
from phonanim.media.glb import glb_bytes
from phonanim.pipeline import animate
from phonanim.rig.read import FILES, find_rig

ROOT = Path(__file__).resolve().parent.parent
LINE = ROOT / "examples" / "line.TextGrid"
Attack = list[str]  # the arguments of a command


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
    for suffix in set(readable_suffixes()) - {".vrm"}:  # it needs a whole character
        _save_take(take, folder / f"take{suffix}")
    return Samples(folder, port)


def _save_take(take: Animation, path: Path) -> None:
    """A short take of a format, on the rig that the format needs; none where its library is absent."""
    rig = "vrm" if path.suffix == ".vmd" else needed_rig(path, take.channels)
    short = animate(LINE, rig=rig, fps=25) if rig else take
    with suppress(MissingExtraError):
        save(short.with_values(short.values[:20]), path)


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
