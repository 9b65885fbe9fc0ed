"""Training rows of the window regressors, and the data-driven clusters of phone pairs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.features.indicators import CC_CLUSTERS, CONSONANT, CV_CLUSTERS, VC_CLUSTERS, VOWEL, WIDTH
from phonanim.features.inputs import NO_CLUSTERS, window_features
from phonanim.features.windows import sliding_windows
from phonanim.regressors import Examples
from phonanim.regressors._styles import add_style, styles_of
from phonanim.speech.inventory import N_PHONES


def training_rows(
    examples: Examples,
    features: str,
    width: int,
    clusters: NDArray[np.int8],
    reach: int = WIDTH,
    styles: int = 1,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Inputs (rows, features), target windows (rows, width * modes) and weights (rows,) of all clips.

    With several `styles` the inputs have a column of each.
    """
    n_rows = sum(len(times) for times in examples.times)
    modes = examples.targets[0].shape[1] if len(examples) else 0
    found: NDArray[np.float32] | None = None
    targets = np.empty((n_rows, width * modes), np.float32)
    weights = np.empty(n_rows, np.float32)
    begin = 0
    for track, times, target, weight, style in zip(
        examples.tracks, examples.times, examples.targets, examples.weights, styles_of(examples), strict=True
    ):
        values = add_style(window_features(features, track, times, clusters, reach), style, styles)
        if found is None:
            found = np.empty((n_rows, values.shape[1]), np.float32)
        rows = slice(begin, begin + len(times))
        found[rows], weights[rows] = values, weight
        targets[rows] = sliding_windows(target, width).reshape(len(times), -1)
        begin += len(times)
    return np.empty((0, 0), np.float32) if found is None else found, targets, weights


def cluster_table(features: str, train: Examples, rng: np.random.Generator) -> NDArray[np.int8]:
    """Clusters of phone pairs for "indicators"; empty for features that do not use them."""
    return fit_clusters(train, rng) if features == "indicators" else NO_CLUSTERS


def fit_clusters(train: Examples, rng: np.random.Generator) -> NDArray[np.int8]:
    """k-means over the face parameters at phone pairs (Taylor 2017, supplement 1.3), -> (41, 41) int8.

    Each pair in the training data is described by its mean modes in the frame before and the frame after the
    change; consonant-vowel pairs form 2 clusters, vowel-consonant and consonant-consonant pairs 3 each. Pairs
    that are not in the data are -1.
    """
    sums: dict[tuple[int, int], list[NDArray[np.float32]]] = {}
    for track, times, target in zip(train.tracks, train.times, train.targets, strict=True):
        codes = track.sample(times)
        for row in np.flatnonzero(codes[1:] != codes[:-1]):
            pair = int(codes[row]), int(codes[row + 1])
            sums.setdefault(pair, []).append(target[row : row + 2].ravel())
    table = np.full((N_PHONES, N_PHONES), -1, np.int8)
    seed = int(rng.integers(2**31))
    for before, after, count in (
        (CONSONANT, VOWEL, CV_CLUSTERS),
        (VOWEL, CONSONANT, VC_CLUSTERS),
        (CONSONANT, CONSONANT, CC_CLUSTERS),
    ):
        pairs = sorted(pair for pair in sums if before[pair[0]] and after[pair[1]])
        if len(pairs) >= count:
            points = np.array([np.mean(sums[pair], axis=0) for pair in pairs])
            for pair, label in zip(pairs, _k_means(points, count, seed), strict=True):
                table[pair] = label
    return table


def _k_means(points: NDArray[np.float32], count: int, seed: int) -> NDArray[np.int32]:
    try:
        from sklearn.cluster import KMeans
    except ImportError as error:
        raise MissingExtraError(
            "indicator features are trained with scikit-learn; install it with pip install 'phonanim[train]'"
        ) from error
    labels: NDArray[np.int32] = KMeans(count, n_init=10, random_state=seed).fit(points).labels_
    return labels
