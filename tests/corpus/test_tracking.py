"""Tracks of faces: gaps are bridged or refused, jumps are seen, and their quality is told."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from faces import head_face
from films import COLUMNS, ROWS, fake_tracker, head_shape, make_film
from pictured import a_pose, photograph, pictured_face

from phonanim.corpus.corpus import PUPILS, RIGID
from phonanim.corpus.tracking import (
    Tracker,
    aam_tracker,
    bridge_gaps,
    check_cuts,
    find_jumps,
    leaves_frame,
    measure_quality,
    mediapipe_tracker,
    shipped_indices,
    track_film,
)
from phonanim.errors import CorpusError, MissingExtraError, ModelError
from phonanim.face.aam import build_fitter
from phonanim.face.appearance import save_appearance
from phonanim.media.video import open_film

pytest.importorskip("av")
INDICES = head_face().indices


def test_a_short_gap_is_bridged_and_told(tmp_path: Path) -> None:
    film = open_film(make_film(tmp_path / "a.mp4", dark=(0, 7, 8)))
    track = track_film(film, fake_tracker())
    assert track.rejected == dict.fromkeys((0, 7, 8), "no face was found")
    assert np.allclose(track.landmarks[0], head_shape(1))
    assert np.allclose(track.landmarks[7], (2 * head_shape(6) + head_shape(9)) / 3)


def test_a_long_gap(tmp_path: Path) -> None:
    film = open_film(make_film(tmp_path / "a.mp4", dark=(5, 6, 7, 8)))
    with pytest.raises(
        CorpusError, match=r"a\.mp4: no usable face in frames 5 to 8, from 0\.20 s \(no face was found\)"
    ):
        track_film(film, fake_tracker())


def test_no_face(tmp_path: Path) -> None:
    film = open_film(make_film(tmp_path / "a.mp4", dark=tuple(range(20))))
    with pytest.raises(CorpusError, match=r"a\.mp4: no face was found in any frame; the whole face"):
        track_film(film, fake_tracker())


def test_a_jump_is_one_frame_far_from_both_its_neighbours() -> None:
    landmarks = np.stack([head_shape(n) for n in range(10)])
    assert find_jumps(landmarks, INDICES, 25) == []
    landmarks[4, :, 0] += 30
    assert find_jumps(landmarks, INDICES, 25) == [4]


def test_a_face_that_goes_on_at_another_place(tmp_path: Path) -> None:
    film = open_film(make_film(tmp_path / "a.mp4"))
    landmarks = np.stack([head_shape(n) for n in range(20)])
    check_cuts(film, landmarks, INDICES)
    landmarks[8:, :, 0] += 30
    landmarks[7] = np.nan
    with pytest.raises(
        CorpusError, match=r"a\.mp4: the face is at another place from frame 8 on, 0\.32 s \(a"
    ):
        check_cuts(film, landmarks, INDICES)


def test_a_mouth_that_leaves_the_picture(tmp_path: Path) -> None:
    shape, frame = head_shape(0), np.zeros((ROWS, COLUMNS, 3), np.uint8)
    assert not leaves_frame(shape, INDICES, frame)
    assert leaves_frame(shape + np.array([0, ROWS / 2, 0]), INDICES, frame)
    below = Tracker(
        "below", INDICES, lambda frames: (shape + np.array([0, ROWS, 0]) for _ in frames), "no face"
    )
    with pytest.raises(
        CorpusError, match=r"a\.mp4: the mouth leaves the picture in any frame; the whole face"
    ):
        track_film(open_film(make_film(tmp_path / "a.mp4")), below)


def test_bridging_keeps_what_is_known() -> None:
    landmarks = np.arange(12.0).reshape(4, 1, 3)
    holed = landmarks.copy()
    holed[1] = np.nan
    assert np.allclose(bridge_gaps(holed), landmarks)


def test_quality_is_in_pixels_millimetres_and_degrees() -> None:
    still = np.tile(head_shape(0), (400, 1, 1))
    pupils = np.linalg.norm(still[0, PUPILS[1]] - still[0, PUPILS[0]])
    assert measure_quality(still, INDICES).pupils_px == pytest.approx(pupils)
    assert measure_quality(still, INDICES).jitter_mm == pytest.approx(0, abs=1e-9)
    noisy = still.copy()
    noisy[:, list(RIGID)] += np.random.default_rng(0).normal(0, 0.2, (400, len(RIGID), 3))
    assert measure_quality(noisy, INDICES).jitter_mm == pytest.approx(
        0.2 * np.sqrt(2) * 63 / pupils, rel=0.05
    )


def test_small_and_turned_faces_are_warned_of() -> None:
    shape = head_shape(0)
    turn = np.radians(30)
    side = shape @ np.array([[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]])
    worth = measure_quality(np.tile(side, (3, 1, 1)), INDICES)
    assert worth.turn_deg == pytest.approx(30, abs=1.5)
    small, turned = worth.warnings()
    assert "the face is small" in small
    assert "the head turns by" in turned
    assert measure_quality(np.tile(3 * shape, (3, 1, 1)), INDICES).warnings() == []


def test_without_mediapipe(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("mediapipe", "mediapipe.python", "mediapipe.python.solutions"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingExtraError, match=r"tracking needs MediaPipe: pip install 'phonanim\[track\]'"):
        mediapipe_tracker(INDICES)


def test_mediapipe_sees_no_face_in_a_wall() -> None:
    pytest.importorskip("mediapipe", reason="mediapipe is not installed: pip install 'phonanim[track]'")
    tracker = mediapipe_tracker(shipped_indices())
    assert list(tracker.follow([np.full((96, 96, 3), 90, np.uint8)])) == [None]


def test_an_appearance_model_tracks(tmp_path: Path) -> None:
    save_appearance(pictured_face(), tmp_path, {})
    tracker, fitter = aam_tracker(tmp_path), build_fitter(pictured_face())
    pose = a_pose(fitter)
    picture = np.repeat(photograph(fitter, pose)[..., None], 3, axis=2).astype(np.uint8)
    first, blank, again = tracker.follow([picture, np.zeros_like(picture), picture])
    assert first is not None
    assert again is not None
    assert blank is None
    assert first.shape == (len(tracker.indices), 3)
    assert np.linalg.norm((first - fitter.landmarks(pose))[fitter.model.rows, :2], axis=1).mean() < 1.0


def test_a_folder_that_is_no_model(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="is not an appearance model"):
        aam_tracker(tmp_path)


def test_the_shipped_landmarks_hold_the_head_still() -> None:
    assert set(RIGID + PUPILS) <= set(shipped_indices().tolist())
