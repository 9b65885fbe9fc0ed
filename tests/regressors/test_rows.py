"""Training rows, and the clusters of phone pairs that the indicators look at."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from speech import track_of

from phonanim.features.indicators import CC_CLUSTERS, CONSONANT, CV_CLUSTERS, VC_CLUSTERS, VOWEL
from phonanim.regressors import Examples, make_config, regressor_class
from phonanim.regressors._rows import cluster_table, fit_clusters
from phonanim.speech.inventory import INVENTORY

pytest.importorskip("sklearn")
CONSONANTS, VOWELS = ("p", "t", "k", "s", "m", "n"), ("aa", "iy", "uw")


def spoken_pairs() -> Examples:
    """Every consonant before every vowel and back; p, t and k move the face far up, the others far down."""
    text = " ".join(f"{c} 0.08 {v} 0.08" for c in CONSONANTS for v in VOWELS)
    track = track_of(text + " s 0.08 t 0.08 m 0.08 p 0.08 n 0.08 k 0.08 s 0.08")
    times = (np.arange(int(track.duration * 25)) + 0.5) / 25
    level = np.zeros(len(INVENTORY.phones))
    level[INVENTORY.codes(CONSONANTS)] = 20, 21, 22, -20, -21, -22
    level[INVENTORY.codes(VOWELS)] = 0, 1, 2
    targets = level[track.sample(times)][:, None] * np.ones((1, 2))
    return Examples((track,), (times,), (targets.astype(np.float32),), (1.0,))


def test_pairs_that_move_alike_fall_into_one_cluster_and_others_into_another() -> None:
    table = fit_clusters(spoken_pairs(), np.random.default_rng(0))
    vowels = INVENTORY.codes(VOWELS)
    up, down = (table[np.ix_(INVENTORY.codes(c), vowels)] for c in (CONSONANTS[:3], CONSONANTS[3:]))
    assert len(np.unique(up)) == len(np.unique(down)) == 1
    assert {int(up[0, 0]), int(down[0, 0])} == {0, 1}


def test_every_kind_of_pair_has_its_number_of_clusters_and_unseen_pairs_none() -> None:
    table = fit_clusters(spoken_pairs(), np.random.default_rng(0))
    for before, after, count in (
        (CONSONANT, VOWEL, CV_CLUSTERS),
        (VOWEL, CONSONANT, VC_CLUSTERS),
        (CONSONANT, CONSONANT, CC_CLUSTERS),
    ):
        found = table[np.ix_(before, after)]
        assert set(found[found >= 0].tolist()) == set(range(count))
    zh = INVENTORY.codes(("zh",))[0]
    assert (table[zh] == -1).all()
    assert (table[np.ix_(VOWEL, VOWEL)] == -1).all()


def test_indicators_alone_have_the_clusters_of_pairs() -> None:
    assert (cluster_table("all", spoken_pairs(), np.random.default_rng(0)) == -1).all()
    found = cluster_table("indicators", spoken_pairs(), np.random.default_rng(0))
    np.testing.assert_array_equal(found, fit_clusters(spoken_pairs(), np.random.default_rng(0)))


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("tree", {"leaf": 2}),
        ("dnn", {"features": "indicators", "hidden": [4], "epochs": 1}),
        ("lstm", {"features": "indicators", "units": 4, "epochs": 1}),
    ],
)
def test_models_on_indicators_use_and_keep_the_clusters_of_their_training(
    kind: str, settings: dict[str, Any]
) -> None:
    if kind != "tree":
        pytest.importorskip("torch")
    data, config = spoken_pairs(), make_config(kind, settings, "the test")
    model: Any = regressor_class(kind).fit(config, data, data, np.random.default_rng(0), lambda done: None)
    learned = fit_clusters(data, np.random.default_rng(0))
    np.testing.assert_array_equal(model.clusters, learned)
    again: Any = regressor_class(kind).from_tensors(config, model.tensors())
    np.testing.assert_array_equal(again.clusters, learned)
