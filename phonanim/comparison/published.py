"""Rows of a published comparison: models that somebody else trained, scored on the same test clips.

A comparison writes the sums of every test clip and model into benchmark/test_sums.json. A plan that names
such a file with `published` has those models in its tables beside its own, without training them again;
intervals and paired tests are computed from the sums of both.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from phonanim.core.decode import DAMAGE, read_json
from phonanim.core.files import write_text
from phonanim.errors import ModelError

Document = dict[str, Any]
FILE = "test_sums.json"
FOLD = "test"
VARIANT = "raw"
DIGITS = 6  # significant ones of a published sum


def write_published(document: Document, folder: Path) -> Path:
    """Write test_sums.json into a folder: the models of a document with the sums of every test clip."""
    models = {
        name: {key: row[key] for key in row if key != "ema"}
        | {"scores": {VARIANT: _rounded(_of_fold(row["scores"].get(VARIANT, {})))}}
        for name, row in document["models"].items()
    }
    found = {"corpus": document["corpus"], "folds": {FOLD: document["folds"][FOLD]}, "models": models}
    path = folder / FILE
    write_text(path, json.dumps(found, separators=(",", ":")) + "\n")
    return path


def add_published(document: Document, path: Path) -> Document:
    """The document with the models of a published file behind its own.

    Raises ModelError when the file is no such file, when its test clips are others, or when a model of the
    document has the name of one of its models.
    """
    try:
        found = read_json(path)
        theirs, models = found["folds"][FOLD], found["models"]
        whole = all(row["scores"][VARIANT] and row["driven_by"] for row in models.values())
    except (OSError, *DAMAGE) as error:
        raise ModelError(f"{path}: published: cannot be read as sums of a comparison ({error})") from error
    if not whole:
        raise ModelError(f"{path}: published: a model has no sums of the test clips; publish it again")
    mine = document["folds"].get(FOLD)
    if mine is None or theirs != mine or _frames(found) != _frames(document):
        raise ModelError(
            f"{path}: published: its models have other test clips than the plan; use the corpus "
            "and the fold test of that comparison"
        )
    twice = sorted(set(models) & set(document["models"]))
    if twice:
        raise ModelError(f"{path}: published: has a model {twice[0]!r} too; rename it in the plan")
    return {
        **document,
        "models": {**document["models"], **models},
        "published": {"file": path.name, "models": list(models)},
    }


def published_text(document: Document) -> str:
    """A sentence that names the models of the published file; nothing without one."""
    found = document.get("published")
    if not found:
        return ""
    names = ", ".join(f"`{name}`" for name in found["models"])
    return f"From `{found['file']}`, trained and timed elsewhere: {names}."


def _frames(document: Document) -> tuple[Any, ...]:
    corpus = document.get("corpus", {})
    return tuple(corpus.get(key) for key in ("clips", "fps", "frames"))


def _of_fold(scores: Document) -> Document:
    return {key: sums for key, sums in scores.items() if key.partition("/")[0] == FOLD}


def _rounded(value: Any) -> Any:
    """The same with numbers of six significant digits."""
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_rounded(part) for part in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value
