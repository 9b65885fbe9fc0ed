"""How well each phone fits each step of a recording, by the network that recognizes phones."""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.core.catalog import RECOGNITION_MODEL, SHIPPED
from phonanim.recognition.network import Network, NetworkStream, load_network
from phonanim.recognition.spectrum import WINDOW, MelSpectrum, voice_mean

Floats = NDArray[np.float32]

NETWORK = SHIPPED / RECOGNITION_MODEL / "recognizer.safetensors"
COMMON = 0.5  # of the log share of a phone, which is subtracted: rare phones would seem to fit nowhere


@lru_cache(maxsize=1)
def _network() -> Network:
    return load_network(NETWORK)


def phone_misfits(samples: Floats) -> Floats:
    """Samples (n,) at 16 kHz -> (steps of 10 ms, phones): 0 for the phone that fits best, else nats below it.

    Raises ModelError where the shipped network is damaged.
    """
    network = _network()
    whole = np.concatenate([samples, np.zeros(WINDOW // 2, np.float32)])
    steps = voice_mean(samples).subtract(MelSpectrum().push(whole))
    scores = NetworkStream(network).push(steps, last=True) - COMMON * network.prior
    return np.asarray(scores.max(axis=1, keepdims=True) - scores, np.float32)


@cache
def random_phones(count: int, words: int) -> NDArray[np.int64]:
    """Words of `count` phones, (words, count), by how often phones follow each other; always the same."""
    network, chance = _network(), np.random.default_rng(0)
    follows = np.exp(network.follows.astype(np.float64))
    follows[:, 0] = 0.0  # silence
    np.fill_diagonal(follows, 0.0)
    first = np.exp(network.prior.astype(np.float64))
    first[0] = 0.0
    bounds = np.cumsum(follows / follows.sum(axis=1, keepdims=True), axis=1)
    found = np.empty((words, count), np.int64)
    found[:, 0] = np.searchsorted(np.cumsum(first / first.sum()), chance.random(words))
    for place in range(1, count):
        found[:, place] = (bounds[found[:, place - 1]] < chance.random((words, 1))).sum(axis=1)
    return np.minimum(found, len(first) - 1)
