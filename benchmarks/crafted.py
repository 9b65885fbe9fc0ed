"""Files that somebody crafts: each is one attack, of a kind that no random damage finds."""

from __future__ import annotations

import json
import shutil
import wave
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.hostile import LINE, Attack, Samples
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.head import SHIPPED as HEAD


def _take_of(**changes: Any) -> Callable[[Samples, Path], Attack]:
    def craft(samples: Samples, folder: Path) -> Attack:
        tree = json.loads((samples.folder / "a.json").read_text())
        changed = {k: samples.url if v == "URL" else v for k, v in changes.items()}
        (folder / "a.json").write_text(json.dumps({**tree, **changed}))
        return ["convert", "a.json", "-o", "o.html"]

    return craft


def _written(name: str, data: bytes | str, *command: str) -> Callable[[Samples, Path], Attack]:
    def craft(samples: Samples, folder: Path) -> Attack:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
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


def lying_archive(samples: Samples, folder: Path) -> Attack:
    """An archive of some MB that unpacks to 1.6 GB, and says that it has 1000 bytes."""
    path, size = folder / "a.npz", 1600 << 20
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("values.npy", "w") as member,
    ):
        for _ in range(size >> 22):
            member.write(bytes(1 << 22))
    real, told = size.to_bytes(4, "little"), (1000).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(real, told))
    return ["convert", "a.npz", "-o", "o.csv"]


def hard_links(samples: Samples, folder: Path) -> Attack:
    """Files in the folder of a batch that have another name elsewhere."""
    (folder / "out").mkdir()
    for name in ("ledger.jsonl", "run.json", "report.json", "report.html", "summary.txt"):
        (folder / "out" / name).hardlink_to(folder / "victim")
    (folder / "t.csv").write_text("id,alignment\na,missing.TextGrid\n")
    return ["batch", "t.csv", "-o", "out", "--workers", "1"]


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
HUGE = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3)}".ljust(117) + b"\n"
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
    "ledger: onto hard links": hard_links,
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
    "language: depth": _written(
        "own/languages/mine.toml",
        "a = " + "[" * 10**5,
        "animate",
        str(LINE),
        "-o",
        "o.csv",
        "--language",
        "mine",
    ),
    "recipe: depth": _written("r.toml", "a = " + "[" * 10**5, "train", "r.toml", "-o", "m"),
    "recipe: endless": lambda samples, folder: ["train", "/dev/zero", "-o", "m"],
    "study: depth": _written("a.json", "[" * 10**6, "study", "analyse", "a.json"),
    "study: endless": lambda samples, folder: ["study", "analyse", "/dev/zero"],
    "evaluation: depth": _written(
        "m.json", '{"a": ' * 10**5, "evaluate", "A.npz", "--reference", "A.npz", "--mask", "m.json"
    ),
    "evaluation: huge shape": _written(
        "a.npy",
        b"\x93NUMPY\x01\x00" + len(HUGE).to_bytes(2, "little") + HUGE,
        "evaluate",
        "a.npy",
        "--reference",
        "a.npy",
        "--fps",
        "30",
    ),
}
