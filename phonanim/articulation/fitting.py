"""Fit targets and weights to recordings, with a handmade table as the prior where there is little data.

One channel at a time: y(t) = a_s + b_s sum_i w_i T_i K_i(t) / sum_i w_i K_i(t) of trajectories.py for speaker
s. T and log w have a normal prior around the table, correlated for gestures of similar articulation; the
speakers' scales b have a normal prior too. Gauss-Newton steps find the most probable values (a mixed model
with speakers as the groups).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.trajectories import gesture_kernels
from phonanim.speech.gestures import GESTURES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

NOISE = 0.6  # of a speaker's standard deviation: the part that phones do not explain
LASTS = 0.05  # seconds; frames nearer than this are not independent
SHARED = 0.5  # share of a gesture's deviation that gestures of similar articulation have in common
SCALES = {True: 0.25, False: 1.0}  # sd of the log scale of a speaker measured in mm, or in unknown units
ITERATIONS, STEP, SETTLED = 15, 0.5, 5e-3


@dataclass(frozen=True)
class Observation:
    """One channel of one recording: `values` (frames,) at `times` (frames,) seconds of `track`.

    `spacing` is the seconds between frames, `in_mm` is whether the unit is known, `share` is its weight.
    """

    speaker: str
    name: str
    track: PhoneTrack
    times: Array
    values: Array
    spacing: float
    in_mm: bool = True
    share: float = 1.0


@dataclass(frozen=True)
class Channel:
    """One channel: `target` (gestures,) mm, `weight` (gestures,), `sigma` and `lead` in seconds."""

    target: Array
    weight: Array
    sigma: float
    lead: float

    def predict(self, track: PhoneTrack, times: Array) -> Array:
        """The blend at instants, (frames,) mm."""
        kernels = gesture_kernels(track, times, self.sigma, self.lead)
        return np.asarray(kernels @ (self.weight * self.target) / (kernels @ self.weight))


@dataclass(frozen=True)
class Freedom:
    """The strength of the prior: standard deviations of targets (mm) and of log weights."""

    target: float
    weight: float


def fit_channel(observations: Sequence[Observation], prior: Channel, freedom: Freedom) -> Channel:
    """The most probable targets and weights, with the prior's sigma and lead."""
    speakers = sorted({one.speaker for one in observations})
    kernels = [gesture_kernels(one.track, one.times, prior.sigma, prior.lead) for one in observations]
    spread = {s: np.concatenate([o.values for o in observations if o.speaker == s]).std() for s in speakers}
    start = _start(observations, kernels, prior, speakers)
    precision = _precision(observations, speakers, freedom)
    state = start.copy()
    for _ in range(ITERATIONS):
        matrix, pull = precision.copy(), precision @ (start - state)
        for one, kernel in zip(observations, kernels, strict=True):
            slope, rest = _linearized(one, kernel, state, speakers.index(one.speaker))
            certainty = one.share * min(one.spacing / LASTS, 1) / (NOISE * spread[one.speaker]) ** 2
            matrix += certainty * slope.T @ slope
            pull += certainty * slope.T @ rest
        step = np.linalg.solve(matrix, pull)
        step[len(GESTURES.names) :] = step[len(GESTURES.names) :].clip(-STEP, STEP)
        state += step
        if np.abs(step).max() < SETTLED:
            break
    target, weight, _ = _parts(state)
    return Channel(target, np.exp(weight), prior.sigma, prior.lead)


def _parts(state: Array) -> tuple[Array, Array, Array]:
    """Targets (gestures,), log weights (gestures,), and each speaker's offset and log scale (speakers, 2)."""
    count = len(GESTURES.names)
    return state[:count], state[count : 2 * count], state[2 * count :].reshape(-1, 2)


def _start(
    observations: Sequence[Observation], kernels: Sequence[Array], prior: Channel, speakers: Sequence[str]
) -> Array:
    """The prior, with each speaker's offset, and scale where the unit is unknown, from the data."""
    own = []
    for speaker in speakers:
        chosen = [n for n, one in enumerate(observations) if one.speaker == speaker]
        blend = np.concatenate(
            [kernels[n] @ (prior.weight * prior.target) / (kernels[n] @ prior.weight) for n in chosen]
        )
        values = np.concatenate([observations[n].values for n in chosen])
        scale = 1.0 if observations[chosen[0]].in_mm else values.std() / max(blend.std(), 1e-6)
        own += [values.mean() - scale * blend.mean(), np.log(scale)]
    return np.concatenate([prior.target, np.log(prior.weight), own])


def _precision(observations: Sequence[Observation], speakers: Sequence[str], freedom: Freedom) -> Array:
    """Inverse covariance of the prior; a speaker's offset is free."""
    features = GESTURES.articulation.astype(np.float64)
    apart = ((features[:, None] - features[None]) ** 2).sum(axis=-1)
    alike = np.linalg.inv(SHARED * np.exp(-apart / 2) + (1 - SHARED) * np.eye(len(features)))
    count = len(features)
    precision = np.zeros((2 * count + 2 * len(speakers),) * 2)
    precision[:count, :count] = alike / freedom.target**2
    precision[count : 2 * count, count : 2 * count] = alike / freedom.weight**2
    for number, speaker in enumerate(speakers):
        in_mm = next(one.in_mm for one in observations if one.speaker == speaker)
        place = 2 * count + 2 * number
        precision[place, place], precision[place + 1, place + 1] = 1e-6, 1 / SCALES[in_mm] ** 2
    return precision


def _linearized(one: Observation, kernel: Array, state: Array, speaker: int) -> tuple[Array, Array]:
    """Jacobian of the model, (frames, unknowns), and residual, (frames,)."""
    target, weight, own = _parts(state)
    offset, scale = own[speaker, 0], np.exp(own[speaker, 1])
    pulls = kernel * np.exp(weight)
    shares = scale * pulls / pulls.sum(axis=1, keepdims=True)
    blend = shares @ target / scale
    slope = np.zeros((len(blend), len(state)))
    count = len(target)
    slope[:, :count] = shares
    slope[:, count : 2 * count] = shares * (target - blend[:, None])
    slope[:, 2 * count + 2 * speaker], slope[:, 2 * count + 2 * speaker + 1] = 1.0, scale * blend
    return slope, one.values - offset - scale * blend
