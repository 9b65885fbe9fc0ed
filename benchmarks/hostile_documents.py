"""Hostile files of the kinds that train, compare and evaluate: corpora, plans, studies, masks, ..."""

from __future__ import annotations

import json
import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from safetensors.numpy import save_file

from benchmarks.damage import damage_bytes, damage_tree, to_toml
from benchmarks.hostile import LINE, ROOT, Attack, Samples

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

CLIP = {
    "clip": "a",
    "frames": 3,
    "split": "train",
    "audio": "a.wav",
    "words": [["so", 0.0, 0.1]],
    "codes": [0, 1],
    "bounds": [0.0, 0.05, 0.12],
    "labels": ["", "DH"],
}
ANSWER: dict[str, Any] = {
    "item": "a",
    "kind": "test",
    "left": "x",
    "right": "y",
    "choice": "left",
    "rating": 3,
    "expected": None,
}
RESULT = {
    "format": "phonanim study result 1",
    "study": "s",
    "participant": "p",
    "ended": "2026-01-01",
    "choices": "equal",
    "answers": [ANSWER, ANSWER],
}


def write_tree(path: Path, tree: Any, rng: random.Random) -> None:
    """A damaged tree as JSON or TOML, by the suffix of the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    damaged = damage_tree(tree, rng)
    text = to_toml(damaged) if path.suffix == ".toml" else json.dumps(damaged)
    data = text.encode("utf-8", "replace")
    path.write_bytes(damage_bytes(data, rng) if rng.random() < 0.2 else data)


def language(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A language of the user."""
    tree = tomllib.loads((ROOT / "lexicon/languages/english.toml").read_text("utf-8"))
    write_tree(folder / "own/languages/mine.toml", tree, rng)
    command = ["animate", str(LINE), "-o", "o.json", "--fps", "25", "--language", "mine"]
    return [*command, "--on-unknown-label", "silence"]


def corpus(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A corpus to train with."""
    write_tree(
        folder / "c/corpus.json", {"fps": 25.0, "provenance": {}, "clips": [CLIP, {**CLIP, "clip": "b"}]}, rng
    )
    landmarks = np.zeros((6, 478, 3), np.float32)
    others = (landmarks[:5], landmarks[0], landmarks * np.nan, landmarks)
    save_file(
        {"landmarks": np.ascontiguousarray(rng.choice(others)), "indices": np.arange(478)},
        folder / "c/landmarks.safetensors",
    )
    (folder / "r.toml").write_text('kind = "phone_mean"\ncorpus = "c"\n')
    return ["train", "r.toml", "-o", "m"]


def recipe(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """A recipe of a model, or a plan of a comparison."""
    if rng.random() < 0.5:
        source = rng.choice(sorted((ROOT / "benchmarks/configs").glob("*.toml")))
        write_tree(folder / "r.toml", tomllib.loads(source.read_text("utf-8")), rng)
        return ["train", "r.toml", "-o", "m"]
    tree = tomllib.loads((ROOT / "benchmarks/compare.toml").read_text("utf-8"))
    tree["models"] = {name: str(ROOT / "benchmarks" / path) for name, path in tree["models"].items()}
    write_tree(folder / "p.toml", tree, rng)
    return ["compare", "p.toml", "-o", "out", "--report-only"]


def study(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """The answers of a study."""
    write_tree(folder / "results/a.json", RESULT, rng)
    return ["study", "analyse", "results"]


def evaluation(samples: Samples, folder: Path, rng: random.Random) -> Attack:
    """Vertices with masks, as models of meshes write them."""
    points = np.random.default_rng(rng.randrange(99)).normal(size=(5, 9)).reshape(5, 3, 3)
    np.save(folder / "b.npy", points)
    np.save(folder / "a.npy", points + 0.1)
    write_tree(folder / "mask.json", {"lips": [0, 1], "upper": [1, 2]}, rng)
    if rng.random() < 0.4:
        path = folder / rng.choice(("a.npy", "b.npy"))
        path.write_bytes(damage_bytes(path.read_bytes(), rng))
    return ["evaluate", "a.npy", "--reference", "b.npy", "--mask", "mask.json", "--fps", "30"]


DOCUMENTS: dict[str, Callable[[Samples, Path, random.Random], Attack]] = {
    "language": language,
    "corpus": corpus,
    "recipe": recipe,
    "study": study,
    "evaluation": evaluation,
}
