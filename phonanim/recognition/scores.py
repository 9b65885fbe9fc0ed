"""How well each phone fits each step of a recording, by the network that recognizes phones."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.core.catalog import RECOGNITION_MODEL, SHIPPED
from phonanim.recognition.network import Network, NetworkStream, load_network
from phonanim.recognition.spectrum import WINDOW, MelSpectrum, VoiceMean

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
    steps = VoiceMean().subtract(MelSpectrum().push(whole))
    scores = NetworkStream(network).push(steps, last=True) - COMMON * network.prior
    return np.asarray(scores.max(axis=1, keepdims=True) - scores, np.float32)
