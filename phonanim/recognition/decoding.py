"""From probabilities of phones to phones with times, a few steps behind the sound.

The best path through the phones (Viterbi 1967), of which each step is told when LAG later steps are known.
A phone lasts SHORTEST steps at least on the path.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.recognition.network import Network

Floats = NDArray[np.float32]

LAG = 4  # steps after a step that are known when it is told
SHORTEST = 3  # steps
PRIOR = 0.3  # power of the phones' shares by which their probabilities are divided
FOLLOWS = 0.4  # power of the probability that a phone follows another
CHANGE = -1.0  # added for every change of phone


@dataclass
class Decoder:
    """Log probabilities in, codes of phones out, LAG steps later.

    On a path a phone has stages 0 to SHORTEST - 1, one a step, and remains in the last; only that can end.
    """

    network: Network
    scores: Floats = field(init=False)  # (stages, phones) of the best path to each
    back: deque[tuple[NDArray[np.int64], NDArray[np.bool_]]] = field(init=False)
    told: int = 0  # steps

    def __post_init__(self) -> None:
        phones = len(self.network.prior)
        self.scores = np.full((SHORTEST, phones), -np.inf, np.float32)
        self.scores[-1, 0] = 0.0  # silence before the first step
        self.back = deque(maxlen=LAG + 1)
        self.change = FOLLOWS * self.network.follows.T + np.float32(CHANGE)  # to, from
        self.share = PRIOR * self.network.prior
        self.seen = 0

    def push(self, probabilities: Floats, last: bool = False) -> list[int]:
        """Log probabilities (steps, phones) -> the codes that they decide."""
        found = []
        for row in probabilities:
            self._step(row - self.share)
            if self.seen - self.told > LAG:
                found.append(self._trace(LAG)[0])
                self.told += 1
        if last and self.seen > self.told:
            found += self._trace(self.seen - self.told - 1)
            self.told = self.seen
        return found

    def _step(self, likelihoods: Floats) -> None:
        """Extend every path by a step."""
        arriving = self.change + self.scores[-1]
        source = arriving.argmax(axis=1)
        entered = arriving[np.arange(len(source)), source]
        stayed = self.scores[-1] >= self.scores[-2]
        ahead = np.maximum(self.scores[-1], self.scores[-2])
        self.scores = np.concatenate([entered[None], self.scores[:-2], ahead[None]]) + likelihoods
        self.scores -= self.scores.max()
        self.back.append((source, stayed))
        self.seen += 1

    def _trace(self, steps: int) -> list[int]:
        """The codes of the best path from so many steps ago until now."""
        stage, code = divmod(int(self.scores.argmax()), self.scores.shape[1])
        codes = [code]
        for source, stayed in list(self.back)[: -steps - 1 : -1] if steps else []:
            if stage == 0:
                stage, code = SHORTEST - 1, int(source[code])
            elif stage < SHORTEST - 1 or not stayed[code]:
                stage -= 1
            codes.append(code)
        return codes[::-1]
