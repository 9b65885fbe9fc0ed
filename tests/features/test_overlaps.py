"""The first layer of a network, by the segments that are near."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.features.context import N_TIMING, context_features, part_table
from phonanim.features.overlaps import box_shares, context_layer
from tests.support.speech import track_of

LINE = "sil 0.3 ch 0.1 ay 0.2 m 0.08 sil 0.02 p 0.1 aw 0.3 jh 0.12 iy 0.09"


@pytest.fixture
def weights() -> np.ndarray:
    rng = np.random.default_rng(0)
    return rng.normal(size=(17 * part_table("all").shape[1] + N_TIMING, 5))


def test_it_is_the_layer_on_the_context_features(weights: np.ndarray) -> None:
    track, bias = track_of(LINE), np.arange(5.0)
    times = np.linspace(-0.2, 1.7, 150)
    found = context_layer("all", weights, bias)(track, times)
    wanted = context_features(track, times).astype(np.float64) @ weights + bias
    np.testing.assert_allclose(found, wanted, atol=1e-5 * np.abs(weights).sum(axis=0).max() / 100)


def test_each_instant_is_by_itself(weights: np.ndarray) -> None:
    """The bits do not depend on which other instants are asked for, so a stream has those of a file."""
    track, layer = track_of(LINE), context_layer("all", weights, np.zeros(5))
    times = np.linspace(0, 1.4, 100)
    whole = layer(track, times)
    np.testing.assert_array_equal(np.concatenate([layer(track, times[n : n + 1]) for n in range(100)]), whole)


def test_the_shares_of_a_box_sum_to_one() -> None:
    times = np.array([[9.5, 9.8, 9.9], [9.2, 10.4, 10.4]])
    counts, boxes, _, shares = box_shares(track_of(f"sil 9 {LINE} sil 9"), times)
    blocks = np.repeat(np.arange(2), counts)
    sums = np.array(
        [shares[(boxes == box) & (blocks == n)].sum(axis=0) for n in range(2) for box in range(17)]
    )
    np.testing.assert_allclose(sums, 1, atol=1e-12)


def test_instants_may_come_in_any_order(weights: np.ndarray) -> None:
    track, layer = track_of(LINE), context_layer("all", weights, np.zeros(5))
    times = np.linspace(0, 1.4, 40)
    order = np.random.default_rng(0).permutation(40)
    np.testing.assert_array_equal(layer(track, times[order]), layer(track, times)[order])
    assert layer(track, times[:0]).shape == (0, 5)


def test_another_number_of_features_is_refused(weights: np.ndarray) -> None:
    with pytest.raises(ValueError, match="reshape"):
        context_layer("all", weights[1:], np.zeros(5))
