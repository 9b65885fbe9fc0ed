"""Matrix products with the same bits on every processor, whatever the order in which it adds.

BLAS libraries add in another order on each type of processor, so that the last bits of a product differ.
Here factors are rounded to multiples of a power of two, so fine that float64 holds the sums, too, exactly.
Then no order matters. Smaller products are added in one order without BLAS.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
T = TypeVar("T", bound=np.floating)

BITS = 22
"""Of an input, relative to the largest of its row: an error of a few ten-millionths, as float32 has."""
ROOM = 52 - BITS
"""Bits of the absolute weights of a column in sum, so that whole sums stay below 2**53."""


@dataclass(frozen=True)
class ExactLayer:
    """`weights` (inputs, outputs), multiples of a power of two in each column, and `bias` (outputs,)."""

    weights: Array
    bias: Array

    def __call__(self, rows: NDArray[np.floating]) -> Array:
        """Rows times weights, plus the bias, (rows, inputs) -> (rows, outputs); each row by itself."""
        size = np.frexp(np.abs(rows).max(axis=1, initial=0.0))[1][:, None]
        found: Array = rounded(rows.astype(np.float64), size) @ self.weights
        found += self.bias
        return found


def exact_layer(weights: NDArray[np.floating], bias: NDArray[np.floating]) -> ExactLayer:
    """A layer of weights (inputs, outputs) and a bias (outputs,)."""
    most = np.abs(weights).sum(axis=0, dtype=np.float64)
    unit = unit_below(most + np.finfo(np.float64).tiny)
    return ExactLayer(np.rint(weights / unit) * unit, bias.astype(np.float64))


def rounded(values: Array, size: NDArray[np.integer] | int) -> Array:
    """Values up to 2**size, to the nearest multiples of 2**(size - BITS), halves to the even one, in place.

    Next to a number whose last bit is that multiple, there is no room for less.
    """
    beside = np.ldexp(1.5, size + 52 - BITS)
    values += beside
    values -= beside
    return values


def unit_below(most: Array) -> Array:
    """The power of two of which `most` (n,) > 0, the absolute weights in sum, has 2**ROOM at most."""
    return np.ldexp(1.0, np.frexp(most)[1] + 1 - ROOM)


def ordered_product(left: NDArray[T], right: NDArray[T], out: NDArray[T] | None = None) -> NDArray[T]:
    """A small product (n, k) x (k, m) -> (n, m), or (k,) -> (n,), added in one order without BLAS."""
    found: NDArray[T] = np.einsum("nk,k->n" if right.ndim == 1 else "nk,km->nm", left, right, out=out)
    return found


def sparse_product(left: NDArray[T], table: NDArray[np.floating]) -> NDArray[T]:
    """A product (n, k) x (k, m) -> (n, m) with a table that is mostly zero, added in the order of k."""
    rows = np.ascontiguousarray(left.T)
    found = np.zeros((table.shape[1], len(left)), left.dtype)
    for source, goal in np.argwhere(table).tolist():
        found[goal] += rows[source] * left.dtype.type(table[source, goal])
    return np.ascontiguousarray(found.T)


def inverse(matrix: Array) -> Array:
    """The inverse of a symmetric positive definite matrix, (n, n), eliminated in one order without LAPACK."""
    return _inverse(matrix.tobytes(), len(matrix)).copy()


@lru_cache(maxsize=64)  # the lines of a run have the same few matrices
def _inverse(matrix: bytes, count: int) -> Array:
    work = np.concatenate([np.frombuffer(matrix).reshape(count, count), np.eye(count)], axis=1)
    for row in range(count):
        work[row] /= work[row, row]
        others = work[:, row].copy()
        others[row] = 0.0
        work -= others[:, None] * work[row]
    return np.ascontiguousarray(work[:, count:])
