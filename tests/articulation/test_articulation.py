"""Phones become millimetres of jaw, lips and tongue: closed when they must be, the same in any chunks."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from speech import random_track, track_of

from phonanim.articulation import CHANNELS, Articulation, articulate
from phonanim.articulation.channels import Array
from phonanim.articulation.table import CHANNELS_FILE, TARGETS_FILE, read_targets
from phonanim.articulation.trajectories import ROUNDED, reach
from phonanim.errors import ModelError
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.phones import PhoneTrack

LINE = "sil 0.4 p 0.03 aa 0.15 m 0.05 iy 0.12 s 0.1 aa 0.15 sh 0.1 uw 0.15 f 0.08 ay 0.3 sil 0.4"


def at_middle(line: str, number: int) -> dict[str, float]:
    """The channels in the middle of segment `number`."""
    track = track_of(line)
    middle = np.array([(track.bounds[number] + track.bounds[number + 1]) / 2])
    return dict(zip(CHANNELS, articulate(track, middle).values[0], strict=True))


def test_silence_is_a_closed_mouth_at_rest() -> None:
    values = articulate(track_of("sil 1.0"), np.array([-5.0, 0.0, 0.5, 1.0, 9.0])).values
    assert (values == values[0]).all()
    assert articulate(track_of(LINE), np.array([0.0])).values[0] == pytest.approx(values[0])
    rest = dict(zip(CHANNELS, values[0], strict=True))
    assert rest["lip_gap"] <= 0
    assert rest["lip_width"] == rest["protrusion"] == rest["tongue_tip_height"] == 0


@pytest.mark.parametrize("fps", [24, 25, 29.97, 60, 240])
@pytest.mark.parametrize("phone", ["p", "b", "m"])
@pytest.mark.parametrize("length", [0.02, 0.05, 0.12])
def test_lips_touch_in_every_bilabial(phone: str, length: float, fps: float) -> None:
    track = track_of(f"sil 0.3 aa 0.2 {phone} {length} ae 0.2 sil 0.3")
    gap = articulate(track, np.arange(round(fps)) / fps).channel("lip_gap")
    assert gap.min() <= 0


def test_the_lower_lip_meets_the_teeth() -> None:
    assert at_middle("aa 0.2 f 0.05 aa 0.2", 1)["lower_lip_to_teeth"] <= 0.5
    assert at_middle("aa 0.2 v 0.03 aa 0.2", 1)["lower_lip_to_teeth"] <= 0.5


def test_contacts_can_be_left_out() -> None:
    track, times = track_of("aa 0.2 p 0.02 aa 0.2"), np.array([0.21])
    assert articulate(track, times, contacts=False).channel("lip_gap")[0] > 1
    assert articulate(track, times).channel("lip_gap")[0] <= 0


def test_vowels_open_in_order_of_height_and_sibilants_close_the_jaw() -> None:
    jaw = [at_middle(f"sil 0.3 t 0.08 {phone} 0.15 t 0.08 sil 0.3", 2)["jaw"] for phone in ("iy", "eh", "aa")]
    assert jaw == sorted(jaw)
    assert at_middle("aa 0.15 s 0.1 aa 0.15", 1)["jaw"] < 0.4 * jaw[2]


def test_rounded_vowels_narrow_and_stand_out_early() -> None:
    line = "sil 0.3 iy 0.2 t 0.1 uw 0.2 sil 0.3"
    iy, t, uw = (at_middle(line, number) for number in (1, 2, 3))
    assert uw["lip_width"] < iy["lip_width"] - 7
    assert uw["protrusion"] > iy["protrusion"] + 4
    spread = at_middle("sil 0.3 iy 0.2 t 0.1 iy 0.2 sil 0.3", 2)
    assert t["lip_width"] < spread["lip_width"] - 1


def test_diphthongs_move() -> None:
    track = track_of("sil 0.3 ay 0.3 sil 0.3")
    early, late = articulate(track, np.array([0.36, 0.55])).values
    assert early[CHANNELS.index("jaw")] > late[CHANNELS.index("jaw")] + 2
    assert late[CHANNELS.index("tongue_body_height")] > early[CHANNELS.index("tongue_body_height")] + 2


def test_the_blend_is_its_formula() -> None:
    """One channel, instant by instant, by the slow way with the exact error function."""
    track, targets = track_of(LINE), read_targets()
    parts = split_parts(track)
    gestures = GESTURES.part_gesture[parts.parts]
    bounds = [-math.inf, *parts.bounds[1:-1], math.inf]  # the line begins and ends in silence
    times = np.arange(0.0, track.duration, 0.017)
    for channel in range(len(CHANNELS)):
        sigma, lead = targets.sigma[channel], targets.lead[channel]
        expected = []
        for t in times:
            above = below = 0.0
            for g, begin, end in zip(gestures, bounds, bounds[1:], strict=False):
                earlier = begin - lead * ROUNDED[g]
                k = [math.erf((t - b) / (sigma * math.sqrt(2))) for b in (earlier, end)]
                above += targets.weight[g, channel] * targets.target[g, channel] * (k[0] - k[1])
                below += targets.weight[g, channel] * (k[0] - k[1])
            expected.append(above / below)
        found = articulate(track, times, contacts=False).values[:, channel]
        assert found == pytest.approx(expected, abs=0.01)


def test_chunks_equal_the_whole() -> None:
    track = random_track(np.random.default_rng(3), 200)
    times = np.arange(0, track.duration, 1 / 60)
    whole = articulate(track, times).values
    pieces = [articulate(track, times[start : start + 7]).values for start in range(0, len(times), 7)]
    assert np.array_equal(np.concatenate(pieces), whole)


def test_what_lies_beyond_the_reach_changes_nothing() -> None:
    rng = np.random.default_rng(4)
    track = random_track(rng, 60)
    now, far = track.bounds[30], reach(read_targets())
    codes = track.codes.copy()
    codes[(track.bounds[:-1] > now + far) | (track.bounds[1:] < now - far)] = 1
    other = PhoneTrack(codes, track.bounds, track.labels)
    assert (codes != track.codes).any()
    assert np.array_equal(articulate(track, now[None]).values, articulate(other, now[None]).values)


def test_times_may_be_none() -> None:
    assert articulate(track_of(LINE), np.zeros(0)).values.shape == (0, len(CHANNELS))


def test_an_unknown_channel_is_named() -> None:
    with pytest.raises(KeyError, match=r"no channel nose; there are jaw, lip_gap"):
        Articulation(np.zeros((1, len(CHANNELS)))).channel("nose")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"target": "open"}, "row 2: needs a gesture, a channel, a target and a weight"),
        ({"gesture": "xx"}, "row 2: needs a gesture, a channel, a target and a weight"),
        ({"weight": "0"}, "row 2: the target must be a number, the weight above 0"),
        ({"target": "nan"}, "row 2: needs a gesture, .*target is nan; it is a number from"),
        (None, "has no row for sil, jaw; add it"),
    ],
)
def test_bad_targets_are_told(tmp_path: Path, change: dict[str, str] | None, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read_targets(changed(TARGETS_FILE, tmp_path / "targets.csv", change))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sigma": "wide"}, "row 2: needs a channel, a sigma and a lead"),
        ({"sigma": "0"}, "row 2: the sigma must be above 0 s, the lead not below"),
        ({"lead": "-1"}, "row 2: the sigma must be above 0 s, the lead not below"),
        (None, "has no row for jaw; add it"),
    ],
)
def test_bad_channels_are_told(tmp_path: Path, change: dict[str, str] | None, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        read_targets(TARGETS_FILE, changed(CHANNELS_FILE, tmp_path / "channels.csv", change))


def test_absent_targets_are_told(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"none\.csv: cannot be read"):
        read_targets(tmp_path / "none.csv")


def changed(source: Path, target: Path, change: dict[str, str] | None) -> Path:
    """A copy of a table whose first row is changed, or absent."""
    with source.open(encoding="utf-8", newline="") as file:
        first, *others = list(csv.DictReader(file))
    with target.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(first))
        writer.writeheader()
        writer.writerows(others if change is None else [first | change, *others])
    return target


def test_every_number_has_a_source() -> None:
    for path in (TARGETS_FILE, CHANNELS_FILE):
        with path.open(encoding="utf-8", newline="") as file:
            assert all(row["source"] for row in csv.DictReader(file))


def test_frame_rates_agree_where_instants_fall_together() -> None:
    track = track_of(LINE)
    slow, fast = (articulate(track, np.arange(round(fps * 2)) / fps).values for fps in (25, 100))
    assert slow == pytest.approx(fast[::4], abs=1e-9)


def values_of(track: PhoneTrack) -> Array:
    return articulate(track, np.arange(0, track.duration, 0.01)).values


def test_the_line_can_be_shifted() -> None:
    track = track_of(LINE)
    later = PhoneTrack(track.codes, np.append(0.0, track.bounds[1:] + 0.5), track.labels)
    assert values_of(later)[50:] == pytest.approx(values_of(track), abs=1e-6)
