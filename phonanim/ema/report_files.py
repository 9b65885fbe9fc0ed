"""What a report of recordings writes: tables and one JSON file."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import write_text
from phonanim.ema.examples import Row
from phonanim.ema.measures import CUTOFF
from phonanim.ema.report import Report

Array = NDArray[np.float64]


def write_report(report: Report, output: Path) -> list[str]:
    """Write report.json, phones.csv, diphones.csv and, if there are lateral sensors, sides.csv.

    Returns their names. Raises OutputError.
    """
    output.mkdir(parents=True, exist_ok=True)
    tables = {"phones.csv": _flat(report.phones), "diphones.csv": _flat(report.diphones)}
    if report.sides:
        tables["sides.csv"] = report.sides
    for name, rows in tables.items():
        write_text(output / name, _csv(rows))
    write_text(
        output / "report.json", json.dumps(report_summary(report), indent=1, ensure_ascii=False) + "\n"
    )
    return ["report.json", *tables]


def report_summary(report: Report) -> dict[str, Any]:
    """The report without its tables, for scripts; NaN becomes null."""
    return {
        "recordings": report.recordings,
        "sensors": {name: _range(places) for name, places in report.places.items()},
        "speed_cutoff_hz": CUTOFF,
        "phones": len(report.phones),
        "diphones": len(report.diphones),
        "diphone_examples": sum(row.examples for row in report.diphones),
        "width_curvature_r": _number(width_against_curvature(report.diphones)),
        "jaw": {
            name: {
                "reach_mm": _rounded(jaw.reach),
                "area_mm2": {v: round(a, 3) for v, a in jaw.areas.items()},
            }
            for name, jaw in report.jaws.items()
        },
    }


def width_against_curvature(rows: Sequence[Row]) -> float:
    """Pearson's r over pairs of phones (Medina 2023, section 2.2.2, finds -0.384); NaN below three pairs."""
    pairs = [(row.means.get("width", np.nan), row.means.get("curvature", np.nan)) for row in rows]
    table = np.array([pair for pair in pairs if np.isfinite(pair).all()]).reshape(-1, 2)
    return float(np.corrcoef(table.T)[0, 1]) if len(table) > 2 else np.nan


def _range(places: Array) -> dict[str, Any]:
    """Median and range of a sensor, mm, and the share of samples in which it was tracked."""
    tracked = places[np.isfinite(places).all(axis=1)]
    share = round(len(tracked) / len(places), 4)
    if not len(tracked):
        return {"mean_mm": None, "reach_mm": None, "tracked": share}
    return {
        "mean_mm": _rounded(tracked.mean(axis=0)),
        "reach_mm": _rounded(np.ptp(tracked, axis=0)),
        "tracked": share,
    }


def _flat(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """A row of a table: the mean and standard deviation of each measure."""
    return [
        {"name": row.name, "kind": row.kind, "examples": row.examples}
        | {
            f"{measure}_{what}": value
            for measure in row.means
            for what, value in (("mean", row.means[measure]), ("sd", row.deviations[measure]))
        }
        for row in rows
    ]


def _csv(rows: Sequence[dict[str, Any]]) -> str:
    """CSV with six digits; NaN becomes an empty cell."""
    stream = io.StringIO()
    columns = list(dict.fromkeys(column for row in rows for column in row))
    writer = csv.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: _cell(value) for name, value in row.items()})
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return f"{value:.6g}" if isfinite(value) else ""


def _number(value: float) -> float | None:
    return round(value, 4) if isfinite(value) else None


def _rounded(values: Any) -> list[float]:
    return [round(float(value), 3) for value in values]
