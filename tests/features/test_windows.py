"""Laws of the sliding windows, and that every frame rate samples one and the same motion."""

from __future__ import annotations

import numpy as np
import pytest
from speech import made_up_examples, random_track

from phonanim.features.windows import overlap_mean, predict_at, sliding_windows
from phonanim.regressors.phone_mean import Config as MeanConfig
from phonanim.regressors.phone_mean import PhoneMean
from phonanim.regressors.tree import Config as TreeConfig
from phonanim.regressors.tree import Forest
from phonanim.speech.phones import PhoneTrack

RATES = (24, 25, 30000 / 1001, 30, 48, 50, 60, 120)


def test_windows_of_a_constant_give_it_back() -> None:
    constant = np.full((9, 2), 3.5)
    assert np.array_equal(overlap_mean(sliding_windows(constant, 5)), constant)


def test_slide_repeats_the_edges() -> None:
    assert sliding_windows(np.arange(4), 5)[0].tolist() == [0, 0, 0, 1, 2]
    assert sliding_windows(np.arange(4), 5)[3].tolist() == [1, 2, 3, 3, 3]


def test_overlap_mean_agrees_with_a_slow_version() -> None:
    windows = np.random.default_rng(0).normal(size=(7, 5, 2))
    for frame in range(7):
        over = [windows[c, frame - c + 2] for c in range(7) if 0 <= frame - c + 2 < 5]
        assert np.allclose(overlap_mean(windows)[frame], np.mean(over, axis=0))


def test_native_rate_equals_overlap_mean() -> None:
    windows = np.random.default_rng(0).normal(size=(10, 5, 2)).astype(np.float32)
    found = predict_at(
        np.arange(10) / 25, 9 / 25, 1 / 25, 5, lambda t: windows[np.round(t * 25).astype(int).clip(0, 9)]
    )
    assert np.allclose(found, overlap_mean(windows), atol=1e-6)


@pytest.mark.parametrize("fps", RATES)
def test_frame_rates_agree_at_shared_instants(fps: float) -> None:
    pytest.importorskip("sklearn")
    rng = np.random.default_rng(1)
    data = made_up_examples(rng)
    forest = Forest.fit(TreeConfig(leaf=2), data, data, rng, lambda done: None)
    track = random_track(rng, 60)
    frames = int(track.duration * fps)
    found = forest.predict(track, np.arange(frames) / fps)
    native = forest.predict(track, np.arange(int(track.duration * 25)) / 25)
    shared = [(n, round(n / fps * 25)) for n in range(frames) if abs(n / fps * 25 % 1 - 0.0) < 1e-9]
    shared = [(n, m) for n, m in shared if m < len(native)]
    assert shared
    for n, m in shared:
        assert np.array_equal(found[n], native[m])


def test_a_closure_of_30_ms_is_seen_at_60_fps() -> None:
    codes = np.array([8, 11, 8], np.uint8)
    track = PhoneTrack(codes, np.array([0, 0.5, 0.53, 1.0]), ("aa", "m", "aa"))
    model = PhoneMean(MeanConfig(smoothing=0.01), np.arange(41, dtype=np.float32)[:, None])
    assert 11 in model.predict(track, np.arange(60) / 60)[:, 0]


def test_shifting_by_whole_frames_shifts_the_motion() -> None:
    rng = np.random.default_rng(2)
    data = made_up_examples(rng)
    model = PhoneMean.fit(MeanConfig(), data, data, rng, lambda done: None)
    track = random_track(rng)
    later = PhoneTrack(
        track.codes, track.bounds + np.r_[0.0, np.full(len(track.bounds) - 1, 0.4)], track.labels
    )
    times = np.arange(0, 2, 0.04)
    assert np.allclose(model.predict(later, times + 0.4)[5:], model.predict(track, times)[5:], atol=1e-4)


@pytest.mark.parametrize("width", [1, 5])
def test_film_that_outlasts_the_alignment_holds_its_end(width: int) -> None:
    def windows(times: np.ndarray) -> np.ndarray:
        return np.repeat(3 + times[:, None, None], width, axis=1).astype(np.float32)

    found = predict_at(np.array([-0.1, 0.0, 0.98, 1.0, 1.002, 1.02, 2.0]), 1.0, 0.04, width, windows)[:, 0]
    assert np.all(found[:1] == found[1])
    assert np.all(found[3:] == found[3])
    assert np.all(found[3] > 3.9)


def test_no_frames() -> None:
    empty = predict_at(np.zeros(0), 1.0, 0.04, 5, lambda t: np.zeros((len(t), 5, 2), np.float32))
    assert empty.shape == (0, 2)


def test_blending_keeps_the_type() -> None:
    assert overlap_mean(np.ones((4, 3, 2), np.float32)).dtype == np.float32
