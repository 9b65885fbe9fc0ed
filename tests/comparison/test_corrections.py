"""Several tests are corrected together: by hand, on sums whose p values are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phonanim.comparison import tables, tools
from phonanim.evaluation.statistics import mean_rows, paired_test

MEASURE = "shape_mse"


def sums(level: float, clips: int = 6) -> dict[str, Any]:
    """Clips with one frame each, of errors a little above and below a level."""
    errors = level + 0.01 * np.arange(clips)
    return {MEASURE: [[error, 1.0] for error in errors]}


def document(others: int) -> dict[str, Any]:
    """A reference, and models that are worse than it in each of six clips: p is about 2 / 64 alone."""
    levels = {"ours": 1.0} | {f"other{n}": 2.0 for n in range(others)}
    models = {name: {"scores": {"raw": {"test/all": sums(level)}}} for name, level in levels.items()}
    return {"reference": "ours", "seed": 0, "models": models, "conditions": {}}


def chances(table: list[list[str]]) -> list[float]:
    return [float(row[-1].strip("()*")) for row in table[1:]]


def alone() -> float:
    rows = [np.array(sums(level)[MEASURE]) for level in (1.0, 2.0)]
    return paired_test(rows[0], rows[1], np.random.default_rng(0))


def test_one_test_needs_no_correction() -> None:
    assert 0.02 < alone() < 0.05
    (found,) = chances(tables.differences_table(document(1), "raw", "test/all", (MEASURE,)))
    assert found == pytest.approx(alone(), rel=0.02)


def test_four_tests_are_corrected_together() -> None:
    """Holm: the least of four p is multiplied by four, and no larger one may fall below it."""
    found = chances(tables.differences_table(document(4), "raw", "test/all", (MEASURE,)))
    assert found == [pytest.approx(4 * alone(), rel=0.02)] * 4


def test_conditions_are_corrected_together() -> None:
    made = document(2)
    for row in made["models"].values():
        scores = row["scores"]["raw"]
        scores |= {f"with {name}/all": scores["test/all"] for name in ("noise", "voice")}
    made["conditions"] = {"noise": {}, "voice": {}}
    _, *rows = tables.conditions_difference_table(made, "raw", "all", MEASURE)
    found = [float(cell.rpartition(", ")[2].strip("()*")) for row in rows for cell in row[1:]]
    assert found == [pytest.approx(4 * alone(), rel=0.02)] * 4


def test_other_tools_are_corrected_together() -> None:
    def clips(level: float) -> dict[str, Any]:
        return {str(n): dict.fromkeys(tools.COLUMNS, level + 0.01 * n) for n in range(6)}

    found = {}
    for count in (1, 3):
        others = {f"other{n}": clips(2.0) for n in range(count)}
        table = tools.tools_table({tools.OURS: clips(1.0)} | others, 0)
        found[count] = [float(cell.rpartition("p ")[2]) for row in table for cell in row if ", p " in cell]
    raw = paired_test(
        mean_rows(1.0 + 0.01 * np.arange(6)), mean_rows(2.0 + 0.01 * np.arange(6)), np.random.default_rng(0)
    )
    assert found[1] == [pytest.approx(len(tools.TESTED) * raw, rel=0.02)] * len(tools.TESTED)
    assert found[3] == [pytest.approx(3 * len(tools.TESTED) * raw, rel=0.02)] * (3 * len(tools.TESTED))
