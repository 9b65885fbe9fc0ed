"""Brows: up on some accents and on questions, down on rare emphasis.

Speakers raise their brows with some rises of pitch, and sometimes in silence (Guaïtella et al. 2009, Language
and Speech 52). Raises tend to come with pitch accents and a little before them (Flecha-García 2010, Speech
Communication 52); how far, how often and how long before is set by eye.
Brows also rise in questions (Ekman 1979, About Brows).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.life.chance import number_of, uniform, uniforms, wander
from phonanim.life.shapes import bumps
from phonanim.speech.prosody import Prosody

Array = NDArray[np.float64]

RAISED, LOWERED = 0.2, 0.05  # share of accents at which brows go up, and down
STRONG = 0.45  # least strength of an accent that moves them
APART = 1.2  # seconds after a chosen accent in which the brows are not moved anew
LEAD = 0.16  # seconds before the middle of the vowel at which the motion begins
HEIGHT, MORE = 0.1, 0.22  # of full weight, and more for strong accents
FROWN = 0.14
QUESTION = 0.3
DRIFT = 0.02
PERIOD = 3.0  # seconds


def curves(seed: int, prosody: Prosody, times: Array) -> tuple[Array, Array]:
    """How far the brows are up, and how far down, (frames,) 0 to 1 each."""
    drawn = uniform(seed, "raised", number_of(prosody.accents))
    return _raised(seed, prosody, times, drawn), _lowered(seed, prosody, times, drawn)


def _raised(seed: int, prosody: Prosody, times: Array, drawn: Array) -> Array:
    kept = _apart(prosody, drawn < RAISED)
    accents = _moved(seed, prosody, times, kept, HEIGHT + MORE * prosody.strengths)
    begins, ends = prosody.questions.T
    each = np.ones(len(begins))
    asked = bumps(times, begins - 0.1, 0.2 * each, ends - begins, 0.35 * each, QUESTION * each)
    resting = DRIFT * (1 + wander(seed, "brows", times, PERIOD))
    return np.maximum(np.maximum(accents, asked), np.maximum(resting, 0.0))


def _lowered(seed: int, prosody: Prosody, times: Array, drawn: Array) -> Array:
    kept = _apart(prosody, drawn > 1 - LOWERED)
    return _moved(seed, prosody, times, kept, FROWN * np.ones(len(kept)))


def _apart(prosody: Prosody, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The chosen accents that are strong and do not follow another of them too soon, (accents,)."""
    chosen = chosen & (prosody.strengths >= STRONG)
    before = np.diff(prosody.accents[chosen], prepend=-np.inf)
    kept = np.zeros(len(chosen), bool)
    kept[np.flatnonzero(chosen)[before >= APART]] = True
    return kept


def _moved(seed: int, prosody: Prosody, times: Array, kept: NDArray[np.bool_], heights: Array) -> Array:
    onsets = np.maximum(prosody.accents[kept] - LEAD, prosody.accents_from[kept])
    numbers = number_of(prosody.accents[kept])
    holding, rising = uniforms(seed, ("brow hold", "brow rise"), numbers)
    rises, holds = 0.12 + 0.08 * rising, 0.06 + 0.25 * holding
    return bumps(times, onsets, rises, holds, 0.3 + 0 * rises, heights[kept])
