"""Intervals and tests: values worked by hand or known in closed form."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy import stats

from phonanim.errors import MissingExtraError
from phonanim.evaluation import statistics as st

RNG = np.random.default_rng


def test_pearson_from_sums_is_pearson() -> None:
    a, b = RNG(0).normal(size=(2, 40))
    parts = [st.pearson_sums(a[:15], b[:15]), st.pearson_sums(a[15:], b[15:])]
    assert st.pearson(np.sum(parts, axis=0)) == pytest.approx(np.corrcoef(a, b)[0, 1])
    assert np.isnan(st.pearson(st.pearson_sums(np.ones(5), a[:5])))


def test_the_interval_of_a_mean_covers_it_as_often_as_it_says() -> None:
    covered = 0
    for seed in range(200):
        values = RNG(seed).normal(3.0, 1.0, size=40)
        low, high = st.bootstrap_interval(st.mean_rows(values), RNG(seed + 1), resamples=500)
        covered += low <= 3.0 <= high
    assert 0.88 <= covered / 200 <= 0.98


def test_the_interval_is_the_same_for_the_same_seed() -> None:
    rows = st.mean_rows(np.arange(9.0))
    assert st.bootstrap_interval(rows, RNG(4)) == st.bootstrap_interval(rows, RNG(4))


def test_no_sentences() -> None:
    with pytest.raises(ValueError, match="no sentences to draw from"):
        st.bootstrap_interval(np.empty((0, 2)), RNG(0))


def test_the_paired_test_against_every_exchange() -> None:
    """Six pairs that all differ the same way: of 64 exchanges, two part them as far. p = 1/32."""
    a = st.mean_rows(np.arange(6.0))
    b = st.mean_rows(np.arange(6.0) + 1)
    assert st.paired_test(a, b, RNG(0), resamples=20_000) == pytest.approx(2 / 64, abs=0.005)


def test_equal_models_do_not_differ() -> None:
    a = st.mean_rows(np.arange(6.0))
    assert st.paired_test(a, a, RNG(0)) == 1.0


def test_p_values_are_even_where_nothing_differs() -> None:
    p = [
        st.paired_test(st.mean_rows(x), st.mean_rows(y), RNG(seed), resamples=200)
        for seed, (x, y) in enumerate(RNG(9).normal(size=(200, 2, 20)))
    ]
    assert 0.01 <= np.mean(np.array(p) < 0.05) <= 0.10


def test_the_paired_test_of_a_pooled_correlation() -> None:
    rng = RNG(2)
    truth = rng.normal(size=(30, 20))
    good, bad = truth + 0.3 * rng.normal(size=truth.shape), truth + 2 * rng.normal(size=truth.shape)
    rows = [np.array([st.pearson_sums(t, p) for t, p in zip(truth, g, strict=True)]) for g in (good, bad)]
    assert st.paired_test(rows[0], rows[1], rng, st.pearson, 999) == pytest.approx(0.001)


def test_unpaired_sentences() -> None:
    with pytest.raises(ValueError, match=r"must pair: \(3, 2\) and \(4, 2\)"):
        st.paired_test(np.ones((3, 2)), np.ones((4, 2)), RNG(0))


def test_holm_by_hand() -> None:
    assert st.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert st.holm([]) == []
    assert st.holm([0.9, 0.8]) == [1.0, 1.0]


def test_sign_test_by_hand() -> None:
    assert st.sign_test(5, 0) == pytest.approx(2 / 32)
    assert st.sign_test(1, 4) == pytest.approx(12 / 32)
    assert st.sign_test(0, 0) == 1.0


def test_binomial_test_by_hand() -> None:
    assert st.binomial_test(0, 5) == pytest.approx(2 / 32)
    assert st.binomial_test(2, 2, 0.25) == pytest.approx(1 / 16)
    assert st.binomial_test(600, 1200) == 1.0
    assert st.binomial_test(560, 1200) == pytest.approx(st.sign_test(560, 640))
    with pytest.raises(ValueError, match="6 successes in 5 trials"):
        st.binomial_test(6, 5)


@pytest.mark.filterwarnings("error")
def test_curves_that_never_move_have_no_interval() -> None:
    rows = np.array([st.pearson_sums(np.zeros(5), np.arange(5.0))] * 3)
    assert np.isnan(st.bootstrap_interval(rows, RNG(0), st.pearson)).all()


@pytest.mark.filterwarnings("error")
def test_the_rounding_of_sums_is_no_motion() -> None:
    """Sums kept with nine digits leave a motionless curve a spread of some 1e-9 of its square."""
    truth = RNG(1).normal(size=(50, 75))
    still = np.full(75, 5.4321987654321)
    rows = np.array([[float(f"{s:.9g}") for s in st.pearson_sums(still, row)] for row in truth])
    n, a, _, aa, _, _ = rows.sum(axis=0)
    assert n * aa != a * a
    assert np.isnan(st.pearson(rows.sum(axis=0)))
    assert np.isnan(st.bootstrap_interval(rows, RNG(0), st.pearson)).all()
    assert st.pooled_sd_ratio(rows.sum(axis=0)) == 0
    swapped = rows[:, [0, 2, 1, 4, 3, 5]].sum(axis=0)
    assert np.isnan([st.pooled_sd_ratio(swapped), st.pooled_slope(swapped)]).all()
    unknown = np.where(np.arange(6) == 3, np.nan, rows.sum(axis=0))
    assert np.isnan([st.pearson(unknown), st.pooled_sd_ratio(unknown)]).all()


def test_an_exchange_that_is_not_a_number_is_no_evidence() -> None:
    """Each model moves in one sentence, so half of the exchanges leave a model without motion."""
    curve, still = np.arange(5.0), np.ones(5)
    ours = np.array([st.pearson_sums(x, curve) for x in (curve, still, still)])
    theirs = np.array([st.pearson_sums(x, curve) for x in (still, curve[::-1], still)])
    assert st.paired_test(ours, theirs, RNG(0), st.pearson) == 1.0


@pytest.mark.filterwarnings("error")
def test_what_is_not_a_number_is_never_significant() -> None:
    a = st.mean_rows(np.arange(6.0))
    holed = st.mean_rows(np.array([0.0, np.nan, 2, 3, 4, 5]))
    assert np.isnan(st.paired_test(a, holed, RNG(0)))
    assert np.isnan(st.bootstrap_interval(holed, RNG(0))).all()
    adjusted = st.holm([0.01, float("nan"), 0.03])
    assert adjusted[::2] == pytest.approx([0.02, 0.03])
    assert np.isnan(adjusted[1])


def test_the_interval_of_one_sentence_is_its_value() -> None:
    assert st.bootstrap_interval(st.mean_rows(np.array([3.0])), RNG(0)) == (3.0, 3.0)


def test_the_paired_test_agrees_with_scipy() -> None:
    x, y = RNG(7).normal(size=(2, 9))
    y += 0.8
    exact = stats.permutation_test((x, y), lambda a, b: a.mean() - b.mean(), permutation_type="samples")
    ours = st.paired_test(st.mean_rows(x), st.mean_rows(y), RNG(0), resamples=20_000)
    assert ours == pytest.approx(exact.pvalue, abs=0.01)


def test_intervals_need_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy", None)
    with pytest.raises(MissingExtraError, match=r"tests need scipy: pip install 'phonanim\[evaluate\]'"):
        st.bootstrap_interval(st.mean_rows(np.arange(3.0)), RNG(0))
