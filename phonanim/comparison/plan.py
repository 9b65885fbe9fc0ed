"""The plan of a comparison: a TOML file of models, clips and sweeps."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from phonanim.core.catalog import find_model
from phonanim.core.decode import read_toml
from phonanim.errors import ModelError
from phonanim.training.recipe import check_keys

LEFT_OUT = "clips"  # the fold that leaves out each clip in turn
USUAL = ("test", "words", "phones", "ema")
FOLDS = (*USUAL, LEFT_OUT)
NOISES = ("white", "babble")
RESERVED = set("/*|")  # separators of folds, frames and table cells


@dataclass(frozen=True)
class Sweep:
    """One model trained several times: `x`, and optionally `series`, are settings that take every value.

    A setting is a key of [settings] of the recipe, or "clips", the share of the training clips. The series
    "model" uses recipes of the plan by name instead of `recipe`.
    """

    x: str
    values: tuple[Any, ...]
    recipe: Path | None = None
    series: str = ""
    of: tuple[Any, ...] = ("",)
    label: str = ""


@dataclass(frozen=True)
class Condition:
    """Another sound of the test clips: a voice shifted by semitones, then `noise` ("white" or "babble") at
    `snr` dB below the speech. Phones are aligned again, with the text of the clip or without.
    """

    noise: str = ""
    snr: float = 0.0
    voice: float = 0.0
    text: bool = True


@dataclass(frozen=True)
class Plan:
    """A comparison: `models` are recipes (trained in every fold) or folders of trained models (test, ema).

    `reference` is the model against which the others are tested. `words` are the folds of leave-words-out,
    each a group of withheld words; `phones` are withheld together. `ema` is a folder of EMU bundles, `tools`
    a file of benchmarks/tools.py, `legibility` one of benchmarks/legibility.py. `mouths` are models that are
    also trained on the joint modes, `test_only` those that are not trained again for withheld words and
    phones. `seeds` are those of the trainings, one of each recipe for each; without them, each recipe is
    trained once, with its own; `one_seed` are models that are trained with the first of them only.
    `published` is the test_sums.json of another comparison, whose models are rows too (published.py).
    `conditions` are other sounds of the test clips (comparison/conditions.py). `masks` are files of vertices
    or controls by region, for corpora of these.
    """

    corpus: Path
    models: dict[str, Path]
    reference: str
    folds: tuple[str, ...] = USUAL
    words: tuple[tuple[str, ...], ...] = ()
    phones: tuple[str, ...] = ()
    ema: Path | None = None
    tools: Path | None = None
    legibility: Path | None = None
    published: Path | None = None
    mouths: tuple[str, ...] = ()
    test_only: tuple[str, ...] = ()
    seed: int = 0
    seeds: tuple[int, ...] = ()
    one_seed: tuple[str, ...] = ()
    conditions: dict[str, Condition] = field(default_factory=dict)
    sweeps: dict[str, Sweep] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    masks: dict[str, Path] = field(default_factory=dict)


def read_plan(path: Path) -> Plan:
    """Read and check a plan; its paths are relative to it. Raises ModelError, which names the key."""
    try:
        table = read_toml(path)
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read: {error}") from error
    check_keys(table, Plan, str(path))
    for key in ("corpus", "models", "reference"):
        if key not in table:
            raise ModelError(f"{path}: lacks {key!r}; see benchmarks/compare.toml")
    folder = path.parent
    for key in ("corpus", "ema", "tools", "legibility", "published"):
        if key in table:
            table[key] = folder / table[key]
    table["models"] = {name: _model(where, path, name) for name, where in table["models"].items()}
    table["masks"] = {name: folder / where for name, where in table.get("masks", {}).items()}
    table["sweeps"] = {name: _sweep(values, path, name) for name, values in table.get("sweeps", {}).items()}
    table["conditions"] = {
        name: _condition(values, f"{path}: conditions.{name}")
        for name, values in table.get("conditions", {}).items()
    }
    table["words"] = tuple(tuple(group) for group in table.get("words", ()))
    table["phones"] = tuple(table.get("phones", ()))
    table |= {key: tuple(table.get(key, ())) for key in ("mouths", "test_only", "seeds", "one_seed")}
    table["folds"] = tuple(table.get("folds", USUAL))
    plan = Plan(**table)
    _check_names(plan, path)
    _check_seeds(plan, path)
    return plan


def _check_names(plan: Plan, path: Path) -> None:
    if plan.reference not in plan.models:
        raise ModelError(f"{path}: reference {plan.reference!r} is not one of its models")
    lists = {"mouths": plan.mouths, "test_only": plan.test_only, "one_seed": plan.one_seed}
    for key, names in lists.items():
        for name in names:
            if name not in plan.models or not plan.models[name].is_file():
                raise ModelError(f"{path}: {key}: {name!r} is not a recipe among its models")
    for fold in plan.folds:
        if fold not in FOLDS:
            raise ModelError(f"{path}: folds: there is no {fold!r}; use {', '.join(FOLDS)}")
    if not {"test", "ema", LEFT_OUT} & set(plan.folds):
        raise ModelError(f"{path}: folds: the report needs 'test'; add it")
    for name in plan.conditions:
        if RESERVED & set(name):
            raise ModelError(
                f"{path}: conditions: {name!r} must contain none of {' '.join(sorted(RESERVED))}; rename it"
            )


def _check_seeds(plan: Plan, path: Path) -> None:
    if any(not isinstance(seed, int) or seed < 0 for seed in plan.seeds) or len({*plan.seeds}) < len(
        plan.seeds
    ):
        raise ModelError(f"{path}: seeds: {list(plan.seeds)} must be different whole numbers from 0 on")
    if plan.one_seed and not plan.seeds:
        raise ModelError(f"{path}: one_seed: there are no seeds of which to take one; add seeds")


def _model(where: str, plan: Path, name: str) -> Path:
    """A recipe or model folder beside the plan, or else a model by its name, such as "default"."""
    if (plan.parent / where).exists():
        return plan.parent / where
    try:
        return find_model(where)
    except ModelError as error:
        raise ModelError(
            f"{plan}: models.{name}: {plan.parent / where} does not exist, and {error}"
        ) from error


def _existing(where: Path, plan: Path, name: str) -> Path:
    if not where.exists():
        raise ModelError(f"{plan}: sweeps.{name}: {where} does not exist; give a recipe")
    return where


def _condition(values: dict[str, Any], where: str) -> Condition:
    check_keys(values, Condition, where)
    found = Condition(**values)
    if found.noise not in ("", *NOISES):
        raise ModelError(f"{where}: there is no noise {found.noise!r}; use {', '.join(NOISES)}")
    if ("noise" in values) != ("snr" in values):
        raise ModelError(f"{where}: noise needs snr (dB) and snr needs noise; give both or neither")
    return found


def _sweep(values: dict[str, Any], path: Path, name: str) -> Sweep:
    check_keys(values, Sweep, f"{path}: sweeps.{name}")
    for key in ("x", "values"):
        if key not in values:
            raise ModelError(f"{path}: sweeps.{name}: lacks {key!r}; see benchmarks/compare.toml")
    settings: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
    if "recipe" in values:
        settings["recipe"] = _existing(path.parent / values["recipe"], path, name)
    elif values.get("series") != "model":
        raise ModelError(f'{path}: sweeps.{name}: needs a recipe, or series = "model" and models in `of`')
    return Sweep(**settings)
