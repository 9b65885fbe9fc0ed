"""Blinks: how often people blink who talk, drawn by a seed."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE = 26 / 60  # per second in conversation (Bentivoglio et al. 1997, Movement Disorders 12(6), 150 people)
SPREAD = 0.6  # of the logarithm of the pauses, which lie apart as unevenly as a log-normal
LEAST = 0.6  # seconds between two blinks, so that one is over before the next begins
# Seconds to close, shut and to open; a blink in conversation lasts some 0.2 s to where it is half open
# again (Hoemke, Holler and Levinson 2018, PLOS ONE 13(12)), and opens at half the speed.
CLOSING, SHUT, OPENING = 0.08, 0.03, 0.2
LIDS = re.compile(r"eye_?blink|^blink$", re.IGNORECASE)


def eyelid_controls(controls: tuple[str, ...]) -> list[int]:
    """The controls that close the eyes."""
    return [number for number, name in enumerate(controls) if LIDS.search(name)]


def blink_curve(seed: int, times: Array) -> Array:
    """How far the eyes are closed at instants, (frames,) seconds -> (frames,) 0 to 1.

    The same seed and length give the same blinks at any frame rate.
    """
    length = float(times[-1])
    rng = np.random.default_rng([seed, round(1000 * length)])
    closed: Array = np.zeros(len(times))
    for start in _starts(rng, length):
        past = times - start
        going = np.interp(past, (0, CLOSING), (0, 1)) * np.interp(
            past, (CLOSING + SHUT, CLOSING + SHUT + OPENING), (1, 0)
        )
        closed = np.maximum(closed, going**2 * (3 - 2 * going))
    return closed


def _starts(rng: np.random.Generator, length: float) -> list[float]:
    """When blinks begin: log-normal pauses whose mean makes the rate."""
    middle = np.log(1 / RATE - LEAST) - SPREAD**2 / 2
    starts = []
    at = float(rng.uniform(0, 1 / RATE))
    while at < length:
        starts.append(at)
        at += LEAST + float(rng.lognormal(middle, SPREAD))
    return starts
