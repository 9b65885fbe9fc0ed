"""Lips close where they must, no more than they must, and nothing else moves."""

from __future__ import annotations

import numpy as np
from speech import made_up_face, track_of

from phonanim.face.contacts import (
    CONTACTS,
    contact_limits,
    enforce_lip_contacts,
    lip_functionals,
    project_within_limits,
)
from phonanim.face.model import lip_width
from phonanim.metrics import lip_gap

FACE = made_up_face(np.random.default_rng(0))
TRACK = track_of("sil 0.4 aa 0.2 p 0.05 aa 0.2 f 0.08 aa 0.2 sil 0.4")
OPEN = np.tile(FACE.std * [2, 0, 0], (92, 1)).astype(np.float32)


def test_the_middle_of_p_closes_at_any_rate() -> None:
    for fps in (24, 25, 29.97, 60, 120):
        frames = int(TRACK.duration * fps)
        times = np.arange(frames) / fps
        moved = enforce_lip_contacts(np.tile(OPEN[:1], (frames, 1)), TRACK, FACE, times)
        core = np.abs(times - 0.625) <= 0.01
        gaps = lip_gap(FACE.instance(moved[core]), FACE)
        assert (gaps <= CONTACTS[0].limit + 1e-3).all()


def test_teeth_leave_more_room_than_lips() -> None:
    limits = contact_limits(TRACK, np.array([0.625, 0.89]), "gap")
    assert np.allclose(limits, [CONTACTS[0].limit, CONTACTS[1].limit])


def test_far_frames_stay_as_they_were() -> None:
    times = np.arange(len(OPEN)) / 60
    moved = enforce_lip_contacts(OPEN, TRACK, FACE, times)
    far = ~np.isfinite(contact_limits(TRACK, times, "gap"))
    assert far.any()
    assert np.array_equal(moved[far], OPEN[far])


def test_closed_lips_are_left_alone() -> None:
    weights, offset = lip_functionals(FACE)
    shut = np.linalg.lstsq(weights[:7], -offset[:7], rcond=None)[0].astype(np.float32)
    modes = np.tile(shut, (92, 1))
    assert np.allclose(enforce_lip_contacts(modes, TRACK, FACE, np.arange(len(modes)) / 60), modes, atol=1e-5)


def test_without_such_phones_the_very_same_array_comes_back() -> None:
    track = track_of("sil 0.4 aa 0.5 sil 0.4")
    assert enforce_lip_contacts(OPEN, track, FACE, np.arange(len(OPEN)) / 60) is OPEN


def test_the_bound_is_smooth() -> None:
    times = np.arange(0, TRACK.duration, 0.001)
    limits = np.minimum(contact_limits(TRACK, times, "gap"), 14.3)
    assert np.abs(np.diff(limits)).max() < 0.5


def test_postalveolars_round() -> None:
    track = track_of("sil 0.2 iy 0.2 sh 0.1 iy 0.2 sil 0.2")
    wide = np.sign(lip_width(FACE.instance(np.eye(3)[1:2]), FACE) - lip_width(FACE.mean[None], FACE))
    spread = np.tile(FACE.std * [0, 3, 0] * wide, (54, 1)).astype(np.float32)
    moved = enforce_lip_contacts(spread, track, FACE, np.arange(len(spread)) / 60)
    assert lip_width(FACE.instance(spread[27:28]), FACE)[0] > CONTACTS[2].limit
    assert lip_width(FACE.instance(moved[27:28]), FACE)[0] <= CONTACTS[2].limit + 0.1


def test_the_bound_of_a_p_by_hand() -> None:
    """A p of 0.1 s: its middle 40 % at the limit, then a raised cosine of 60 ms up to 14 mm more."""
    track = track_of("sil 0.4 p 0.1 sil 0.4")
    away = np.array([0.0, 0.019, 0.035, 0.05, 0.0801])
    rises = [0.3, 0.3, 0.3 + 7 * (1 - np.cos(np.pi / 4)), 7.3, np.inf]
    np.testing.assert_allclose(contact_limits(track, 0.45 + away, "gap"), rises)
    np.testing.assert_allclose(contact_limits(track, 0.45 - away[::-1], "gap"), rises[::-1])
    assert np.isinf(contact_limits(track, np.array([0.45]), "width")).all()


def test_bounds_that_overlap_take_the_lower() -> None:
    both = track_of("sil 0.4 f 0.06 p 0.06 sil 0.4")
    alone = track_of("sil 0.46 p 0.06 sil 0.4")
    times = np.array([0.47, 0.49, 0.51])
    np.testing.assert_array_equal(contact_limits(both, times, "gap"), contact_limits(alone, times, "gap"))
    assert contact_limits(both, np.array([0.43]), "gap")[0] == CONTACTS[1].limit


def test_frames_may_begin_later() -> None:
    times = np.arange(len(OPEN)) / 60
    later = enforce_lip_contacts(OPEN[30:], TRACK, FACE, times[30:])
    np.testing.assert_allclose(later, enforce_lip_contacts(OPEN, TRACK, FACE, times)[30:], atol=1e-6)


def test_the_change_is_the_smallest_in_standard_deviations() -> None:
    """One bound w·p <= limit: p moves by std² w times the excess over w·std² w (a weighted projection)."""
    std, weight = np.array([2.0, 1.0]), np.array([[1.0, 1.0]])
    found = project_within_limits(np.array([[3.0, 1.0], [0.0, 0.5]]), weight, np.array([[1.0], [1.0]]), std)
    np.testing.assert_allclose(found, [[3.0 - 4 * 3 / 5, 1.0 - 3 / 5], [0.0, 0.5]], atol=1e-9)


def test_two_bounds_are_met_together() -> None:
    """A bound that another has made needless gives its change back (Dykstra's memory)."""
    weights, limits = np.array([[1.0, 0.0], [1.0, 1.0]]), np.array([[1.0, 0.0]])
    found = project_within_limits(np.array([[2.0, 2.0]]), weights, limits, np.ones(2))
    np.testing.assert_allclose(found, [[0.0, 0.0]], atol=1e-2)


def test_the_measures_of_the_lips_are_linear_in_the_modes() -> None:
    weights, offset = lip_functionals(FACE)
    modes = np.random.default_rng(1).normal(0, 2, (5, len(FACE.std)))
    shapes = FACE.instance(modes)
    rows = {number: shapes[:, FACE.landmark(number)] for number in (61, 291, 13, 14, 80, 88)}
    measured = modes @ weights.T + offset
    np.testing.assert_allclose(measured[:, 0], rows[80][:, 1] - rows[88][:, 1])
    np.testing.assert_allclose(measured[:, 3], rows[13][:, 1] - rows[14][:, 1])
    np.testing.assert_allclose(measured[:, 7], rows[291][:, 0] - rows[61][:, 0])
