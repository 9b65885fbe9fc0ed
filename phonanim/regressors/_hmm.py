"""Training of regressors/hmm.py: align states with frames, and grow trees on their statistics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.regressors import Examples, Progress
from phonanim.regressors._hmm_config import (
    LEAF,
    WINDOWS,
    Config,
    answer_questions,
    list_questions,
    quinphones,
)

Array = NDArray[np.float64]
FLOOR = 1e-3  # of the variance of all frames: least variance of a leaf
CHUNK = 65536  # frames at once


@dataclass(frozen=True)
class Frames:
    """All clips at the models' rate: `values` (frames, 3 * modes), clip after clip, each frame in a phone.

    Phone i is `contexts[i]` (phones, 5). Its frames are `starts[i]` to `starts[i + 1]`, with the weight
    `weights[i]`. Phones too short for a frame are left out.
    """

    values: NDArray[np.float32]
    starts: NDArray[np.int64]
    contexts: NDArray[np.uint8]
    weights: Array


@dataclass(frozen=True)
class Statistics:
    """Counts, sums and sums of squares: `count` (models,), `total`, `squares` (models, n)."""

    count: Array
    total: Array
    squares: Array


@dataclass(frozen=True)
class Tree:
    """A grown tree (see `Trees` of regressors/hmm.py), and mean and variance of its leaves (leaves, n)."""

    question: NDArray[np.int32]
    yes: NDArray[np.int32]
    no: NDArray[np.int32]
    means: Array
    variances: Array
    leaf_of: NDArray[np.int64]  # of each model of the training data


def fit_trees(config: Config, train: Examples, progress: Progress) -> dict[str, Any]:
    """Start with evenly divided phones, then cluster and align in turn; returns the fields of `Trees`."""
    frames = observe_modes(train, config.rate)
    contexts, model = np.unique(frames.contexts, axis=0, return_inverse=True)
    place, members = list_questions()
    asked = answer_questions(contexts, place, members)
    state = divide_evenly(np.diff(frames.starts), config.states)
    trees: list[Tree] = []
    for turn in range(config.alignments + 1):
        if trees:
            state = align_states(frames, trees, model)
        trees = [
            grow_tree(
                pool_statistics(frames, model, state == s, len(contexts)), asked, config.leaf, config.mdl
            )
            for s in range(config.states)
        ]
        progress((turn + 1) / (config.alignments + 2))
    lengths = [np.add.reduceat(state == s, frames.starts[:-1]) / config.rate for s in range(config.states)]
    spans = gather_statistics(np.stack(lengths, axis=1), frames.weights, model, len(contexts))
    durations = grow_tree(spans, asked, config.leaf, config.mdl)
    progress(1.0)
    return flatten_trees([*trees, durations], config.states) | {"place": place, "members": members}


def observe_modes(train: Examples, rate: float) -> Frames:
    """Modes at `rate` by cubic splines, with their differences, and the phones of the frames.

    Raises MissingExtraError.
    """
    try:
        from scipy.interpolate import CubicSpline
    except ImportError as error:
        raise MissingExtraError(
            "models of kind hmm need SciPy; install it with pip install 'phonanim[train]'"
        ) from error
    values, lengths, contexts, weights = [], [], [], []
    for track, times, target, weight in zip(
        train.tracks, train.times, train.targets, train.weights, strict=True
    ):
        at = np.arange(int(track.duration * rate)) / rate
        path = CubicSpline(times, target)(np.clip(at, times[0], times[-1]))
        values.append(append_differences(path))
        held = np.bincount(track.segment_at(at), minlength=len(track.codes))
        lengths.append(held[held > 0])
        contexts.append(quinphones(track.codes)[held > 0])
        weights.append(np.full(int((held > 0).sum()), weight))
    starts = np.concatenate([[0], np.cumsum(np.concatenate(lengths))])
    return Frames(np.concatenate(values), starts, np.concatenate(contexts), np.concatenate(weights))


def append_differences(path: Array) -> NDArray[np.float32]:
    """(frames, modes) -> (frames, 3 * modes): values, first and second differences; clamped at the ends."""
    padded = np.concatenate([path[:1], path, path[-1:]])
    around = np.stack([padded[:-2], padded[1:-1], padded[2:]])
    return np.asarray(np.einsum("wk,kfm->fwm", WINDOWS, around).reshape(len(path), -1), np.float32)


def divide_evenly(lengths: NDArray[np.int64], states: int) -> NDArray[np.int64]:
    """State of each frame when phones of these lengths in frames are divided evenly, (frames,)."""
    within = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    return np.asarray(within * states // np.repeat(lengths, lengths))


def pool_statistics(
    frames: Frames, model: NDArray[np.int64], chosen: NDArray[np.bool_], count: int
) -> Statistics:
    """Statistics of the chosen frames (frames,) of each of `count` models."""
    phone = np.repeat(np.arange(len(model)), np.diff(frames.starts))[chosen]
    return gather_statistics(frames.values[chosen], frames.weights[phone], model[phone], count)


def gather_statistics(
    rows: NDArray[np.floating], weights: Array, model: NDArray[np.int64], count: int
) -> Statistics:
    """Weighted statistics of rows (rows, n) by model, (rows,)."""
    columns = [np.bincount(model, weights * column, count) for column in rows.T]
    squares = [np.bincount(model, weights * np.square(column, dtype=np.float64), count) for column in rows.T]
    held = np.bincount(model, weights, count).astype(np.float64)
    return Statistics(held, np.stack(columns, 1), np.stack(squares, 1))


def grow_tree(found: Statistics, asked: NDArray[np.bool_], leaf: int, mdl: float) -> Tree:
    """Split models by their answers (models, questions) as long as the description length decreases.

    The leaves are Gaussians with independent columns. A split is made when the log likelihood rises by at
    least mdl * n * ln(frames), the cost of another mean and variance of n columns (Shinoda and
    Watanabe 2000).
    """
    count, n = found.count.sum(), found.total.shape[1]
    mean = found.total.sum(axis=0) / count
    spread = found.squares.sum(axis=0) / count - mean**2
    rows = np.column_stack([found.count, found.total, found.squares])
    price = mdl * n * np.log(max(count, 2.0))
    floor = FLOOR * spread + 1e-9
    nodes: list[list[int]] = [[LEAF, 0, 0]]
    waiting = [(0, np.flatnonzero(found.count > 0))]
    leaf_of = np.zeros(len(asked), np.int64)
    leaves: list[Array] = []
    while waiting:
        node, models = waiting.pop()
        best = best_question(rows[models], asked[models], leaf, price, floor)
        if best is None:
            leaf_of[models] = nodes[node][1] = len(leaves)
            leaves.append(rows[models].sum(axis=0))
            continue
        nodes[node] = [best, len(nodes), len(nodes) + 1]
        sides = asked[models, best]
        waiting += [(len(nodes), models[sides]), (len(nodes) + 1, models[~sides])]
        nodes += [[LEAF, 0, 0], [LEAF, 0, 0]]
    means, variances, _ = fit_gaussians(np.array(leaves), floor)
    question, yes, no = np.array(nodes, np.int32).T
    return Tree(question, yes, no, means, variances, leaf_of)


def best_question(rows: Array, asked: NDArray[np.bool_], leaf: int, price: float, floor: Array) -> int | None:
    """The question that raises the likelihood of models' statistics most, None if no split pays."""
    whole = rows.sum(axis=0)
    yes = asked.T.astype(np.float64) @ rows
    no = whole - yes
    allowed = np.flatnonzero((yes[:, 0] >= leaf) & (no[:, 0] >= leaf))
    if len(allowed) == 0:
        return None
    before = fit_gaussians(whole[None], floor)[2]
    gain = fit_gaussians(yes[allowed], floor)[2] + fit_gaussians(no[allowed], floor)[2] - before
    return int(allowed[gain.argmax()]) if gain.max() > price else None


def fit_gaussians(rows: Array, floor: Array) -> tuple[Array, Array, Array]:
    """Statistics (rows, 1 + 2n) -> means, variances (rows, n), log likelihoods up to a constant (rows,)."""
    total, squares = np.split(rows[:, 1:] / rows[:, :1], 2, axis=1)
    variances = np.maximum(squares - total**2, floor)
    return total, variances, -0.5 * rows[:, 0] * np.log(variances).sum(axis=1)


def align_states(frames: Frames, trees: list[Tree], model: NDArray[np.int64]) -> NDArray[np.int64]:
    """The most likely state of each frame, (frames,), within the bounds of phones (Viterbi).

    Phones with fewer frames than states stay divided evenly.
    """
    lengths, states = np.diff(frames.starts), len(trees)
    phone = np.repeat(np.arange(len(lengths)), lengths)
    fit = np.empty((len(phone), states))
    for state, tree in enumerate(trees):
        fit[:, state] = log_likelihood(frames.values, tree, tree.leaf_of[model[phone]])
    moved = np.zeros((len(phone), states), bool)  # whether this state was entered from the one before
    scores = np.full((len(lengths), states), -np.inf)
    scores[:, 0] = fit[frames.starts[:-1], 0]
    for step in range(1, int(lengths.max())):
        going = np.flatnonzero(lengths > step)
        row = frames.starts[going] + step
        stay = scores[going]
        move = np.concatenate([np.full((len(going), 1), -np.inf), stay[:, :-1]], axis=1)
        moved[row] = move > stay
        scores[going] = np.maximum(stay, move) + fit[row]
    return _walk_back(frames, moved, states)


def _walk_back(frames: Frames, moved: NDArray[np.bool_], states: int) -> NDArray[np.int64]:
    lengths = np.diff(frames.starts)
    found = divide_evenly(lengths, states)
    at = np.full(len(lengths), states - 1)
    for step in range(int(lengths.max())):
        going = np.flatnonzero((lengths > step) & (lengths >= states))
        row = frames.starts[going + 1] - 1 - step
        found[row] = at[going]
        at[going] -= moved[row, at[going]]
    return found


def log_likelihood(values: NDArray[np.float32], tree: Tree, leaf: NDArray[np.int64]) -> Array:
    """Log likelihood of each frame (frames, n) in its leaf (frames,), up to a constant."""
    found = np.empty(len(values))
    scale = (1 / np.sqrt(tree.variances)).astype(np.float32)
    shift = tree.means.astype(np.float32)
    constant = -0.5 * np.log(tree.variances).sum(axis=1)
    for begin in range(0, len(values), CHUNK):
        rows = slice(begin, begin + CHUNK)
        away = (values[rows] - shift[leaf[rows]]) * scale[leaf[rows]]
        found[rows] = constant[leaf[rows]] - 0.5 * np.einsum("fn,fn->f", away, away)
    return found


def flatten_trees(trees: list[Tree], states: int) -> dict[str, NDArray[Any]]:
    """All trees, concatenated; the last one is for durations."""
    nodes = np.cumsum([0, *(len(t.question) for t in trees)])
    leaves = np.cumsum([0, *(len(t.means) for t in trees[:-1])])
    leaves[-1] = 0  # durations have separate leaves
    yes = [np.where(t.question == LEAF, t.yes + leaves[i], t.yes + nodes[i]) for i, t in enumerate(trees)]
    *others, durations = trees
    means, variances = (np.concatenate([getattr(t, n) for t in others]) for n in ("means", "variances"))
    found: dict[str, NDArray[Any]] = {
        "roots": nodes[:-1],
        "question": np.concatenate([t.question for t in trees]),
        "yes": np.concatenate(yes),
        "no": np.concatenate([t.no + nodes[i] for i, t in enumerate(trees)]),
    }
    floats = {
        "means": means.reshape(len(means), len(WINDOWS), -1),
        "variances": variances.reshape(len(means), len(WINDOWS), -1),
        "shares": durations.means,
        "share_variances": durations.variances,
    }
    whole = {name: array.astype(np.int32) for name, array in found.items()}
    return whole | {name: array.astype(np.float32) for name, array in floats.items()}
