"""Confidence intervals and tests, with the sentence (clip, judgement) as the unit.

A measure that pools frames over sentences, such as a correlation, is a function of sums: each sentence gives
a row of sums, (sentences, sums), and a `Statistic` turns the total of some rows into a number. So resampling
and exchanging work on rows, and are exact for any measure.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError

Array = NDArray[np.float64]
Statistic = Callable[[Array], Array]  # totals (..., sums) -> (...,)
RESAMPLES = 10_000
CHUNK = 1000  # resamples at once, so that memory use does not grow
ROUNDING = 1e-7  # of sums that are kept with nine digits: a smaller spread is no motion


def ratio(totals: Array) -> Array:
    """Mean from (sum, count), (..., 2) -> (...,); NaN where the count is 0."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(totals[..., 0] / totals[..., 1])


def pearson(totals: Array) -> Array:
    """Pearson's r from (n, Σa, Σb, Σa², Σb², Σab), (..., 6) -> (...,); NaN for a motionless curve."""
    n, a, b, _, _, ab = np.moveaxis(totals, -1, 0)
    spread = np.prod(_spreads(totals), axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((n * ab - a * b) / np.sqrt(np.where(spread > 0, spread, np.nan)))


def pearson_sums(a: NDArray[np.floating], b: NDArray[np.floating]) -> Array:
    """The six sums of two curves, (frames,) each, for `pearson`."""
    a, b = a.astype(np.float64), b.astype(np.float64)
    return np.array([len(a), a.sum(), b.sum(), (a * a).sum(), (b * b).sum(), (a * b).sum()])


def pooled_sd_ratio(totals: Array) -> Array:
    """Deviation of the first over that of the second curve, from sums as for `pearson`, -> (...,).

    0 where the first does not move, NaN where the second does not.
    """
    ours, theirs = _spreads(totals)
    return np.asarray(np.sqrt(ours / np.where(theirs > 0, theirs, np.nan)))


def pooled_slope(totals: Array) -> Array:
    """Slope of the first on the second curve, from the sums of `pearson`; NaN where that does not move."""
    n, a, b, _, _, ab = np.moveaxis(totals, -1, 0)
    ours, theirs = _spreads(totals)
    shared = np.where(ours == 0, 0.0, n * ab - a * b)
    return np.asarray(shared / np.where(theirs > 0, theirs, np.nan))


def _spreads(totals: Array) -> tuple[Array, Array]:
    """N Σx² - (Σx)² of both curves, 0 where it is no more than the rounding of the sums."""
    n, a, b, aa, bb, _ = np.moveaxis(totals, -1, 0)
    return _spread(n, a, aa), _spread(n, b, bb)


def _spread(n: Array, total: Array, square: Array) -> Array:
    found = n * square - total * total
    return np.where(found <= ROUNDING * n * square, 0.0, found)


def bootstrap_interval(
    rows: Array,
    rng: np.random.Generator,
    statistic: Statistic = ratio,
    level: float = 0.95,
    resamples: int = RESAMPLES,
) -> tuple[float, float]:
    """Percentile interval of a statistic when sentences are resampled, (sentences, sums) -> (low, high).

    Source: Efron and Tibshirani 1993, section 13.3. A plain mean of values (n,) is
    `bootstrap_interval(mean_rows(values), rng)`. Raises ValueError when there are no sentences,
    MissingExtraError without scipy.
    """
    if len(rows) == 0:
        raise ValueError("no sentences to draw from")
    if np.isnan(rows).any():
        return float("nan"), float("nan")
    if len(rows) == 1:  # every resample is the same
        return (only := float(statistic(rows[0]))), only
    stats = _scipy_stats()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)  # the result is NaN anyway
        resampled = stats.bootstrap(
            tuple(rows.T),
            lambda *sums, axis: statistic(np.stack([drawn.sum(axis=axis) for drawn in sums], axis=-1)),
            n_resamples=resamples,
            batch=CHUNK,
            paired=True,
            method="percentile",
            rng=rng,
        )
    values = resampled.bootstrap_distribution
    tail = 100 * (1 - level) / 2
    if np.isnan(values).all():  # a statistic of constant curves
        return float("nan"), float("nan")
    low, high = np.nanpercentile(values, [tail, 100 - tail])
    return float(low), float(high)


def seeded_interval(
    rows: Array,
    rng: np.random.Generator,
    statistic: Statistic = ratio,
    level: float = 0.95,
    resamples: int = RESAMPLES,
) -> tuple[float, float]:
    """Percentile interval when sentences and seeds are resampled, (sentences, seeds, sums) -> (low, high).

    Both are drawn with replacement, each on its own, since every sentence is predicted by every seed (Owen
    2007, "The pigeonhole bootstrap"). Few seeds tell little of other seeds: three give a rough idea.
    Raises ValueError when there are no sentences.
    """
    if len(rows) == 0:
        raise ValueError("no sentences to draw from")
    values = []
    for begin in range(0, resamples, CHUNK):
        count = min(CHUNK, resamples - begin)
        sentences, seeds = (
            rng.multinomial(size, np.full(size, 1 / size), count).astype(np.float64)
            for size in rows.shape[:2]
        )
        over = np.einsum("rn,nks->rks", sentences, rows)
        values.append(statistic(np.einsum("rk,rks->rs", seeds, over)))
    found = np.concatenate(values)
    if np.isnan(found).all():
        return float("nan"), float("nan")
    tail = 100 * (1 - level) / 2
    low, high = np.nanpercentile(found, [tail, 100 - tail])
    return float(low), float(high)


def mean_rows(values: NDArray[np.floating]) -> Array:
    """Values (n,) as rows (n, 2) whose `ratio` is their mean."""
    return np.column_stack([values, np.ones(len(values))]).astype(np.float64)


def paired_test(
    a: Array,
    b: Array,
    rng: np.random.Generator,
    statistic: Statistic = ratio,
    resamples: int = RESAMPLES,
) -> float:
    """Two-sided permutation test of statistic(a) = statistic(b), (sentences, sums) each -> p.

    If the two models were equal, their names could be exchanged in any sentence (Fisher 1935, section 21;
    Edgington 1995, chapter 5). p is the share of the randomly drawn exchanges, including the observed one,
    in which the models differ by at least the observed difference. It is never below 1 / (resamples + 1).
    An exchange after which a statistic is not a number counts as well. NaN if the observed difference is not
    a number. Raises ValueError when the sentences are not paired.
    """
    if a.shape != b.shape:
        raise ValueError(f"sentences of two models must pair: {a.shape} and {b.shape}")
    observed = abs(float(statistic(a.sum(axis=0)) - statistic(b.sum(axis=0))))
    if not np.isfinite(observed):
        return float("nan")
    total, change = a.sum(axis=0) + b.sum(axis=0), b - a
    extreme = 0
    for begin in range(0, resamples, CHUNK):
        exchanged = rng.random((min(CHUNK, resamples - begin), len(a))) < 0.5
        first = a.sum(axis=0) + exchanged @ change
        apart = np.abs(statistic(first) - statistic(total - first))
        extreme += int((~(apart < observed * (1 - 1e-9))).sum())
    return (extreme + 1) / (resamples + 1)


def holm(p: Sequence[float]) -> list[float]:
    """Adjusted p values of several tests (Holm 1979), in the given order; NaN stays NaN, uncounted."""
    known = [index for index in np.argsort(p, kind="stable") if not np.isnan(p[index])]
    adjusted, highest = [float("nan")] * len(p), 0.0
    for rank, index in enumerate(known):
        highest = max(highest, min(1.0, (len(known) - rank) * p[index]))
        adjusted[index] = highest
    return adjusted


def sign_test(wins: int, losses: int) -> float:
    """Two-sided exact sign test; ties are left out (Dixon and Mood 1946)."""
    return binomial_test(wins, wins + losses) if wins + losses else 1.0


def binomial_test(successes: int, trials: int, chance: float = 0.5) -> float:
    """Two-sided exact binomial test (Clopper and Pearson 1934).

    p sums all outcomes that are not more likely than the observed one.

    Raises ValueError when there are more successes than trials.
    """
    if not 0 <= successes <= trials:
        raise ValueError(f"{successes} successes in {trials} trials")
    return float(_scipy_stats().binomtest(successes, trials, chance).pvalue)


def _scipy_stats() -> Any:
    """scipy.stats, imported on demand. Raises MissingExtraError, which names the extra."""
    try:
        from scipy import stats
    except ImportError as error:
        raise MissingExtraError("intervals and tests need scipy: pip install 'phonanim[evaluate]'") from error
    return stats
