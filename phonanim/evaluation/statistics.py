"""How sure a difference is: intervals and tests with the sentence (clip, judgement) as the unit.

A measure that pools frames over sentences, as a correlation does, is a function of sums: each sentence
gives a row of sums, (sentences, sums), and `Statistic` turns the total of some rows into a number.
Resampling and exchanging then work on rows, and stay exact for any measure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Statistic = Callable[[Array], Array]  # totals (..., sums) -> (...,)
RESAMPLES = 10_000
CHUNK = 1000  # resamples at once, so that memory stays flat


def ratio(totals: Array) -> Array:
    """Mean from (sum, count), (..., 2) -> (...,); NaN where nothing was counted."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(totals[..., 0] / totals[..., 1])


def pearson(totals: Array) -> Array:
    """Pearson's r from (n, Σa, Σb, Σa², Σb², Σab), (..., 6) -> (...,); NaN where a curve never moves."""
    n, a, b, aa, bb, ab = np.moveaxis(totals, -1, 0)
    spread = (n * aa - a * a) * (n * bb - b * b)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((n * ab - a * b) / np.sqrt(np.where(spread > 0, spread, np.nan)))


def pearson_sums(a: NDArray[np.floating], b: NDArray[np.floating]) -> Array:
    """The six sums of two curves, (frames,) each, that `pearson` needs."""
    a, b = a.astype(np.float64), b.astype(np.float64)
    return np.array([len(a), a.sum(), b.sum(), (a * a).sum(), (b * b).sum(), (a * b).sum()])


def bootstrap_interval(
    rows: Array,
    rng: np.random.Generator,
    statistic: Statistic = ratio,
    level: float = 0.95,
    resamples: int = RESAMPLES,
) -> tuple[float, float]:
    """Percentile interval of a statistic when sentences are drawn anew, (sentences, sums) -> (low, high).

    Source: Efron and Tibshirani 1993, section 13.3. A plain mean of values (n,) is
    `bootstrap_interval(mean_rows(values), rng)`. Raises ValueError when there are no sentences.
    """
    if len(rows) == 0:
        raise ValueError("no sentences to draw from")
    found = []
    for begin in range(0, resamples, CHUNK):
        drawn = rng.integers(len(rows), size=(min(CHUNK, resamples - begin), len(rows)))
        counts = np.apply_along_axis(np.bincount, 1, drawn, minlength=len(rows))
        found.append(statistic(counts @ rows))
    tail = 100 * (1 - level) / 2
    values = np.concatenate(found)
    if np.isnan(values).all():  # a statistic of curves that never move
        return float("nan"), float("nan")
    low, high = np.nanpercentile(values, [tail, 100 - tail])
    return float(low), float(high)


def mean_rows(values: NDArray[np.floating]) -> Array:
    """Values (n,) as the rows (n, 2) whose `ratio` is their mean."""
    return np.column_stack([values, np.ones(len(values))]).astype(np.float64)


def paired_test(
    a: Array,
    b: Array,
    rng: np.random.Generator,
    statistic: Statistic = ratio,
    resamples: int = RESAMPLES,
) -> float:
    """Two-sided permutation test of statistic(a) = statistic(b), (sentences, sums) each -> p.

    If the two models were alike, their names could be exchanged in any sentence (Fisher 1935, section 21;
    Edgington 1995, chapter 5). p counts the exchanges, drawn at random, that part the models at least as far
    as they are, the observed one among them, so it is never below 1 / (resamples + 1).
    Raises ValueError when the sentences are not paired.
    """
    if a.shape != b.shape:
        raise ValueError(f"sentences of two models must pair: {a.shape} and {b.shape}")
    observed = abs(float(statistic(a.sum(axis=0)) - statistic(b.sum(axis=0))))
    total, change = a.sum(axis=0) + b.sum(axis=0), b - a
    extreme = 0
    for begin in range(0, resamples, CHUNK):
        exchanged = rng.random((min(CHUNK, resamples - begin), len(a))) < 0.5
        first = a.sum(axis=0) + exchanged @ change
        apart = np.abs(statistic(first) - statistic(total - first))
        extreme += int((apart >= observed * (1 - 1e-9)).sum())
    return (extreme + 1) / (resamples + 1)


def holm(p: Sequence[float]) -> list[float]:
    """Adjusted p values of several tests (Holm 1979), in the order given."""
    order = np.argsort(p, kind="stable")
    adjusted, highest = [0.0] * len(p), 0.0
    for rank, index in enumerate(order):
        highest = max(highest, min(1.0, (len(p) - rank) * p[index]))
        adjusted[index] = highest
    return adjusted


def sign_test(wins: int, losses: int) -> float:
    """Two-sided exact sign test; ties are left out (Dixon and Mood 1946)."""
    n = wins + losses
    tail = sum(comb(n, k) for k in range(min(wins, losses) + 1))
    return min(1.0, 2 * tail / 2**n)


def binomial_test(successes: int, trials: int, chance: float = 0.5) -> float:
    """Two-sided exact binomial test: every outcome no likelier than the one seen (Clopper and Pearson 1934).

    Raises ValueError when there are more successes than trials.
    """
    if not 0 <= successes <= trials:
        raise ValueError(f"{successes} successes in {trials} trials")
    exact = Fraction(chance)
    likely = [comb(trials, k) * exact**k * (1 - exact) ** (trials - k) for k in range(trials + 1)]
    return float(min(1, sum(p for p in likely if p <= likely[successes])))
