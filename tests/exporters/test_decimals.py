"""Decimal text of many numbers at once has the characters of `"%.10f"`."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phonanim.animation.animation import Animation
from phonanim.exporters import csv
from phonanim.exporters._decimals import LARGEST, decimal_cells

NUMBERS = st.floats(-LARGEST, LARGEST, exclude_min=True, exclude_max=True)


def text(values: list[float]) -> str:
    return decimal_cells(np.array([values])).tobytes().replace(b"\0", b"").decode()


@given(st.lists(NUMBERS | NUMBERS.map(lambda x: round(x, 10)) | st.floats(-1, 1, width=32), min_size=1))
def test_same_characters(values: list[float]) -> None:
    assert text(values) == "".join(f"{value:.10f}," for value in values)


@pytest.mark.parametrize(
    "value",
    [0.0, -0.0, -1e-12, 0.99999999995, 0.99999999996, 9.99999999999, 998.99999999999, 2.0**-11, 5e-11],
)
def test_ties_carries_and_signs(value: float) -> None:
    assert text([value, -value]) == f"{value:.10f},{-value:.10f},"


def test_larger_numbers_have_all_their_digits(tmp_path) -> None:
    values = np.array([[0.5, 1e6], [1234567.0, -2000.0], [0.0, 1.0]], np.float32)
    take = Animation(values, ("jawOpen", "browInnerUp"), 60.0, "arkit")
    csv.write(take, tmp_path / "a.csv")
    header, *rows = (tmp_path / "a.csv").read_text().splitlines()
    places = [header.split(",").index(name) for name in ("JawOpen", "BrowInnerUp")]
    cells = [[row.split(",")[place] for place in places] for row in rows]
    assert cells == [[f"{value:.10f}" for value in row] for row in values.tolist()]
    small = dataclasses.replace(take, values=values / 1e6)
    csv.write(small, tmp_path / "b.csv")
    assert {row.count(",") for row in (tmp_path / "b.csv").read_text().splitlines()} == {header.count(",")}
