"""Products that have the same bits whatever the order of their sums."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from phonanim.core.exact import exact_layer, inverse, ordered_product, rounded, sparse_product

ROOT = Path(__file__).resolve().parent.parent.parent
CORES = ("Haswell", "Zen", "SkylakeX", "Nehalem", "Prescott")


def test_the_order_of_inputs_changes_no_bit() -> None:
    rng = np.random.default_rng(0)
    rows, weights = rng.normal(size=(50, 700)).astype(np.float32), rng.normal(size=(700, 9))
    bias = rng.normal(size=9)
    order = rng.permutation(700)
    first = exact_layer(weights, bias)(rows)
    np.testing.assert_array_equal(exact_layer(weights[order], bias)(rows[:, order]), first)
    assert not np.array_equal(rows[:, order] @ weights[order].astype(np.float32), rows @ weights.astype("f4"))


def test_products_are_as_near_as_those_of_float32() -> None:
    rng = np.random.default_rng(1)
    rows, weights = rng.normal(size=(50, 256)) * 1e3 ** rng.normal(size=(50, 1)), rng.normal(size=(256, 9))
    true = rows @ weights
    scale = np.abs(rows) @ np.abs(weights)
    assert (np.abs(exact_layer(weights, np.zeros(9))(rows) - true) / scale).max() < 5e-7


def test_rows_of_zeros_and_weights_of_zero_give_the_bias() -> None:
    layer = exact_layer(np.zeros((3, 2)), np.array([1.0, -2.0]))
    np.testing.assert_array_equal(layer(np.zeros((4, 3), np.float32)), np.tile([1.0, -2.0], (4, 1)))


def test_sums_stay_whole_at_the_limit() -> None:
    """Rows and weights that are all as large as they may be."""
    layer = exact_layer(np.full((1000, 1), 0.999999), np.zeros(1))
    unit = 2.0 ** (np.frexp(1000.0)[1] - 29)  # the weights' own
    whole = np.rint(np.full(1000, 0.999999) * 2.0**22).sum() * layer.weights[0, 0] / unit
    assert np.abs(layer.weights).sum() / unit * 2.0**22 < 2.0**53 > whole
    assert whole == np.rint(whole)


def test_values_are_rounded_to_their_bits() -> None:
    rng = np.random.default_rng(3)
    values = rng.normal(size=(30, 50)) * 10.0 ** rng.integers(-9, 9, (30, 1))
    values[0] = np.arange(50) / 2  # with ties
    values[0, -1] = 2.0**22
    size = np.frexp(np.abs(values).max(axis=1))[1][:, None]
    unit = np.ldexp(1.0, size - 22)
    np.testing.assert_array_equal(rounded(values.copy(), size), np.rint(values / unit) * unit)


def test_small_products_are_those_of_numpy() -> None:
    rng = np.random.default_rng(2)
    left, right = rng.normal(size=(20, 7)), rng.normal(size=(7, 5))
    np.testing.assert_allclose(ordered_product(left, right), left @ right, rtol=1e-13)
    np.testing.assert_allclose(ordered_product(left, right[:, 0]), left @ right[:, 0], rtol=1e-13)
    table = np.where(rng.random((7, 5)) < 0.3, right, 0.0)
    np.testing.assert_allclose(sparse_product(left, table), left @ table, rtol=1e-12, atol=1e-15)
    assert sparse_product(left.astype(np.float32), table).dtype == np.float32
    gram = right @ right.T + np.eye(7)
    np.testing.assert_allclose(inverse(gram), np.linalg.inv(gram), rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize("rig", ["arkit_tongue", "metahuman", "oculus15"])
def test_a_line_has_the_same_bytes_on_every_kernel(rig: str, tmp_path: Path) -> None:
    """OpenBLAS has other code for each type of processor; a type that cannot run here is left out."""
    found = {}
    for core in CORES:
        out = tmp_path / core / "line.npz"
        out.parent.mkdir()
        command = [sys.executable, "cli.py", "animate", "examples/line.TextGrid", "-o", str(out), "-q"]
        environment = {**os.environ, "OPENBLAS_CORETYPE": core}
        if not subprocess.run([*command, "--rig", rig], cwd=ROOT, env=environment, check=False).returncode:
            found[core] = out.read_bytes()
    assert found
    assert len(set(found.values())) == 1, f"{[*found]} differ"
