"""Smoothing in time that keeps closures: closed lips stay as closed, at the same instants."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import Articulation
from phonanim.core.exact import ordered_product
from phonanim.face.contacts import CONTACTS, lip_functionals
from phonanim.face.model import INNER_LIP_PAIRS, FaceModel
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

LONGEST = 1.0  # seconds
REACH = 3.0  # standard deviations at which the window is cut off
SHORTEST = 0.1  # frames; a narrower window changes nothing
CLOSED = 0.6  # mm between the inner lips: up to this, tracked lips count as closed
RAMP = 0.06  # seconds from a closure to full smoothing; as in phonanim.face.contacts
PER_WIDTH = 1 / math.sqrt(8 * math.log(2))  # standard deviations in the full width at half height
HALF_POWER = math.sqrt(math.log(2)) / (2 * math.pi)  # frequency times standard deviation


def width_for_cutoff(hertz: float) -> float:
    """The smoothing in seconds that halves the power at a frequency. Raises ZeroDivisionError for 0 Hz."""
    return HALF_POWER / hertz / PER_WIDTH


def smooth_controls(
    values: NDArray[np.float32], seconds: float, fps: float, firm: Array | None = None
) -> NDArray[np.float32]:
    """Weighted means over a Gaussian window, (frames, controls) -> the same shape; end values are held.

    `seconds` is the window's width at half its height. `firm` (frames,) from 0 to 1 is how much of each frame
    stays unchanged. The window is symmetric, so that nothing moves in time. Its weights are positive, so that
    values stay within limits that they kept before.
    """
    deviation = seconds * PER_WIDTH * fps
    reach = math.ceil(REACH * deviation)
    if deviation < SHORTEST or len(values) < 2:
        return values
    window = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    window /= window.sum()
    padded = np.pad(values.astype(np.float64), [(reach, reach), (0, 0)], mode="edge")
    means = np.zeros(values.shape)
    for place, weight in enumerate(window):
        means += weight * padded[place : place + len(values)]
    kept = np.zeros((len(values), 1)) if firm is None else firm[:, None]
    return np.where(kept == 1, values, kept * values + (1 - kept) * means).astype(np.float32)


def closure_mask(
    modes: NDArray[np.floating],
    track: PhoneTrack,
    face: FaceModel,
    times: Array,
    articulation: Articulation | None = None,
) -> Array:
    """How much of each frame smoothing must leave alone, (frames,): 1 at closures, 0 a `RAMP` away.

    A closure is a frame whose lips are closed, by the articulation or else on the reference face, or a frame
    in the core of a phone with contact of lips or teeth.
    """
    if articulation is not None:
        closed = articulation.channel("lip_gap") <= 0
    else:
        closed = lip_gaps(modes, face).max(axis=1) < CLOSED
    marks = np.concatenate([times[closed], *_cores(track, times)])
    marks = np.concatenate([[-np.inf], np.unique(marks), [np.inf]])
    later = np.searchsorted(marks, times)
    apart = np.minimum(marks[later] - times, times - marks[later - 1])
    return np.asarray((1 + np.cos(np.pi * np.clip(apart / RAMP, 0, 1))) / 2)


def lip_gaps(modes: NDArray[np.floating], face: FaceModel) -> Array:
    """Gaps between the inner lips, (frames, modes) -> (frames, pairs) mm."""
    weights, offset = lip_functionals(face)
    pairs = len(INNER_LIP_PAIRS)
    return ordered_product(np.asarray(modes, np.float64), weights[:pairs].T) + offset[:pairs]


def _cores(track: PhoneTrack, times: Array) -> list[Array]:
    """The frames in the cores of p b m f v."""
    found = []
    for contact in (c for c in CONTACTS if c.measure == "gap"):
        chosen = np.isin(track.codes, INVENTORY.codes(contact.phones))
        begins, ends = track.bounds[:-1][chosen], track.bounds[1:][chosen]
        middles, halves = (begins + ends) / 2, (ends - begins) / 2 * contact.core
        first, last = np.searchsorted(times, middles - halves), np.searchsorted(times, middles + halves)
        found += [times[a:b] for a, b in zip(first, last, strict=True)]
    return found
