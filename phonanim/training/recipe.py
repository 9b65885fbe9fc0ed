"""Training configurations: what a TOML file of `phonanim train` says, checked."""

from __future__ import annotations

from dataclasses import dataclass, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from phonanim.core.decode import read_toml
from phonanim.core.typed import check_types
from phonanim.errors import ModelError
from phonanim.targets import TargetSettings


@dataclass(frozen=True)
class Teacher:
    """Knowledge distillation: a slow, accurate ensemble predicts natural text as extra training data.

    `members` are the ensemble's (see regressors/ensemble.py), `natural` are folders of alignments, `clips` is
    the number of their lines, `weight` the weight of their errors (1 for the recordings). `blend` is the
    share of the teacher in the targets of the recordings.
    """

    members: tuple[dict[str, Any], ...]
    natural: tuple[str, ...]
    clips: int = 2000
    weight: float = 1.0
    blend: float = 0.0


@dataclass(frozen=True)
class Recipe:
    """A training configuration (TOML): `name`, `kind`, `corpus`, `seed`, `validation` (a share of the
    training clips), `licence` of the training data, [settings] of the kind, and optionally [teacher], and
    [target] for a corpus of other motion than landmarks.
    """

    kind: str
    corpus: str
    name: str = ""
    seed: int = 0
    validation: float = 0.1
    licence: str = ""
    settings: dict[str, Any] | None = None
    teacher: Teacher | None = None
    target: TargetSettings | None = None


def read_recipe(path: Path) -> Recipe:
    """Read and check a training configuration. Raises ModelError, which names the key and the nearest one."""
    try:
        table = read_toml(path)
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read: {error}") from error
    check_keys(table, Recipe, str(path))
    for key in ("kind", "corpus"):
        if key not in table:
            raise ModelError(f"{path}: lacks {key!r}; see the examples in benchmarks/configs")
    if "teacher" in table:
        check_keys(table["teacher"], Teacher, f"{path}: [teacher]")
        teacher: dict[str, Any] = {
            k: tuple(v) if isinstance(v, list) else v for k, v in table["teacher"].items()
        }
        table["teacher"] = Teacher(**teacher)
    if "target" in table:
        check_keys(table["target"], TargetSettings, f"{path}: [target]")
        table["target"] = TargetSettings(**table["target"])
    return Recipe(**table)


def check_keys(table: dict[str, Any], kind: type, where: str) -> None:
    """Raise ModelError for a key that is not in a dataclass, with the nearest, and for a wrong value."""
    known = [field.name for field in fields(kind)]
    for key in table:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
            raise ModelError(f"{where}: there is no key {key!r}; {hint}")
    check_types(table, kind, where)
