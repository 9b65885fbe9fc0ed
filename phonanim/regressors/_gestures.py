"""Training of regressors/dynamic_visemes.py: cut recordings into gestures, cluster them, count phones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.regressors import Examples, Progress
from phonanim.regressors._dynamic_visemes_config import PLACES, Config
from phonanim.speech.inventory import INVENTORY, N_PHONES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
POINTS = 9  # of a gesture's path, spaced evenly over its time
STARTS = 4  # runs of k-means, of which the best is used


@dataclass(frozen=True)
class Gestures:
    """Pieces of the recordings: `paths` (gestures, points, modes), `durations` (gestures,) in seconds,
    `phones` (gestures, places) at PLACES of each, and the clips' `weights`.
    """

    paths: Array
    durations: Array
    phones: NDArray[np.uint8]
    weights: Array


def fit_units(
    config: Config, train: Examples, rng: np.random.Generator, progress: Progress
) -> dict[str, NDArray[np.float32]]:
    """Cut, cluster and count; returns the tables of `Units`."""
    found = cut_gestures(train, config.shortest, config.longest)
    progress(0.2)
    labels, centres = cluster_paths(found, config.clusters, int(rng.integers(2**31)))
    progress(0.9)
    paths = centres if config.unit == "mean" else nearest_to_centres(found.paths, labels, centres)
    spread = found.paths.reshape(-1, paths.shape[2]).var(axis=0).sum()
    joins = ((paths[:, None, -1] - paths[None, :, 0]) ** 2).sum(axis=2) / spread
    tables = {
        "paths": paths,
        "phones": np.log(phone_shares(found, labels, len(paths), config.doubt)),
        "durations": np.exp(weighted_means(np.log(found.durations), labels, found.weights, len(paths))),
        "joins": joins,
    }
    progress(1.0)
    return {name: np.asarray(table, np.float32) for name, table in tables.items()}


def cut_gestures(examples: Examples, shortest: float, longest: float) -> Gestures:
    """Every gesture of some clips, lasting `shortest` to `longest` seconds."""
    paths, durations, phones, weights = [], [], [], []
    for track, times, target, weight in zip(
        examples.tracks, examples.times, examples.targets, examples.weights, strict=True
    ):
        bounds = gesture_bounds(target, times, shortest, longest)
        starts, lengths = times[bounds[:-1]], np.diff(times[bounds])
        paths.append(sample_paths(target, times, starts, lengths))
        durations.append(lengths)
        phones.append(gesture_phones(track, starts, lengths))
        weights.append(np.full(len(lengths), weight))
    return Gestures(*(np.concatenate(parts) for parts in (paths, durations, phones, weights)))


def gesture_bounds(
    target: NDArray[np.floating], times: Array, shortest: float, longest: float
) -> NDArray[np.int64]:
    """Frames (bounds,) at which gestures begin and end: the first, the last, and minima of the mouth's speed.

    If two minima are closer than `shortest` seconds, the slower one is used; a gesture longer than `longest`
    is cut evenly.
    """
    speed = np.linalg.norm(np.gradient(target, times, axis=0), axis=1)
    speed = np.convolve(np.pad(speed, 1, mode="edge"), [0.25, 0.5, 0.25], mode="valid")
    minima = 1 + np.flatnonzero((speed[1:-1] <= speed[:-2]) & (speed[1:-1] < speed[2:]))
    chosen = [0, len(times) - 1]
    for frame in minima[np.argsort(speed[minima], kind="stable")]:
        if np.abs(times[chosen] - times[frame]).min() > shortest - 1e-6:
            chosen.append(int(frame))
    whole = np.sort(chosen)
    parts = np.ceil(np.diff(times[whole]) / longest - 1e-6).astype(int)
    cuts = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(whole[:-1], whole[1:], parts, strict=True)]
    return np.unique(np.round(np.concatenate([*cuts, whole[-1:]])).astype(np.int64))


def sample_paths(target: NDArray[np.floating], times: Array, starts: Array, lengths: Array) -> Array:
    """Paths at POINTS evenly spaced in each gesture, -> (gestures, points, modes)."""
    at = starts[:, None] + lengths[:, None] * np.linspace(0, 1, POINTS)
    return np.stack([np.interp(at, times, mode) for mode in target.T], axis=2)


def gesture_phones(track: PhoneTrack, starts: Array, lengths: Array) -> NDArray[np.uint8]:
    """Phones at PLACES of each gesture, -> (gestures, places)."""
    at = starts[:, None] + lengths[:, None] * PLACES
    return track.sample(at.ravel()).reshape(at.shape)


def cluster_paths(found: Gestures, clusters: int, seed: int) -> tuple[NDArray[np.int64], Array]:
    """k-means over paths of equal times -> labels (gestures,), centres (units, points, modes).

    Raises MissingExtraError.
    """
    try:
        from sklearn.cluster import KMeans
    except ImportError as error:
        raise MissingExtraError(
            "dynamic visemes are clustered with scikit-learn; install it with pip install 'phonanim[train]'"
        ) from error
    flat = found.paths.reshape(len(found.paths), -1)
    fitted = KMeans(min(clusters, len(flat)), n_init=STARTS, random_state=seed).fit(
        flat, sample_weight=found.weights
    )
    return fitted.labels_.astype(np.int64), fitted.cluster_centers_.reshape(-1, *found.paths.shape[1:])


def nearest_to_centres(paths: Array, labels: NDArray[np.int64], centres: Array) -> Array:
    """The gesture nearest to the centre of each cluster, (units, points, modes)."""
    away = ((paths - centres[labels]) ** 2).sum(axis=(1, 2))
    order = np.lexsort((away, labels))
    first = np.unique(labels[order], return_index=True)[1]
    return paths[order[first]]


def weighted_means(values: Array, labels: NDArray[np.int64], weights: Array, count: int) -> Array:
    """Weighted mean of values (gestures,) by label, (count,)."""
    return np.bincount(labels, weights * values, count) / np.bincount(labels, weights, count)


def phone_shares(found: Gestures, labels: NDArray[np.int64], count: int, doubt: float) -> Array:
    """P_k(phone | unit), (places, 41, units): counts, smoothed by `doubt`.

    Half of the doubt goes to phones by their similarity to the counted ones, half to all phones by their
    frequency. So a phone that is not in the recordings still gets the units of its class.
    """
    shares = np.zeros((len(PLACES), N_PHONES, count))
    for place, phones in zip(shares, found.phones.T, strict=True):
        np.add.at(place, (phones, labels), found.weights)
    shares /= shares.sum(axis=1, keepdims=True)
    everywhere = (shares.mean(axis=(0, 2)) + 1e-3) / (1 + 1e-3 * N_PHONES)
    alike = phone_similarity().T @ shares
    return (1 - doubt) * shares + doubt / 2 * (alike + everywhere[:, None])


def phone_similarity() -> Array:
    """Similarity of phones by their attribute classes, (41, 41); each row sums to one."""
    classes = INVENTORY.attributes.astype(np.float64)
    common = classes @ classes.T
    either = classes.sum(axis=1)[:, None] + classes.sum(axis=1) - common
    alike = (common / np.maximum(either, 1)) ** 2 + 1e-3 * np.eye(N_PHONES)
    return np.asarray(alike / alike.sum(axis=1, keepdims=True))
