"""The tables of a comparison, as rows of text: values with intervals, differences with their p values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.comparison.measures import MEASURES
from phonanim.comparison.run import model_rows, seeded_rows
from phonanim.comparison.scores import measure_value
from phonanim.evaluation.statistics import (
    Statistic,
    bootstrap_interval,
    holm,
    paired_test,
    pearson,
    pooled_sd_ratio,
    pooled_slope,
    seeded_interval,
)

Table = list[list[str]]
Document = dict[str, Any]
Sums = NDArray[np.float64]  # (clips, sums)
SIGNIFICANT = 0.05
NOTHING = "–"
"""A value that does not exist: the correlation with a curve that does not move."""
SHOWN = {"default": "phonanim", "procedural": "dominance (Cohen-Massaro)"}
"""Names of models in tables and figures, for models whose own names are unclear."""


def markdown(table: Table) -> str:
    """A table with its header row first, as Markdown; numbers are right-aligned, dashes are explained."""
    rule = ["---", *["---:"] * (len(table[0]) - 1)]
    rows = "\n".join("| " + " | ".join(row) + " |" for row in [table[0], rule, *table[1:]])
    dashed = any(cell.strip("*") == NOTHING for row in table[1:] for cell in row)
    return f"{rows}\n\n{NOTHING}: no correlation, because a curve does not move." if dashed else rows


def measure_heading(measure: str) -> str:
    """A measure with its unit."""
    return MEASURES[measure].heading


def values_table(document: Document, variant: str, where: str, measures: tuple[str, ...]) -> Table:
    """One row per model: each measure with its 95 % interval over sentences; the best in bold."""
    names = [n for n in document["models"] if model_rows(document, n, variant, where) is not None]
    columns = [_column(document, names, variant, where, measure) for measure in measures]
    cells = [list(row) for row in zip(*columns, strict=True)]
    header = ["model", *[measure_heading(measure) for measure in measures]]
    return [header, *[[name, *row] for name, row in zip(names, cells, strict=True)]]


def _column(document: Document, names: list[str], variant: str, where: str, measure: str) -> list[str]:
    found, texts = [], []
    for name in names:
        rows = _rows(document, name, variant, where, measure)
        found.append(measure_value(measure, rows))
        by_seed = (seeded_rows(document, name, variant, where) or {})[measure]
        texts.append(interval_text(document, by_seed, measure))
    away = MEASURES[measure].distance(np.array(found))
    best = int(np.nanargmin(away)) if np.isfinite(away).any() else -1
    return [f"**{text}**" if i == best else text for i, text in enumerate(texts)]


def interval_text(document: Document, rows: Sums, measure: str) -> str:
    """A value with its 95 % interval over sentences, (clips, sums), or (clips, seeds, sums) over both.

    NOTHING for a value that is not a number.
    """
    value = measure_value(measure, rows.sum(axis=1) if rows.ndim == 3 else rows)
    if np.isnan(value):
        return NOTHING
    low, high = interval(document, rows, MEASURES[measure].statistic)
    return f"{_number(value)} [{_number(low)}, {_number(high)}]"


def interval(document: Document, rows: Sums, statistic: Statistic) -> tuple[float, float]:
    """The 95 % interval of a statistic over sentences, and over seeds where there are several."""
    rng = np.random.default_rng(document["seed"])
    if rows.ndim == 3 and rows.shape[1] > 1:
        return seeded_interval(rows, rng, statistic)
    return bootstrap_interval(rows[:, 0] if rows.ndim == 3 else rows, rng, statistic)


def size_table(document: Document, variant: str, where: str) -> Table:
    """How far each model moves: slope on the captured curve and ratio of deviations, 1 at best."""
    table = [
        ["model", *[f"{curve} {part}" for curve in ("aperture", "width") for part in ("slope", "sd ratio")]]
    ]
    for name in document["models"]:
        rows = seeded_rows(document, name, variant, where)
        if rows is None:
            continue
        cells = []
        for measure in ("aperture_r", "width_r"):
            for statistic in (pooled_slope, pooled_sd_ratio):
                low, high = interval(document, rows[measure], statistic)
                value = float(statistic(rows[measure].sum(axis=(0, 1))))
                cells.append(NOTHING if np.isnan(value) else f"{value:.2f} [{low:.2f}, {high:.2f}]")
        table.append([name, *cells])
    return table


def differences_table(document: Document, variant: str, where: str, measures: tuple[str, ...]) -> Table:
    """Change of each measure from the reference to each model, and its p, Holm-corrected together."""
    reference = document["reference"]
    others = [
        n
        for n in document["models"]
        if n != reference and model_rows(document, n, variant, where) is not None
    ]
    pairs = [(name, measure) for name in others for measure in measures]
    compared = [
        (
            _rows(document, reference, variant, where, measure),
            _rows(document, name, variant, where, measure),
        )
        for name, measure in pairs
    ]
    chances = holm([_p(document, *rows, m) for rows, (_, m) in zip(compared, pairs, strict=True)])
    header = [f"{reference} against", *[text for m in measures for text in (measure_heading(m), "p")]]
    table = [header]
    for name in others:
        cells = []
        for (other, measure), rows, chance in zip(pairs, compared, chances, strict=True):
            if other == name:
                cells += [_change(*rows, measure), _p_text(chance)]
        table.append([name, *cells])
    return table


def _p(document: Document, ours: Sums, theirs: Sums, measure: str) -> float:
    rng = np.random.default_rng(document["seed"])
    return paired_test(ours, theirs, rng, MEASURES[measure].statistic)


def _tested(ours: Sums, theirs: Sums, measure: str, p: float) -> str:
    """A change with its p value."""
    change = _change(ours, theirs, measure)
    return change if change == NOTHING else f"{change}, {_p_text(p)}"


def _change(ours: Sums, theirs: Sums, measure: str) -> str:
    """Errors change by a share, correlations by a difference."""
    first, second = measure_value(measure, ours), measure_value(measure, theirs)
    if np.isnan(first) or np.isnan(second):
        return NOTHING
    if MEASURES[measure].better != "less":
        return f"{first - second:+.3f}"
    return f"{100 * (first / second - 1):+.1f} %"


def _p_text(p: float) -> str:
    if np.isnan(p):
        return NOTHING
    return f"{p:.4f}" if p < SIGNIFICANT else f"({p:.2f})"


def _rows(document: Document, name: str, variant: str, where: str, measure: str) -> Sums:
    found = model_rows(document, name, variant, where)
    if found is None:
        raise KeyError(f"{name} was not measured in {where}")
    return found[measure]


def conditions_table(document: Document, variant: str, frames: str, measure: str) -> Table:
    """One row per model: a measure on the clean test clips and under each condition; the best in bold."""
    names, conditions = list(document["models"]), list(document["conditions"])
    places = [f"test/{frames}", *[f"with {condition}/{frames}" for condition in conditions]]
    columns = [_column(document, names, variant, where, measure) for where in places]
    header = ["model", "clean", *conditions]
    return [header, *[list(row) for row in zip(names, *columns, strict=True)]]


def losses_table(document: Document, variant: str, frames: str, measure: str) -> Table:
    """Change of each model's clean score under each condition, with its p, Holm-corrected together."""
    cells = {
        (name, condition): (
            _rows(document, name, variant, f"with {condition}/{frames}", measure),
            _rows(document, name, variant, f"test/{frames}", measure),
        )
        for name in document["models"]
        for condition in document["conditions"]
    }
    return _grid(document, "model", cells, measure)


def conditions_difference_table(document: Document, variant: str, frames: str, measure: str) -> Table:
    """Difference of each model from the reference under the same condition, p Holm-corrected together."""
    reference = document["reference"]
    cells = {
        (name, condition): (
            _rows(document, reference, variant, f"with {condition}/{frames}", measure),
            _rows(document, name, variant, f"with {condition}/{frames}", measure),
        )
        for name in document["models"]
        for condition in document["conditions"]
        if name != reference
    }
    return _grid(document, f"{reference} against", cells, measure)


def _grid(
    document: Document, title: str, cells: dict[tuple[str, str], tuple[Sums, Sums]], measure: str
) -> Table:
    """Pairs of sums by model and condition: a row per model, each change with its p value."""
    tested = [key for key, (ours, theirs) in cells.items() if not np.array_equal(ours, theirs)]
    p = dict(zip(tested, holm([_p(document, *cells[key], measure) for key in tested]), strict=True))
    texts = {key: _tested(*cells[key], measure, p[key]) if key in p else "same" for key in cells}
    names, conditions = dict.fromkeys(name for name, _ in cells), document["conditions"]
    rows = [[name, *[texts[name, condition] for condition in conditions]] for name in names]
    return [[title, *conditions], *rows]


def aligner_table(document: Document) -> Table:
    """Errors of the aligner under each condition."""
    table = [["condition", "clips not aligned", "frames of speech with another phone than labelled"]]
    for name, found in document["conditions"].items():
        missed = f"{found['not_aligned']} of {found['clips']}"
        table.append([name, missed, f"{100 * found['other_phone']:.0f} %"])
    return table


def ema_table(document: Document) -> Table:
    """Lip aperture r of each utterance of another speaker, with and without contacts."""
    named = {n: m["ema"] for n, m in document["models"].items() if "ema" in m}
    if not named:
        return []
    count = len(next(iter(named.values()))["raw"]["aperture_r"])
    header = ["model", "aperture r, mean", *[f"utterance {i + 1}" for i in range(count)]]
    header += ["with contacts", *[f"utterance {i + 1}" for i in range(count)], "lag, ms"]
    table = [header]
    for name, found in named.items():
        row = [name]
        for variant in ("raw", "contacts"):
            sums = np.array(found[variant]["aperture_r"])
            # Sensors are at another height in each recording, so utterances are averaged, not pooled.
            each = pearson(sums)
            row += [_number(r) for r in (each.mean(), *each)]
        table.append([*row, " ".join(f"{lag:+.0f}" for lag in found["contacts"]["lag_ms"])])
    return table


COSTS: dict[str, Callable[[Document], str]] = {
    "driven by": lambda found: str(found["driven_by"]),
    "parameters": lambda found: f"{found['numbers']:,}",
    "MB": lambda found: f"{found['bytes'] / 1e6:.1f}",
    "training, min": lambda found: "" if found["training_s"] is None else f"{found['training_s'] / 60:.1f}",
    "frames/s": lambda found: f"{found['frames_per_s']:,.0f}",
    "a line, ms": lambda found: f"{found['line_ms']:.1f}",
    "look-ahead, ms": lambda found: str(found["look_ahead"]),
    "memory, MB": lambda found: f"{found['memory_mb']:.0f}",
}


def cost_table(document: Document) -> Table:
    """The cost of each model: size, training, speed, memory and look-ahead."""
    rows = [[name, *[show(found) for show in COSTS.values()]] for name, found in document["models"].items()]
    return [["model", *COSTS], *rows]


def sweep_table(found: dict[str, Any], measure: str) -> Table:
    """A sweep: one row per value, one column per series; "speech_" before a measure: in speech."""
    series = list(dict.fromkeys(str(row.get(found["series"], "")) for row in found["rows"]))
    alone = measure_heading(measure.removeprefix("speech_"))
    named = [f"{found['series']} {s}" if found["series"] else alone for s in series]
    table = [[found["x"], *named]]
    for x in dict.fromkeys(str(row[found["x"]]) for row in found["rows"]):
        picked = {
            str(row.get(found["series"], "")): row[measure]
            for row in found["rows"]
            if str(row[found["x"]]) == x
        }
        table.append([x, *[_number(picked[s]) if s in picked else "" for s in series]])
    return table


def _number(number: float) -> str:
    return NOTHING if np.isnan(number) else f"{number:.3f}"
