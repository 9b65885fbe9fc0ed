"""The search for a known face: pictures drawn from known poses are found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pictured import a_pose, photograph, pictured_face, skin

from phonanim.core.search import correlation_map, downscale, first_guesses
from phonanim.face.aam import Fitter, Pose, build_fitter, find_face, track_face
from phonanim.face.warp import sample_bilinear


@pytest.fixture(scope="module")
def fitter() -> Fitter:
    return build_fitter(pictured_face())


def test_a_pose_nearby_is_found(fitter: Fitter) -> None:
    truth = a_pose(fitter)
    shape = truth.shape + np.random.default_rng(4).normal(0, 0.4, len(truth.shape))
    found = fitter.fit(
        photograph(fitter, truth), Pose(truth.similarity + np.array([0.04, -0.02, 1.0, -1.0]), shape)
    )
    apart = np.linalg.norm(fitter.points(found) - fitter.points(truth), axis=1)
    assert apart.mean() < 0.5  # pixels
    assert found.likeness > 0.95


def test_brightness_and_contrast_do_not_matter(fitter: Fitter) -> None:
    truth = a_pose(fitter)
    picture, start = photograph(fitter, truth), replace(truth, shape=np.zeros_like(truth.shape))
    plain, dim = fitter.fit(picture, start), fitter.fit(0.5 * picture + 40, start)
    assert np.abs(fitter.points(plain) - fitter.points(dim)).max() < 0.1


def test_the_face_is_found_anywhere(fitter: Fitter) -> None:
    for seed, scale in ((5, 1.0), (6, 1.4)):
        truth = a_pose(fitter, seed, scale)
        found = find_face(fitter, photograph(fitter, truth))
        apart = np.linalg.norm(fitter.points(found) - fitter.points(truth), axis=1)
        assert apart.mean() < 1.0


def test_all_landmarks_agree_with_the_mesh(fitter: Fitter) -> None:
    turned = a_pose(fitter)
    straight = replace(turned, shape=np.append(turned.shape[:-2], [0.0, 0.0]))
    for pose, within in ((straight, 1e-6), (turned, 0.5)):  # the search takes the depth of the mean
        landmarks = fitter.landmarks(pose)
        assert landmarks.shape == fitter.model.face.mean.shape
        assert np.abs(landmarks[fitter.model.rows, :2] - fitter.points(pose)).max() < within


def test_a_film_is_followed_and_what_is_no_face_is_rejected(fitter: Fitter) -> None:
    poses = [replace(a_pose(fitter), similarity=np.array([1.3, 0.0, 68.0 + n, 55.0])) for n in range(4)]
    frames = [np.repeat(photograph(fitter, pose)[..., None], 3, axis=2).astype(np.uint8) for pose in poses]
    frames.insert(2, np.zeros_like(frames[0]))
    found = list(track_face(fitter, frames))
    assert [pose is None for pose in found] == [False, False, True, False, False]
    middles = [fitter.points(pose).mean(axis=0)[0] for pose in found if pose]
    assert np.allclose(np.diff(middles), 1.0, atol=0.2)


def test_a_search_that_runs_away_says_that_it_found_nothing(fitter: Fitter) -> None:
    noise = np.random.default_rng(7).normal(120, 40, (110, 150)).astype(np.float32)
    far = Pose(np.array([0.2, 0.0, -500.0, 900.0]), np.full_like(fitter.start, 3.0))
    assert fitter.fit(noise, far).likeness < fitter.options.likeness


def test_correlation_is_pearsons_under_the_mask() -> None:
    rng = np.random.default_rng(8)
    image, template = rng.normal(size=(9, 11)), rng.normal(size=(4, 5))
    mask = (rng.random((4, 5)) > 0.3).astype(np.float32)
    fast = correlation_map(image.astype("f4"), template.astype("f4"), mask)
    for row, column in ((0, 0), (2, 3), (5, 6)):
        piece = image[row : row + 4, column : column + 5][mask > 0]
        assert fast[row, column] == pytest.approx(np.corrcoef(piece, template[mask > 0])[0, 1], abs=5e-3)


def test_shrinking_keeps_the_mean() -> None:
    image = skin(np.random.default_rng(1), 40, 60)[..., 0]
    assert downscale(image, 0.5).shape == (20, 30)
    assert downscale(image, 0.5).mean() == pytest.approx(image.mean(), rel=1e-4)


def test_the_first_guess_is_near() -> None:
    template = skin(np.random.default_rng(2), 30, 44)[..., 0]
    scene = skin(np.random.default_rng(3), 120, 160)[..., 0]
    down, right = np.mgrid[:45, :66]
    enlarged = sample_bilinear(template[..., None], np.column_stack([right.ravel(), down.ravel()]) / 1.5)
    scene[50:95, 60:126] = enlarged.reshape(45, 66)
    scale, corner = first_guesses(scene, template, np.ones_like(template))[0]
    assert scale == pytest.approx(1.5, rel=0.15)
    assert np.abs(corner - [60, 50]).max() < 8


def test_a_turned_head_moves_near_landmarks_more_than_far_ones(fitter: Fitter) -> None:
    """The search and the landmarks agree on a nod: the points of the mesh are those of the face."""
    n_modes = len(fitter.model.face.std)
    for turn in range(2):
        shape = fitter.start.copy()
        shape[n_modes + turn] = 1.0
        pose = Pose(np.array([1.0, 0.0, 70.0, 55.0]), shape)
        mesh, whole = fitter.points(pose), fitter.landmarks(pose)[fitter.model.rows, :2]
        np.testing.assert_allclose(mesh, whole, atol=0.05)


def test_a_picture_without_contrast_shows_nothing(fitter: Fitter) -> None:
    pose = a_pose(fitter)
    picture = photograph(fitter, pose)
    assert fitter.likeness(picture, pose) > 0.9
    faint = picture.mean() + 0.05 * (picture - picture.mean())
    assert fitter.likeness(faint, pose) == 0.0
    pale = picture.mean() + 0.3 * (picture - picture.mean())
    assert fitter.likeness(pale, pose) > 0.9
