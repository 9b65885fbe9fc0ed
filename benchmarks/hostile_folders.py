"""Hostile folders: data sets, calibrated views, and finished runs with corrections and decisions."""

from __future__ import annotations

import json
import os
import random
import shutil
import sqlite3
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.damage import damage_bytes, damage_tree, nasty_value
from benchmarks.hostile import LINE, ROOT, Attack, Samples

sys.path.insert(0, str(ROOT / "tests" / "support"))  # which has a sample of every data set

SETS = ("biwi", "facegood", "hprc", "imft23", "imt22", "kb2k", "mngu0", "mocha", "uudamm", "vocaset")
CORRECTIONS = {
    "format": "phonanim corrections 1",
    "style": "clear",
    "settings": {
        "language": "english",
        "intensity": 1.2,
        "jaw": 0.9,
        "gains": {"jawOpen": 1.1},
        "emotions": [{"name": "joy", "weight": 0.5, "span": [0.1, 0.5]}],
        "closures": [{"kind": "hold", "start": 0.2, "end": 0.3}],
    },
    "read": [["AA", 0.0, 0.5], ["B", 0.5, 0.6]],
    "spoken": [["AA", 0.0, 0.4], ["M", 0.4, 0.6]],
    "curves": {
        "format": "phonanim edits 1",
        "rig": "arkit",
        "error": 0.01,
        "phones": [["AA", 0.0, 1.0]],
        "edits": [
            {
                "channel": "jawOpen",
                "kind": "offset",
                "start": 0.5,
                "end": 1.0,
                "fade": [0.1, 0.1],
                "keys": [[0.5, 0.1], [1.0, 0.2]],
            }
        ],
    },
}
RUN = {"format": "phonanim run 1", "folder": "..", "arguments": ["t.csv", "--format", "json"]}


def dataset(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A data set, one of whose files is damaged, a pipe, a link that leads nowhere, or named otherwise."""
    import dataset_samples

    name = rng.choice(SETS)
    source = samples.folder / "sets" / name
    if not source.is_dir():
        source.mkdir(parents=True)
        getattr(dataset_samples, name)(source)
    shutil.copytree(source, folder / "set")
    path = rng.choice(sorted(one for one in (folder / "set").rglob("*") if one.is_file()))
    data = path.read_bytes()
    chance = rng.random()
    if chance < 0.1:
        path.unlink()
        os.mkfifo(path)
    elif chance < 0.15:
        path.unlink()
        path.symlink_to(rng.choice(("nowhere", "/dev/zero", path.name)))
    elif chance < 0.25:
        path.rename(path.with_name(f"{rng.choice(('', '²', '_', 'a' * 200, '..', ' '))}{path.suffix}"))
    elif chance < 0.3:
        path.write_bytes(rng.choice((b"", bytes(1000), b"PK\x03\x04")))
    else:
        path.write_bytes(damage_bytes(data, rng))
    return ["corpus", "build", "set", "--dataset", name, "-o", "c", "--language", "english"]


def views(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """Two views and the table that calibrates them."""
    header = "x,y,z,u1,v1,u2,v2"
    noise = np.random.default_rng(rng.randrange(99))
    rows = [list(map(str, row)) for row in noise.normal(size=(8, 7)).round(3).tolist()]
    for _ in range(rng.randrange(3)):
        rng.choice(rows)[rng.randrange(7)] = str(nasty_value(rng))
    text = "\n".join([header, *map(",".join, rows)]).encode("utf-8", "replace")
    (folder / "k.csv").write_bytes(damage_bytes(text, rng) if rng.random() < 0.4 else text)
    if rng.random() < 0.1:
        (folder / "k.csv").unlink()
        os.mkfifo(folder / "k.csv")
    for name in ("a.npy", "b.npy"):
        seen = noise.normal(size=(4, 5, 2))
        others = (seen[:, :, :1], seen[:0], seen[:, :0], seen * np.nan, seen * 1e300, seen.astype("c8"), seen)
        np.save(folder / name, rng.choice(others))
    if rng.random() < 0.2:
        (folder / "a.npy").write_bytes(damage_bytes((folder / "a.npy").read_bytes(), rng))
    return ["corpus", "reconstruct", "a.npy", "b.npy", "--calibration", "k.csv", "-o", "o.npy"]


def corrections(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """The corrections of a line, alone or in a batch, or edits to join."""
    tree = damage_tree(CORRECTIONS, rng)
    data = json.dumps(tree).encode("utf-8", "replace")
    data = damage_bytes(data, rng) if rng.random() < 0.2 else data
    if rng.random() < 0.3:
        (folder / "out").mkdir()
        (folder / "out/a.corrections.json").write_bytes(data)
        (folder / "t.csv").write_text(f"id,alignment\na,{LINE}\n")
        return ["batch", "t.csv", "-o", "out", "--workers", "1", "--fps", "25", "--format", "json"]
    if rng.random() < 0.4:
        for name in ("a.json", "b.json"):
            (folder / name).write_text(json.dumps(damage_tree(CORRECTIONS["curves"], rng)))
        return ["edit", "join", "a.json", "b.json", "-o", "o.json"]
    (folder / "e.json").write_bytes(data)
    return ["animate", str(LINE), "-o", "o.json", "--rig", "arkit", "--fps", "25", "--edits", "e.json"]


def review(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A finished run whose ledger, decisions or options somebody else wrote, as a list or as pages."""
    out = folder / "out"
    out.mkdir()
    (folder / "t.csv").write_text(f"id,alignment\na,{LINE}\n")
    shutil.copy(samples.folder / "a.json", out / "a.json")
    facts = {"frames": 3, "seconds": 0.1, "phones": 2, "flags": []}
    facts |= {"language": {"name": "english", "by": "labels", "certainty": 1}}
    outcome = {"id": "a", "place": "t.csv row 2", "origin": {"options": {"rig": "arkit"}}, "error": ""}
    outcome |= {"outputs": {"a.json": "0" * 64}, "facts": facts}
    ledger = damage_tree(outcome, rng) if rng.random() < 0.2 else outcome
    (out / "ledger.jsonl").write_text(json.dumps(ledger) + "\n")
    run = damage_tree(RUN, rng) if rng.random() < 0.25 else RUN
    if rng.random() < 0.2:
        run = {**RUN, "arguments": [*RUN["arguments"], rng.choice(("--help", "-o", "--", "--json", "a\0b"))]}
    if rng.random() < 0.7:
        (out / "run.json").write_bytes(json.dumps(run).encode("utf-8", "replace"))
    if rng.random() < 0.3:
        (out / "a.corrections.json").write_text(json.dumps(damage_tree(CORRECTIONS, rng)))
    _decisions(out / "review.sqlite", rng)
    return ["review", "out", *rng.choice((["--csv", "list.csv"], ["--export", "sent"]))]


def _decisions(path: Path, rng: random.Random) -> None:
    """A file of decisions with wrong types, other tables, or damage; often none."""
    from phonanim.dubbing.decisions import SCHEMA

    chance = rng.random()
    if chance < 0.3:
        return
    others = ("CREATE TABLE lines (id)", "CREATE VIEW lines AS SELECT 1 AS id", "CREATE TABLE events (a)")
    nasty = ("a", -1, 2**62, b"\xff\xfe", "\0", None, 1e300, "<script>", "=1+1", "x" * 5000)
    values = [rng.choice(nasty) for _ in range(14)]
    database = sqlite3.connect(path)
    try:
        database.executescript(rng.choice(others) if chance < 0.4 else SCHEMA)
        if chance >= 0.4:
            loose = SCHEMA.replace(" NOT NULL", "").replace("IF NOT EXISTS ", "")
            database.executescript(f"DROP TABLE lines; DROP TABLE events; {loose}")
            database.execute("INSERT INTO lines VALUES ('a', ?, ?, ?)", values[:3])
            database.execute(
                "INSERT INTO events VALUES (1, 'a', ?, ?, ?, ?, ?, ?, ?, ?)",
                [*values[3:10], rng.choice(nasty)],
            )
        database.commit()
    except (sqlite3.Error, OverflowError):
        pass
    finally:
        database.close()
    if chance > 0.85:
        path.write_bytes(damage_bytes(path.read_bytes(), rng))


FOLDERS: dict[str, Callable[[Samples, Path, random.Random], Attack]] = {
    "dataset": dataset,
    "views": views,
    "corrections": corrections,
    "review": review,
}
