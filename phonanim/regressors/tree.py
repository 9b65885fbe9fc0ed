"""Regression trees: the tree of Kim et al. (2015), and forests of extremely randomized trees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.features.inputs import STEP, window_features
from phonanim.features.windows import predict_at
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._rows import cluster_table, training_rows
from phonanim.regressors._styles import add_style, check_style, check_styles, with_style
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
LEAF = -1  # in `left`


@dataclass(frozen=True)
class Config:
    """The defaults are the decision tree of Kim 2015 as Taylor 2017 uses it: one tree, 10 rows per leaf.

    `split` "best" searches every threshold, "random" draws one per column (Geurts 2006). `columns` (a share
    of all) are tried at each node. `style` is the style of the output, out of the `styles` of
    Examples.styles: columns of their own, of which one is 1.
    """

    features: Literal["indicators", "raw", "all", "gestures", "classes"] = "indicators"
    width: int = 5
    trees: int = 1
    leaf: int = 10
    split: Literal["best", "random"] = "best"
    columns: float = 1.0
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("tree", self)


@dataclass(frozen=True)
class Forest:
    """All nodes of all trees, concatenated; `roots` (trees,) are their first nodes.

    A row goes to `left` if its `column` is at most `threshold`, else to `right`. A node whose `left` is LEAF
    has the prediction, row `right` of `values` (leaves, width * modes).
    """

    config: Config
    roots: NDArray[np.int32]
    column: NDArray[np.int32]
    threshold: NDArray[np.float32]
    left: NDArray[np.int32]
    right: NDArray[np.int32]
    values: NDArray[np.float32]
    clusters: NDArray[np.int8]

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    def with_settings(self, **settings: Any) -> Forest:
        """The same trees with another `style`. Raises ModelError for a style or setting that they lack."""
        return with_style(self, settings)

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes); overlapping windows are averaged."""

        def windows(centres: Array) -> NDArray[np.float32]:
            rows = window_features(self.config.features, track, centres, self.clusters)
            found = self.descend(add_style(rows, self.config.style, self.config.styles))
            return found.reshape(len(centres), self.config.width, -1)

        return predict_at(times, track.duration, STEP, self.config.width, windows)

    def descend(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Mean prediction of the trees, (rows, features) -> (rows, width * modes)."""
        total = np.zeros((len(rows), self.values.shape[1]), np.float32)
        for root in self.roots:
            node = np.full(len(rows), root)
            going = np.flatnonzero(self.left[node] != LEAF)
            while len(going):
                at = node[going]
                lower = rows[going, self.column[at]] <= self.threshold[at]
                node[going] = np.where(lower, self.left[at], self.right[at])
                going = going[self.left[node[going]] != LEAF]
            total += self.values[self.right[node]]
        return np.asarray(total / len(self.roots), np.float32)

    def tensors(self) -> Tensors:
        """The arrays of all nodes, by name."""
        names = ("roots", "column", "threshold", "left", "right", "values", "clusters")
        return {name: getattr(self, name) for name in names}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Forest:
        """Raises ValueError when a node points outside the forest."""
        forest = cls(config, **{name: tensors[name] for name in tensors})
        nodes, inner = len(forest.left), forest.left != LEAF
        ends = np.where(inner, nodes, len(forest.values))
        if (forest.right < 0).any() or (forest.right >= ends).any() or (forest.left >= nodes).any():
            raise ValueError("a node points outside the forest")
        # Children come after their parents, so that every descent ends.
        if (np.minimum(forest.left, forest.right)[inner] <= np.flatnonzero(inner)).any():
            raise ValueError("a node points back to an earlier one")
        return forest

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> Forest:
        """Grow the trees on the squared error of the windows; `validation` is not needed."""
        try:
            from sklearn.ensemble import ExtraTreesRegressor
            from sklearn.tree import DecisionTreeRegressor
        except ImportError as error:
            raise MissingExtraError(
                "trees are grown with scikit-learn; install it with pip install 'phonanim[train]'"
            ) from error
        clusters = cluster_table(config.features, train, rng)
        check_styles("tree", config.styles, train)
        rows, targets, weights = training_rows(
            train, config.features, config.width, clusters, styles=config.styles
        )
        seed = int(rng.integers(2**31))
        shared = {"min_samples_leaf": config.leaf, "max_features": config.columns, "random_state": seed}
        if config.split == "random":
            grown = (
                ExtraTreesRegressor(config.trees, n_jobs=-1, **shared).fit(rows, targets, weights).estimators_
            )
        else:
            grown = [DecisionTreeRegressor(**shared).fit(rows, targets, weights)]
        progress(1.0)
        return cls(config, **_flatten([tree.tree_ for tree in grown]), clusters=clusters)


def _flatten(trees: list[Any]) -> dict[str, NDArray[Any]]:
    """scikit-learn's trees as plain arrays, concatenated."""
    found: dict[str, list[NDArray[Any]]] = {
        name: [] for name in ("roots", "column", "threshold", "left", "right", "values")
    }
    nodes = leaves = 0
    for tree in trees:
        is_leaf = tree.children_left < 0
        number = np.cumsum(is_leaf) - 1 + leaves
        found["roots"].append(np.array([nodes]))
        found["column"].append(np.where(is_leaf, 0, tree.feature))
        found["threshold"].append(np.where(is_leaf, 0, tree.threshold))
        found["left"].append(np.where(is_leaf, LEAF, tree.children_left + nodes))
        found["right"].append(np.where(is_leaf, number, tree.children_right + nodes))
        found["values"].append(tree.value[is_leaf][:, :, 0])
        nodes, leaves = nodes + tree.node_count, leaves + int(is_leaf.sum())
    whole = {name: np.concatenate(parts) for name, parts in found.items()}
    floats = {"threshold", "values"}
    return {n: a.astype(np.float32 if n in floats else np.int32) for n, a in whole.items()}


REGRESSOR = Forest
