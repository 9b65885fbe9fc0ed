"""Gaps, rates, heads, and what is measured of tongues and jaws."""

from __future__ import annotations

from dataclasses import replace

import ema_samples as samples
import numpy as np
import pytest
from numpy.typing import NDArray
from speech import track_of

from phonanim.ema import Articulation
from phonanim.ema.examples import (
    Stretch,
    diphone_stretches,
    measure_stretch,
    phone_stretches,
    side_sums,
    summarize_examples,
)
from phonanim.ema.measures import (
    convex_hull,
    envelope,
    menger_curvature,
    polygon_area,
    speeds,
    tongue_curvature,
    tongue_width,
)
from phonanim.ema.posture import bite_posture, correct_head_motion, rest_posture, rigid_fit
from phonanim.ema.preparation import fill_gaps, resample_sensors
from phonanim.errors import CorpusError
from phonanim.evaluation.statistics import pearson

Array = NDArray[np.float64]


def line(samples_: int, rate: float = 100.0) -> Articulation:
    """One sensor that moves by 1 mm in each sample, in every axis."""
    return Articulation(("TT",), np.repeat(np.arange(float(samples_)), 3).reshape(-1, 1, 3), rate)


def wave(hertz: float, rate: float = 200.0, seconds: float = 2.0) -> Articulation:
    values = np.sin(2 * np.pi * hertz * np.arange(int(seconds * rate)) / rate)
    return Articulation(("TT",), np.repeat(values, 3).reshape(-1, 1, 3), rate)


def test_short_gaps_are_filled_and_all_are_told() -> None:
    whole = line(40)
    holed = whole.positions.copy()
    holed[10:15, 0, 1] = np.nan  # 50 ms of one axis
    holed[20:26] = np.nan  # 60 ms
    holed[38:] = np.nan
    found, gaps = fill_gaps(replace(whole, positions=holed))
    np.testing.assert_allclose(found.positions[:20], whole.positions[:20])
    assert np.isnan(found.positions[20:26]).all()
    assert np.isnan(found.positions[38:]).all()
    assert [(g.sensor, g.start, g.end, g.filled) for g in gaps] == [
        ("TT", 0.1, 0.15, True),
        ("TT", 0.2, 0.26, False),
        ("TT", 0.38, 0.4, False),
    ]


@pytest.mark.parametrize("rate", [60.0, 100.0, 250.0, 441.0])
def test_resampling_keeps_what_is_slow_and_delays_nothing(rate: float) -> None:
    found = resample_sensors(wave(9.0), rate)
    expected = np.sin(2 * np.pi * 9.0 * found.times)
    inner = slice(len(found.times) // 4, -len(found.times) // 4)
    assert np.abs(found.positions[inner, 0, 0] - expected[inner]).max() < 2e-3
    assert found.times[-1] == pytest.approx(1.995, abs=1 / rate)


def test_resampling_takes_away_what_is_fast() -> None:
    found = resample_sensors(wave(70.0), 100.0)  # would come back as 30 Hz
    assert np.abs(found.positions[30:-30]).max() < 2e-3
    assert np.abs(resample_sensors(wave(30.0), 200.0, 20.0).positions[120:-120]).max() < 2e-3


def test_resampling_keeps_lines_rests_and_gaps() -> None:
    moving = line(200)
    found = resample_sensors(moving, 250.0)
    np.testing.assert_allclose(found.positions[:, 0, 0], 100 * found.times, atol=2e-3)  # mm, of 1 a sample
    holed = moving.positions.copy()
    holed[50:100] = np.nan
    found = resample_sensors(replace(moving, positions=holed), 200.0, 20.0)
    lost = np.isnan(found.positions[:, 0, 0])
    assert (found.times[lost] > 0.49).all()
    assert (found.times[lost] < 1.0).all()
    assert lost.sum() == 101
    assert resample_sensors(moving, 100.0) is moving
    one = Articulation(("TT",), np.ones((1, 1, 3)), 100.0)
    np.testing.assert_allclose(resample_sensors(one, 100.0, 10.0).positions, 1.0)


def turned(rng: np.random.Generator, count: int) -> Array:
    """Random rotations, (count, 3, 3)."""
    found, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    return np.asarray(found * np.linalg.det(found)[:, None, None])


def test_a_head_that_moves_is_held_still() -> None:
    rng = np.random.default_rng(0)
    names = ("NA", "EL", "ER", "UI", "TT")
    rest = np.array([[90, 0, 60], [0, 70, 0], [0, -70, 0], [80, 0, 0], [60, 0, -5]], float)
    tongue = rest[None].repeat(50, axis=0)
    tongue[:, 4] += rng.normal(size=(50, 3))
    moved = np.einsum("sij,snj->sni", turned(rng, 50), tongue) + rng.normal(size=(50, 1, 3), scale=20)
    moved[7, 1] = np.nan
    posture = rest_posture(Articulation(names, rest[None], 100.0), names[:4])
    found = correct_head_motion(Articulation(names, moved, 100.0), posture)
    kept = np.delete(np.arange(50), 7)
    np.testing.assert_allclose(found.positions[kept], tongue[kept], atol=1e-9)
    assert np.isnan(found.positions[7]).all()


def test_a_fit_is_never_a_mirror() -> None:
    points = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]], float)
    rotation, _ = rigid_fit(points[None] * [1, 1, -1], points)
    assert np.linalg.det(rotation[0]) == pytest.approx(1)


def test_the_plate_between_the_teeth_gives_the_axes() -> None:
    skull = [(0, 0, 100), (70, 0, 50), (-70, 0, 50)]  # here forward is y, left is -x
    plate = [(0, 30, 10), (-20, 0, 10), (20, 0, 10)]
    bite = samples.still(*skull, *plate, (5, 30, 20), names="NA EL ER front left right UI")
    references = ("NA", "EL", "ER")
    posture = bite_posture(bite, references, ("front", "left", "right"))
    np.testing.assert_allclose(posture.rotation, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)
    found = correct_head_motion(bite, posture)
    np.testing.assert_allclose(found.sensor("front")[0], [0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(found.sensor("UI")[0], [0, -5, 10], atol=1e-9)
    posture = bite_posture(bite, references, ("front", "left", "right"), "UI")
    np.testing.assert_allclose(correct_head_motion(bite, posture).sensor("UI")[0], [0, 0, 0], atol=1e-9)


def test_heads_that_cannot_be_held() -> None:
    bite = samples.still((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 3, 0), names="a b c d")
    with pytest.raises(
        CorpusError, match="2 reference sensors do not fix the head; name 3 or more on the skull"
    ):
        rest_posture(bite, ("a", "b"))
    with pytest.raises(CorpusError, match="made up: a, b, c are on a line; name others"):
        rest_posture(bite, ("a", "b", "c"))
    with pytest.raises(CorpusError, match="made up: a, b, c are on a line; name front, left and right"):
        bite_posture(bite, ("a", "b", "d"), ("a", "b", "c"))
    lost = replace(bite, positions=np.full_like(bite.positions, np.nan))
    with pytest.raises(CorpusError, match="made up: sensor a was never tracked; leave it out"):
        rest_posture(lost, ("a", "b", "d"))


def test_width_is_the_distance_of_the_sides() -> None:
    found = tongue_width(samples.still((0, 3, 0), (0, -3, 8), names="BL BR"))
    np.testing.assert_allclose(found, 10.0)


@pytest.mark.parametrize(("height", "expected"), [(10, 0.1), (-10, -0.1), (0, 0.0), (5, 0.08)])
def test_curvature_is_one_over_the_radius_with_its_sign(height: float, expected: float) -> None:
    # Left and right 10 mm from the middle: with the blade as high, they lie on a circle of 10 mm.
    # For 5 mm, the circle has the radius (10² + 5²) / (2 * 5) = 12.5 mm.
    tongue = samples.still((2, 10, 0), (7, 0, height), (1, -10, 0), names="BL TB BR")
    np.testing.assert_allclose(tongue_curvature(tongue), expected, atol=1e-12)


def test_curvature_of_points_that_coincide_is_unknown() -> None:
    a, b = np.zeros((1, 2)), np.ones((1, 2))
    assert np.isnan(menger_curvature(a, a, b)).all()


def test_speed_of_a_line_is_its_slope() -> None:
    np.testing.assert_allclose(speeds(line(100)), 100 * np.sqrt(3), rtol=1e-9)  # 1 mm per 10 ms and axis
    assert np.isnan(speeds(line(1))).all()
    swing = speeds(wave(5.0))[50:-50]
    assert swing.max() == pytest.approx(2 * np.pi * 5 * np.sqrt(3), rel=0.01)


def test_the_envelope_of_a_box() -> None:
    rng = np.random.default_rng(0)
    corners = np.array([[x, y, z] for x in (0, 2) for y in (0, 3) for z in (0, 5)], float)
    inside = rng.uniform(0, 1, (100, 3)) * (2, 3, 5)
    found = envelope(np.concatenate([corners, inside, np.full((1, 3), np.nan)]))
    assert found.reach == (2.0, 3.0, 5.0)
    assert found.areas == pytest.approx({"front": 15, "side": 10, "top": 6})
    assert len(found.outlines["top"]) == 4
    nothing = envelope(np.full((2, 3), np.nan))
    assert nothing.reach == (0.0, 0.0, 0.0)
    assert nothing.areas["top"] == 0


def test_hulls_turn_left_and_leave_no_point_outside() -> None:
    points = np.random.default_rng(1).normal(size=(200, 2))
    hull = convex_hull(points)
    sides = np.roll(hull, -1, axis=0) - hull
    away = points[:, None] - hull
    assert (sides[:, 0] * away[..., 1] - sides[:, 1] * away[..., 0] > -1e-12).all()
    assert polygon_area(np.array([[0, 0], [4, 0], [0, 3]], float)) == 6


def test_phones_and_pairs_without_silence() -> None:
    track = track_of("sil 0.2 m 0.1 aa 0.2 sil 0.2 t 0.1 s 0.1 iy 0.1")
    assert [(p.name, p.kind) for p in phone_stretches(track)] == [
        ("m", "C"), ("aa", "V"), ("t", "C"), ("s", "C"), ("iy", "V"),
    ]  # fmt: skip
    pairs = diphone_stretches(track)
    assert [(p.name, p.kind) for p in pairs] == [("m aa", "CV"), ("t s", "CC"), ("s iy", "CV")]
    assert (pairs[0].start, pairs[0].end) == pytest.approx((0.25, 0.4))


def test_stretches_take_peaks_of_speeds_and_means_of_shapes() -> None:
    found = {"speed_TT": np.arange(10.0), "width": np.arange(10.0)}
    still = samples.still((0, 0, 0), names="TT")
    values = measure_stretch(Stretch("m", "C", 0.02, 0.06), found, still)
    assert values == {"speed_TT": 5.0, "width": 3.5}  # samples 2, 3, 4, 5
    assert np.isnan(measure_stretch(Stretch("m", "C", 0.2, 0.3), found, still)["width"])
    found["width"][3] = np.nan
    assert np.isnan(measure_stretch(Stretch("m", "C", 0.02, 0.06), found, still)["width"])


def test_statistics_by_name() -> None:
    pair, other = Stretch("t s", "CC", 0, 1), Stretch("m aa", "CV", 0, 1)
    examples = [
        (pair, {"width": 1.0}),
        (other, {"width": 9.0}),
        (pair, {"width": 3.0}),
        (pair, {"width": np.nan}),
    ]
    first, second = summarize_examples(examples)
    assert (first.name, first.examples, first.means["width"]) == ("m aa", 1, 9.0)
    assert np.isnan(first.deviations["width"])
    assert (second.examples, second.means["width"]) == (3, 2.0)
    assert second.deviations["width"] == pytest.approx(np.sqrt(2))
    assert [row.name for row in summarize_examples(examples, least=2)] == ["t s"]


def test_sides_follow_the_middle_or_do_not() -> None:
    t = np.linspace(0, 1, 100)
    tip = np.stack([t, np.sin(9 * t), t**2], axis=1)
    side = np.stack([2 * t, -np.sin(9 * t), np.full(100, 3.0)], axis=1)
    both = Articulation(("TT", "BL"), np.stack([tip, side], axis=1), 100.0)
    found = side_sums(Stretch("t s", "CC", 0, 1), both)
    assert set(found) == {("TT", "BL", letter) for letter in "xyz"}
    assert float(pearson(found["TT", "BL", "x"])) == pytest.approx(1)
    assert float(pearson(found["TT", "BL", "y"])) == pytest.approx(-1)
    assert np.isnan(pearson(found["TT", "BL", "z"]))
    assert side_sums(Stretch("t s", "CC", 0, 1), samples.still((0, 0, 0), names="TT")) == {}
