"""Alignments, captures and lists beside a line that are hostile, and options without sense."""

from __future__ import annotations

import json
import os
import random
import shutil
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import click

from benchmarks.damage import damage_bytes, damage_tree, nasty_value
from benchmarks.hostile import LINE, ROOT, Attack, Samples
from benchmarks.hostile_documents import write_tree

sys.path.insert(0, str(ROOT / "tests" / "support"))  # which has a sample of every reader

CSV_LISTS = {
    "names": "shape,control,weight\njawOpen,jawOpen,1\nMund,mouthPucker,0.5\n",
    "emotion": "emotion,weight,start,end\njoy,0.5,0.5,1\nanger,1,1,2\n",
    "characters": "name,rig,style,intensity\nAda,arkit,clear,1.2\nBob,metahuman,casual,0.8\n",
}
TOML_LISTS = {
    "characters": {"Ada": {"rig": "arkit", "style": "clear", "intensity": 1.2}, "Bob": {"rig": "oculus15"}},
    "styles": {"mine": {"intensity": 1.2, "jaw": 0.5, "smooth": 0.1}},
}
LEXICON = "please P L IY1 Z\nbeam B IY1 M\nso S OW1\n"
NUMBERS = ("nan", "inf", "-inf", "-1", "0", "1e300", "-1e300", "1e-300", "", "0x10", "9" * 30, "\u0661", "=1")
TEXTS = (
    "x" * 5000,
    "\udcff",
    "../../x",
    "CON",
    "a=",
    "=",
    "jawOpen=nan",
    "joy=nan",
    "joy@1-0",
    "smile@nan-1",
)
ADDRESSES = ("websocket=:::", "osc=host:-1", "websocket=127.0.0.1:99999999", "[::]:99999", "{{script}}")
PATHS = ("/dev/zero", "/dev/full", "pipe", "folder", "noise", "deep.json", "zeros", "missing.toml")
COMMANDS: dict[str, list[str]] = {
    "animate": [str(LINE), "-o", "o.csv", "--fps", "25"],
    "batch": ["folder", "-o", "out", "--workers", "1", "--fps", "25"],
    "audit": ["folder", "--outputs", "out", "--workers", "1"],
    "convert": ["TAKE", "-o", "o.csv"],
    "evaluate": ["TAKE", "--reference", "TAKE"],
    "info": [str(LINE)],
    "stream": [str(LINE), "--to", "stdout"],
    "train": ["noise", "-o", "m"],
    "compare": ["noise", "-o", "out", "--report-only"],
    "rig fit": ["HEAD", "-o", "mine.toml"],
    "rig check": ["arkit"],
    "rig transfer": ["HEAD", "-o", "t.glb"],
    "study make": ["noise", "-o", "s.html"],
    "study analyse": ["noise"],
    "edit diff": ["TAKE", "TAKE", "-o", "e.json"],
    "ema report": ["folder", "-o", "e.md"],
    "corpus build": ["folder", "-o", "c"],
}


def alignment(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """An alignment of one of the formats that are read."""
    from timing_samples import EVERY

    name = rng.choice(sorted(EVERY))
    data = rng.choice(EVERY[name]).data
    (folder / "a.txt").write_bytes(_damaged(data, rng))
    (folder / "l.dict").write_text(LEXICON)
    return ["animate", "a.txt", "-o", "o.json", "--fps", "25", "--lexicon", "l.dict"]


def capture(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A capture or a take of one of the formats that can be read, to another."""
    source = rng.choice(sorted(samples.folder.glob("take.*")))
    (folder / source.name).write_bytes(_damaged(source.read_bytes(), rng))
    return ["convert", source.name, "-o", rng.choice(("o.csv", "o.npz", "o.html", "o.json"))]


def aside(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A list beside a line: names, emotions, characters, styles, pronunciations."""
    kind = rng.choice(("names", "emotion", "characters", "styles", "lexicon"))
    animate = ["animate", str(LINE), "-o", "o.json", "--fps", "25"]
    if kind == "lexicon":
        (folder / "l.dict").write_bytes(_damaged(LEXICON.encode(), rng))
        (folder / "a.json").write_text(json.dumps({"words": [{"word": "so", "start": 0.1, "end": 0.5}]}))
        return ["animate", "a.json", "-o", "o.json", "--fps", "25", "--lexicon", "l.dict"]
    if kind in TOML_LISTS and (kind not in CSV_LISTS or rng.random() < 0.5):
        path = folder / "mine.toml"
        write_tree(path, TOML_LISTS[kind], rng)
    else:
        path = folder / "mine.csv"
        rows = [line.split(",") for line in CSV_LISTS[kind].splitlines()]
        row = rng.choice(rows)
        row[rng.randrange(len(row))] = str(nasty_value(rng))
        text = "\n".join(map(",".join, rows)).encode("utf-8", "replace")
        path.write_bytes(_damaged(text, rng) if rng.random() < 0.3 else text)
    if kind == "names":
        return ["convert", _take(samples), "-o", "o.glb", "--character", _head(samples), "--names", path.name]
    if kind == "emotion":
        return [*animate, "--emotion", path.name]
    (folder / "t.csv").write_text(f"id,alignment,character,style\na,{LINE},Ada,\nb,{LINE},,mine\n")
    return ["batch", "t.csv", "-o", "out", "--dry-run", "--workers", "1", f"--{kind}", path.name]


def option(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A value without sense, a device, a pipe or noise for an option or an argument of a command."""
    _write_places(folder, rng)
    name = rng.choice(sorted(COMMANDS))
    given = [{"TAKE": _take(samples), "HEAD": _head(samples)}.get(part, part) for part in COMMANDS[name]]
    value = rng.choice(rng.choice((NUMBERS, TEXTS, ADDRESSES, PATHS, PATHS)))
    chosen = rng.choice(("", *_options(name)))
    if chosen:
        return [*name.split(), *given, chosen, value]
    return [*name.split(), value, *given[1:]]


def cached(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """The cache of a comparison, the curve of a training, or sensors."""
    if rng.random() < 0.5:
        (folder / "m").mkdir()
        (folder / "m/loss.csv").write_bytes(_damaged(b"epoch,loss,error\n1,2,3\n2,1,2\n", rng))
        (folder / "r.toml").write_text('kind = "dnn"\ncorpus = "c"\n')
        return ["train", "r.toml", "-o", "m", "--plot"]
    import numpy as np

    arrays = {"sensors": np.array(["UL", "LL", "JAW"]), "xyz": np.zeros((50, 3, 3)), "hz": np.array(200.0)}
    name = rng.choice(sorted(arrays))
    whole = arrays[name]
    others = (np.zeros((0, 3)), np.array("x"), whole.T, whole[None], np.array(np.nan), np.zeros(3, "c8"))
    arrays[name] = rng.choice(others)
    (folder / "e").mkdir()
    np.savez(folder / "e/a.npz", **arrays)
    if rng.random() < 0.3:
        path = folder / "e/a.npz"
        path.write_bytes(damage_bytes(path.read_bytes(), rng))
    shutil.copy(LINE, folder / "e/a.TextGrid")
    return ["evaluate", _take(samples), "--reference", "e/a.npz"]


def _damaged(data: bytes, rng: random.Random) -> bytes:
    """Bytes damaged, or for JSON also a damaged tree; now and then a bomb of the same beginning."""
    if rng.random() < 0.5:
        try:
            return json.dumps(damage_tree(json.loads(data), rng)).encode("utf-8", "replace")
        except (ValueError, RecursionError):
            pass
    data = damage_bytes(data, rng)
    if rng.random() < 0.1:
        at = rng.randrange(len(data) + 1)
        data = data[:at] + data[at : at + 40] * rng.choice((1000, 50_000)) + data[at:]
    return data


def _write_places(folder: Path, rng: random.Random) -> None:
    """A pipe, a folder with a line, noise, depth and zeros: what PATHS name."""
    os.mkfifo(folder / "pipe")
    for name in ("folder", "out"):
        (folder / name).mkdir()
    shutil.copy(LINE, folder / "folder/a.TextGrid")
    (folder / "noise").write_bytes(rng.randbytes(3000))
    (folder / "deep.json").write_text("[" * 200_000)
    (folder / "zeros").write_bytes(bytes(5_000_000))


@cache
def _options(name: str) -> tuple[str, ...]:
    """The options of a command that take a value."""
    from phonanim.__main__ import commands

    group: click.Command = commands
    for part in name.split():
        context = click.Context(group)
        found = group.get_command(context, part) if isinstance(group, click.Group) else None
        group = found or group
    return tuple(_spelled(group))


def _spelled(command: click.Command) -> Iterator[str]:
    for parameter in command.params:
        if isinstance(parameter, click.Option) and not parameter.is_flag:
            yield parameter.opts[0]


def _take(samples: Samples) -> str:
    return str(samples.folder / "a.npz")


def _head(samples: Samples) -> str:
    return str(samples.folder / "head.glb")


INPUTS: dict[str, Callable[[Samples, Path, random.Random], Attack]] = {
    "alignment": alignment,
    "capture": capture,
    "aside": aside,
    "option": option,
    "cached": cached,
}
