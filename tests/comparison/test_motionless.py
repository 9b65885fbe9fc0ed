"""A model that does not move has no correlation: every table has a dash and a note, and no test is made."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phonanim.comparison import tables
from phonanim.comparison.scores import short
from phonanim.evaluation.statistics import pearson_sums

R = "aperture_r"
TRUTH = np.random.default_rng(0).normal(10, 1, (8, 30))
NOISE = np.random.default_rng(1).normal(0, 1, TRUTH.shape)


def clips(curves: Any) -> dict[str, Any]:
    """Sums of curves (clips, frames) as they are stored."""
    sums = [short(pearson_sums(curve, truth)) for curve, truth in zip(curves, TRUTH, strict=True)]
    return dict.fromkeys((R, "width_r"), sums)


@pytest.fixture
def document() -> dict[str, Any]:
    """Three models that move on the clean clips; in noise one of them rests, as the capture never does."""
    clean = {"ours": TRUTH + NOISE, "other": TRUTH + 2 * NOISE, "resting": TRUTH + 3 * NOISE}
    noisy = clean | {"resting": np.full(TRUTH.shape, 5.4321987654321)}
    models = {
        name: {"scores": {"raw": {"test/all": clips(clean[name]), "with noise/all": clips(noisy[name])}}}
        for name in clean
    }
    return {"reference": "ours", "seed": 0, "models": models, "conditions": {"noise": {}}}


@pytest.mark.filterwarnings("error")
def test_every_table_has_a_dash_for_it(document: dict[str, Any]) -> None:
    where = "with noise/all"
    found = {
        "values": tables.values_table(document, "raw", where, (R,)),
        "conditions": tables.conditions_table(document, "raw", "all", R),
        "losses": tables.losses_table(document, "raw", "all", R),
        "differences": tables.differences_table(document, "raw", where, (R,)),
        "under a condition": tables.conditions_difference_table(document, "raw", "all", R),
    }
    last = {name: table[-1] for name, table in found.items()}
    assert last["values"] == ["resting", "–"]
    assert last["conditions"][2] == "–"
    assert last["losses"] == ["resting", "–"]
    assert last["differences"] == ["resting", "–", "–"]
    assert last["under a condition"] == ["resting", "–"]
    assert "nan" not in str(found)
    for table in found.values():
        assert tables.markdown(table).endswith("\n\n–: no correlation, because a curve does not move.")


def test_it_is_no_test_that_others_are_corrected_for(document: dict[str, Any]) -> None:
    (cell,) = tables.conditions_difference_table(document, "raw", "all", R)[1][1:]
    del document["models"]["resting"]
    assert tables.conditions_difference_table(document, "raw", "all", R)[1][1:] == [cell]


def test_its_size_is_zero_and_known(document: dict[str, Any]) -> None:
    size = tables.size_table(document, "raw", "with noise/all")
    assert size[-1] == ["resting", *["0.00 [0.00, 0.00]"] * 4]
    assert "–" not in tables.markdown(size)
