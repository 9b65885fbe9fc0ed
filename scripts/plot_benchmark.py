"""Draw the figures of the benchmark again from its committed tables, without any training.

    python scripts/plot_benchmark.py docs/benchmark

Draws bars, cost, conditions and the sweeps from benchmark.json, with the functions of `phonanim compare`. The
figures of single sentences, frames and landmarks need the sums of a comparison: `phonanim compare PLAN
--report-only`. Needs phonanim[plots].
"""

from __future__ import annotations

import argparse
import json
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.comparison import plots
from phonanim.comparison.figures import SETTINGS, draw_file
from phonanim.comparison.tables import NOTHING

REFERENCE = "phonanim"
Rows = list[list[str]]


def main() -> None:
    """Read the tables, and write each figure beside them."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("folder", type=Path, help="folder with benchmark.json")
    folder = options.parse_args().folder
    tables = json.loads((folder / "benchmark.json").read_text("utf-8"))
    draw_file(partial(bars, tables=tables), folder / "bars.png")
    draw_file(partial(cost, tables=tables), folder / "cost.png")
    draw_file(partial(conditions, tables=tables), folder / "conditions.png")
    for name in ("window", "features", "amount"):
        draw_file(partial(sweep, tables=tables, name=name), folder / f"sweep_{name}.png")


def find(tables: list[dict[str, Any]], page: str, *columns: str, place: int = 0) -> Rows:
    """The rows of the table at `place` among those of a page that have some columns."""
    found = [one["rows"] for one in tables if one["page"] == page and set(columns) <= set(one["rows"][0])]
    rows: Rows = found[place]
    return rows


def interval(cell: str) -> list[float]:
    """Value, low and high of a cell such as "**0.455 [0.408, 0.505]**"; a dash is not a number."""
    if cell == NOTHING:
        return [math.nan] * 3
    return [
        float(part) for part in cell.strip("*").replace("[", "").replace("]", "").replace(",", "").split()
    ]


def column(rows: Rows, name: str) -> list[str]:
    """The cells of a column, below its heading."""
    return [row[rows[0].index(name)] for row in rows[1:]]


def models(tables: list[dict[str, Any]]) -> list[plots.Shown]:
    """Every model with its input."""
    rows = find(tables, "cost", "frames/s")
    pairs = zip(column(rows, "model"), column(rows, "driven by"), strict=True)
    return [plots.Shown(name, driven_by, name == REFERENCE) for name, driven_by in pairs]


def bars(figure: Any, tables: list[dict[str, Any]]) -> None:
    """The error and the lip gap of the table on the first page, with their intervals."""
    rows = find(tables, "", "aperture r", "visemes read right")
    shown = {one.name: one for one in models(tables)}
    rows = [rows[0], *(row for row in rows[1:] if row[0] in shown)]
    labels = {"vertex error, mm": "vertex error, mm", "aperture r in speech": "aperture r"}
    panels = {
        label: np.array([interval(cell) for cell in column(rows, name)]) for label, name in labels.items()
    }
    plots.draw_bars(figure, [shown[name] for name in column(rows, "model")], panels)


def cost(figure: Any, tables: list[dict[str, Any]]) -> None:
    """Speed against error."""
    costs, label = find(tables, "cost", "frames/s"), "shape MSE, mm²"
    speeds = [float(cell.replace(",", "")) for cell in column(costs, "frames/s")]
    errors = [interval(cell)[0] for cell in column(find(tables, "test", label, "model"), label)]
    sizes = np.array([float(cell) for cell in column(costs, "MB")])
    plots.draw_cost(figure, models(tables), np.array([speeds, errors]).T, sizes, label)


def conditions(figure: Any, tables: list[dict[str, Any]]) -> None:
    """Lip aperture r under each condition."""
    (rows,) = [
        one["rows"]
        for one in tables
        if one["heading"] == "Under each condition: aperture r" and "clean" in one["rows"][0]
    ]
    values = np.array([[interval(cell)[0] for cell in row[1:]] for row in rows[1:]])
    plots.draw_grid(figure, column(rows, "model"), rows[0][1:], values, "aperture r", 1.0)


def sweep(figure: Any, tables: list[dict[str, Any]], name: str) -> None:
    """Error by setting: over all frames, and in speech where the page has a second table."""
    first = {"window": "reach", "features": "features", "amount": "clips"}[name]
    found = [one for one in tables if one["page"] == "sweeps" and one["rows"][0][0] == first]
    label = "shape MSE, mm²"
    panels = dict(zip(("all frames", "speech"), (series(one["rows"], label) for one in found), strict=False))
    title, x_label = found[0]["heading"], SETTINGS.get(first, first)
    plots.draw_sweep(figure, title, x_label, label, panels)


def series(rows: Rows, label: str) -> dict[str, dict[str, float]]:
    """The columns of a table of a sweep: errors by setting."""
    return {
        "" if heading == label else heading: {row[0]: float(row[place]) for row in rows[1:]}
        for place, heading in enumerate(rows[0])
        if place
    }


if __name__ == "__main__":
    main()
