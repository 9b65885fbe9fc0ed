"""Trees: how many rows a leaf holds."""

from __future__ import annotations

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.features.inputs import window_features
from phonanim.regressors.tree import LEAF, Config, Forest

pytest.importorskip("sklearn")


@pytest.mark.parametrize("config", [Config(), Config(leaf=25), Config(trees=3, split="random", columns=0.3)])
def test_a_leaf_holds_as_many_training_rows_as_asked(config: Config) -> None:
    """Defaults: one tree, ten rows a leaf, as Taylor 2017 uses the tree of Kim 2015."""
    assert (Config().trees, Config().leaf) == (1, 10)
    rng = np.random.default_rng(0)
    data = made_up_examples(rng)
    forest = Forest.fit(config, data, data, rng, lambda done: None)
    rows = np.concatenate(
        [
            window_features("indicators", t, at, forest.clusters)
            for t, at in zip(data.tracks, data.times, strict=True)
        ]
    )
    assert len(forest.roots) == config.trees
    for root in forest.roots:
        node = np.full(len(rows), root)
        while (going := forest.left[node] != LEAF).any():
            at = node[going]
            lower = rows[going, forest.column[at]] <= forest.threshold[at]
            node[going] = np.where(lower, forest.left[at], forest.right[at])
        held = np.unique(node, return_counts=True)[1]
        assert config.leaf <= held.min() < 4 * config.leaf
