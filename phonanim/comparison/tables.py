"""The tables of a comparison, as rows of text: values with intervals, differences with their p."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.comparison.run import rows_of
from phonanim.comparison.scores import MEASURES, value
from phonanim.statistics import bootstrap_interval, holm, paired_test, pearson

Table = list[list[str]]
Document = dict[str, Any]
SIGNIFICANT = 0.05


def markdown(table: Table) -> str:
    """A table with its header row first, as Markdown; numbers stand at the right."""
    rule = ["---", *["---:"] * (len(table[0]) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [table[0], rule, *table[1:]])


def heading(measure: str) -> str:
    """A measure with its unit."""
    found = MEASURES[measure]
    return f"{found.label}, {found.unit}" if found.unit else found.label


def values(document: Document, variant: str, where: str, measures: tuple[str, ...]) -> Table:
    """One row per model: each measure with its 95 % interval over sentences; the best in bold."""
    names = [n for n in document["models"] if rows_of(document, n, variant, where) is not None]
    columns = [_column(document, names, variant, where, measure) for measure in measures]
    cells = [list(row) for row in zip(*columns, strict=True)]
    header = ["model", *[heading(measure) for measure in measures]]
    return [header, *[[name, *row] for name, row in zip(names, cells, strict=True)]]


def _column(document: Document, names: list[str], variant: str, where: str, measure: str) -> list[str]:
    found, texts = [], []
    for name in names:
        rows = _rows(document, name, variant, where, measure)
        rng = np.random.default_rng(document["seed"])
        low, high = bootstrap_interval(rows, rng, MEASURES[measure].statistic)
        found.append(value(measure, rows))
        texts.append(f"{_number(found[-1])} [{_number(low)}, {_number(high)}]")
    # A gap may be negative where lips press; nearest to nothing is best.
    away = np.abs(found) if MEASURES[measure].better == "less" else -np.array(found)
    best = int(np.nanargmin(away)) if np.isfinite(away).any() else -1
    return [f"**{text}**" if i == best else text for i, text in enumerate(texts)]


def differences(document: Document, variant: str, where: str, measures: tuple[str, ...]) -> Table:
    """How far each model is from the reference: change of each measure and its p, Holm-corrected together."""
    reference = document["reference"]
    others = [
        n for n in document["models"] if n != reference and rows_of(document, n, variant, where) is not None
    ]
    pairs = [(name, measure) for name in others for measure in measures]
    p = holm([_p(document, reference, name, variant, where, measure) for name, measure in pairs])
    header = [f"{reference} against", *[text for m in measures for text in (heading(m), "p")]]
    table = [header]
    for name in others:
        cells = []
        for (other, measure), chance in zip(pairs, p, strict=True):
            if other == name:
                cells += [_change(document, reference, name, variant, where, measure), _p_text(chance)]
        table.append([name, *cells])
    return table


def _p(document: Document, a: str, b: str, variant: str, where: str, measure: str) -> float:
    rng = np.random.default_rng(document["seed"])
    pair = [_rows(document, name, variant, where, measure) for name in (a, b)]
    return paired_test(pair[0], pair[1], rng, MEASURES[measure].statistic)


def _change(document: Document, a: str, b: str, variant: str, where: str, measure: str) -> str:
    """Errors change by a share, correlations by a difference."""
    ours, theirs = (value(measure, _rows(document, n, variant, where, measure)) for n in (a, b))
    if MEASURES[measure].statistic is pearson:
        return f"{ours - theirs:+.3f}"
    return f"{100 * (ours / theirs - 1):+.1f} %"


def _p_text(p: float) -> str:
    return f"{p:.4f}" if p < SIGNIFICANT else f"({p:.2f})"


def _rows(document: Document, name: str, variant: str, where: str, measure: str) -> NDArray[np.float64]:
    found = rows_of(document, name, variant, where)
    if found is None:
        raise KeyError(f"{name} was not measured in {where}")
    return found[measure]


def ema(document: Document) -> Table:
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
            # Sensors sit at another height in each recording, so utterances are averaged, not pooled.
            each = pearson(sums)
            row += [f"{each.mean():.3f}", *[f"{r:.3f}" for r in each]]
        table.append([*row, " ".join(f"{lag:+.0f}" for lag in found["contacts"]["lag_ms"])])
    return table


def cost(document: Document) -> Table:
    """What each model costs: numbers learned, megabytes, training time and speed."""
    table = [["model", "driven by", "numbers", "MB", "training, min", "frames/s"]]
    for name, found in document["models"].items():
        seconds = found["training_s"]
        table.append(
            [
                name,
                found["driven_by"],
                f"{found['numbers']:,}",
                f"{found['bytes'] / 1e6:.1f}",
                "" if seconds is None else f"{seconds / 60:.1f}",
                f"{found['frames_per_s']:,.0f}",
            ]
        )
    return table


def sweep(found: dict[str, Any], measure: str) -> Table:
    """A sweep: one row per value, one column per series."""
    series = list(dict.fromkeys(str(row.get(found["series"], "")) for row in found["rows"]))
    named = [f"{found['series']} {s}" if found["series"] else heading(measure) for s in series]
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
    return f"{number:.3f}"
