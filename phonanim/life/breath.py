"""Breath: a short inhale before a phrase that follows a pause.

Speakers inhale faster than people at rest (Conrad and Schönle 1979), mostly before clauses (Winkworth, Davis,
Adams and Ellis 1995, Journal of Speech and Hearing Research 38). The visible motion is small.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.life.chance import number_of, uniform
from phonanim.life.shapes import bumps
from phonanim.speech.prosody import Prosody

Array = NDArray[np.float64]

PAUSE = 0.35  # seconds of silence before which a speaker inhales
SHORTEST, LONGEST = 0.2, 0.4  # seconds of an inhale
NOSTRILS, JAW, CHEST, LIFT = 0.07, 0.015, 0.5, 0.5  # of full weight, and degrees of head lift
OUT = 2.5  # seconds in which the chest sinks


def inhaled(seed: int, prosody: Prosody, times: Array) -> tuple[Array, Array]:
    """The visible inhale, and how full the chest is, (frames,) 0 to 1 each."""
    pauses = prosody.pauses()
    span = SHORTEST + (LONGEST - SHORTEST) * uniform(seed, "inhale", number_of(prosody.starts))
    span = np.minimum(span, 0.9 * pauses)
    onsets = np.maximum(prosody.starts - span, prosody.starts_from)
    kept = (pauses >= PAUSE) & (onsets <= prosody.starts - SHORTEST / 2)
    left, onsets = (prosody.starts - onsets)[kept], onsets[kept]
    each = np.ones(len(onsets))
    seen = bumps(times, onsets, 0.5 * left, 0 * each, 0.4 * left, each)
    return seen, bumps(times, onsets, left, 0 * each, OUT * each, each)
