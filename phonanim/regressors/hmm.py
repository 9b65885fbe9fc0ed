"""Hidden Markov models as in HTS (Zen et al. 2007; Taylor 2017, section 8.1).

Every phone in its quinphone context is a left-to-right model of five states, with one Gaussian each over the
modes and their first and second differences. Decision trees with questions about the five phones tie the
states (Odell 1995). The alignment gives the duration of a phone, a sixth tree divides it between the states
(Yoshimura et al. 1998), and the motion is the most likely trajectory under both modes and differences
(Tokuda et al. 2000).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import MissingExtraError
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._hmm_config import LEAF, WINDOWS, Config, answer_questions, quinphones
from phonanim.regressors._styles import OffsetStyles, offset_tensors, read_offsets, split_offsets
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
NODES = ("roots", "question", "yes", "no")
LEAVES = ("means", "variances", "shares", "share_variances")
QUESTIONS = ("place", "members")


@dataclass(frozen=True)
class Trees(OffsetStyles):
    """One tree for each state and one for durations, all nodes concatenated; `roots` (states + 1,).

    A node's `question` is a row of `place` (questions,), the index of one of the five phones, and of
    `members` (questions, 41), the phones for which the answer is yes; the next node is `yes` or `no`. If
    `question` is LEAF, `yes` is a row of `means` and `variances` (leaves, 3, modes) or, in the last tree, of
    `shares` and `share_variances` (leaves, states), in seconds.
    """

    config: Config
    roots: NDArray[np.int32]
    question: NDArray[np.int32]
    yes: NDArray[np.int32]
    no: NDArray[np.int32]
    place: NDArray[np.int8]
    members: NDArray[np.uint8]
    means: NDArray[np.float32]
    variances: NDArray[np.float32]
    shares: NDArray[np.float32]
    share_variances: NDArray[np.float32]
    offsets: NDArray[np.float32] | None = None

    input_modality: ClassVar[InputModality] = "phones"
    config_class: ClassVar[type] = Config

    def predict(self, track: PhoneTrack, times: Array, sound: Sound | None = None) -> NDArray[np.float32]:
        """Modes at instants, (times,) seconds -> (times, modes); linear between the models' frames."""
        leaves, bounds = self.states(track)
        frames = np.arange(int(np.ceil(track.duration * self.config.rate)) + 1)
        state = np.searchsorted(bounds, frames / self.config.rate, side="right") - 1
        leaf = leaves[np.clip(state, 0, len(leaves) - 1)]
        path = likeliest_trajectory(
            self.means[leaf].astype(np.float64), 1 / self.variances[leaf].astype(np.float64)
        )
        place = np.clip(times * self.config.rate, 0, frames[-1])
        found = np.asarray(np.stack([np.interp(place, frames, m) for m in path.T], axis=1), np.float32)
        return self.in_style(found, self.offsets)

    def states(self, track: PhoneTrack) -> tuple[NDArray[np.int64], Array]:
        """Leaf of every state of a track, (segments * states,), and their bounds in seconds, one more."""
        asked = answer_questions(quinphones(track.codes), self.place, self.members)
        leaves = np.stack([self.descend(root, asked) for root in self.roots[:-1]], axis=1)
        last = self.descend(self.roots[-1], asked)
        shares = divide_durations(self.shares[last], self.share_variances[last], np.diff(track.bounds))
        inner = track.bounds[:-1, None] + np.cumsum(shares, axis=1)
        inner[:, -1] = track.bounds[1:]
        return leaves.ravel(), np.concatenate([track.bounds[:1], inner.ravel()])

    def descend(self, root: int, asked: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Leaves for answers (rows, questions) in the tree of a root, (rows,)."""
        node = np.full(len(asked), root, np.int64)
        going = np.flatnonzero(self.question[node] != LEAF)
        while len(going):
            at = node[going]
            node[going] = np.where(asked[going, self.question[at]], self.yes[at], self.no[at])
            going = going[self.question[node[going]] != LEAF]
        return self.yes[node].astype(np.int64)

    def tensors(self) -> Tensors:
        """The trees, their questions and their leaves, and the offsets of styles, by name."""
        tables = {name: getattr(self, name) for name in (*NODES, *QUESTIONS, *LEAVES)}
        return tables | offset_tensors(self.offsets)

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Trees:
        """Raises ValueError when a node has an invalid target, or the number of trees is wrong."""
        offsets = read_offsets(config.styles, tensors["means"].shape[2], tensors)
        tables = {name: tensors[name] for name in (*NODES, *QUESTIONS, *LEAVES)}
        trees = cls(config, **tables, offsets=offsets)
        if len(trees.roots) != config.states + 1 or trees.shares.shape[1] != config.states:
            raise ValueError(f"there are {len(trees.roots)} trees for {config.states} states")
        inner = trees.question != LEAF
        children = np.stack([trees.yes, trees.no])[:, inner]
        # Children come after their parents, so that every descent ends.
        outside = (children >= len(inner)).any() or (trees.question >= len(trees.place)).any()
        if outside or (children <= np.flatnonzero(inner)).any():
            raise ValueError("a node points outside its tree")
        of_state = np.arange(len(inner)) < trees.roots[-1]
        leaves = np.where(of_state, len(trees.means), len(trees.shares))
        if ((trees.yes < 0) | (trees.yes >= leaves))[~inner].any():
            raise ValueError("a node points to a leaf that does not exist")
        return trees

    @classmethod
    def fit(
        cls, config: Any, train: Examples, validation: Examples, rng: np.random.Generator, progress: Progress
    ) -> Trees:
        """Align and cluster in turn; neither `validation` nor `rng` is used.

        Raises ModelError for a style beyond `styles`.
        """
        from phonanim.regressors._hmm import fit_trees

        train, offsets = split_offsets("hmm", config.styles, train)
        return cls(config, **fit_trees(config, train, progress), offsets=offsets)


def divide_durations(
    means: NDArray[np.floating], variances: NDArray[np.floating], lengths: Array
) -> NDArray[np.float64]:
    """The most likely durations of the states of phones with these lengths, all seconds -> (phones, states).

    d = m + rho v, with rho such that they sum to the phone's length (Yoshimura et al. 1998).
    """
    rho = (lengths - means.sum(axis=1)) / variances.sum(axis=1)
    shares = np.maximum(means + rho[:, None] * variances, 0.02 * lengths[:, None])
    return np.asarray(shares * (lengths / shares.sum(axis=1))[:, None], np.float64)


def likeliest_trajectory(means: Array, precisions: Array) -> Array:
    """The most likely path under Gaussians of value and differences, (frames, 3, modes) -> (frames, modes).

    Solves W'PW c = W'P m (Tokuda et al. 2000), five-banded, mode by mode. Differences that would use frames
    beyond the ends do not count. Raises MissingExtraError.
    """
    try:
        from scipy.linalg import solveh_banded
    except ImportError as error:
        raise MissingExtraError(
            "models of kind hmm need SciPy; install it with pip install 'phonanim[train]'"
        ) from error
    frames, _, modes = means.shape
    precisions = precisions.copy()
    precisions[[0, -1], 1:] = 0
    bands = np.zeros((3, frames + 2, modes))  # of W'PW below the diagonal, one frame beyond either end
    right = np.zeros((frames + 2, modes))
    for weights, mean, precision in zip(
        WINDOWS, means.swapaxes(0, 1), precisions.swapaxes(0, 1), strict=True
    ):
        for i, left in enumerate(weights):
            right[i : frames + i] += left * precision * mean
            for j in range(i, 3):
                bands[j - i, i : frames + i] += left * weights[j] * precision
    bands, right = bands[:, 1:-1], right[1:-1]
    return np.stack([solveh_banded(bands[..., m], right[:, m], lower=True) for m in range(modes)], axis=1)


REGRESSOR = Trees
