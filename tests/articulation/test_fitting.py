"""Targets are found again in motion that was made from them, and stay where nothing is said."""

from __future__ import annotations

import numpy as np
from speech import random_track

from phonanim.articulation import CHANNELS
from phonanim.articulation.fitting import Channel, Freedom, Observation, fit_channel
from phonanim.articulation.table import read_targets
from phonanim.articulation.trajectories import gesture_kernels
from phonanim.speech.gestures import GESTURES

JAW = CHANNELS.index("jaw")
FREEDOM = Freedom(4.0, 0.5)


def table() -> Channel:
    targets = read_targets()
    return Channel(targets.target[:, JAW], targets.weight[:, JAW], 0.03, 0.0)


def observed(true: Channel, speaker: str, seed: int, scale: float = 1.0, in_mm: bool = True) -> Observation:
    """Motion of random phones by a table, with an offset and a scale of a speaker's own."""
    track = random_track(np.random.default_rng(seed), 150)
    times = np.arange(0, track.duration, 0.01)
    return Observation(
        speaker, f"{speaker}{seed}", track, times, 7 + scale * true.predict(track, times), 0.01, in_mm
    )


def opened(prior: Channel, gesture: str, by: float) -> Channel:
    target = prior.target.copy()
    target[GESTURES.names.index(gesture)] += by
    return Channel(target, prior.weight, prior.sigma, prior.lead)


def test_a_fit_of_the_prior_itself_stays_there() -> None:
    prior = table()
    fitted = fit_channel([observed(prior, "a", 1)], prior, FREEDOM)
    assert np.abs(fitted.target - prior.target).max() < 0.05


def test_a_target_is_found_again_whatever_the_speakers_scale() -> None:
    prior = table()
    true = opened(prior, "iy", 4.0)
    seen = [observed(true, "a", seed) for seed in (1, 2)] + [observed(true, "b", 3, 0.1, in_mm=False)]
    moved = fit_channel(seen, prior, FREEDOM).target - prior.target
    assert moved.argmax() == GESTURES.names.index("iy")
    assert moved.max() > 2.5


def test_freedom_bounds_how_far_a_fit_goes() -> None:
    prior = table()
    seen = [observed(opened(prior, "iy", 4.0), "a", 1)]
    loose, strict = (fit_channel(seen, prior, Freedom(mm, 0.05)) for mm in (4.0, 0.1))
    assert np.abs(strict.target - prior.target).max() < 0.5 * np.abs(loose.target - prior.target).max()


def test_little_data_says_little() -> None:
    prior = table()
    track = random_track(np.random.default_rng(0), 10)
    noise = np.random.default_rng(1).normal(0, 9, 3)
    seen = [Observation("a", "a", track, np.array([0.2, 0.3, 0.4]), noise, 0.01)]
    assert np.abs(fit_channel(seen, prior, Freedom(1.0, 0.3)).target - prior.target).max() < 0.6


def test_kernels_share_every_instant() -> None:
    track = random_track(np.random.default_rng(2), 30)
    times = np.arange(-1, track.duration + 1, 0.02)
    kernels = gesture_kernels(track, times, 0.04, 0.0)
    assert np.allclose(kernels.sum(axis=1), 1)
    assert (kernels > -1e-12).all()
    early = gesture_kernels(track, times, 0.04, 0.1)
    assert (early >= kernels - 1e-12).all()
