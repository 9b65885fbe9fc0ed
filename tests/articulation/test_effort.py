"""Stress, rate, loudness and held vowels as gains around 1."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from speech import track_of

from phonanim.articulation.effort import (
    PER_DECIBEL,
    STRESSED,
    USUAL,
    effort_gains,
    held_variation,
    stress_curve,
    syllable_rate,
    vowel_stress,
)
from phonanim.speech.phones import PhoneTrack

STEADY = "sil 0.3 " + "t 0.119 aa 0.119 " * 8 + "sil 0.3"  # 4.2 syllables a second


def times_of(track: PhoneTrack) -> np.ndarray:
    return np.arange(0, track.duration, 1 / 60)


def labelled(text: str, *labels: str) -> PhoneTrack:
    return replace(track_of(text), labels=labels)


def test_usual_speech_is_as_it_was() -> None:
    track = track_of(STEADY)
    gains = effort_gains(track, np.arange(0.5, 1.9, 1 / 60))
    assert set(gains) == {"jaw", "lip_gap", "upper_lip"}
    for gain in gains.values():
        np.testing.assert_allclose(gain, 1.0, atol=0.01)


def test_stressed_vowels_open_more_and_unstressed_ones_less() -> None:
    track = labelled("sil 0.2 t 0.1 aa 0.2 t 0.1 aa 0.2 sil 0.2", "", "T", "AA1", "T", "AA0", "")
    gain = effort_gains(track, np.array([0.4, 0.7]))["lip_gap"]
    assert gain[0] / gain[1] == pytest.approx((1 + STRESSED) / (1 - STRESSED), rel=0.03)
    assert stress_curve(track, np.array([0.4, 0.7])) == pytest.approx([1, -1], abs=0.05)
    even = effort_gains(track, np.array([0.4, 0.7]), reduction=0.0)["lip_gap"]
    assert even[0] == even[1] == 1.0


@pytest.mark.parametrize(
    ("labels", "stresses"),
    [
        (("", "ˈt", "ɑ", "t", "i", ""), (1.0, np.nan)),  # the mark is on the consonant of its syllable
        (("", "t", "ˈɑ", "t", "ˌi", ""), (1.0, 0.5)),
        (("", "ˈt", "ɑː", "ˌt", "i", ""), (1.0, 0.5)),
        (("", "T", "AA2", "T", "IY0", ""), (0.5, 0.0)),
    ],
)
def test_marks_of_stress_reach_their_vowels(labels: tuple[str, ...], stresses: tuple[float, float]) -> None:
    track = labelled("sil 0.2 t 0.1 aa 0.2 t 0.1 iy 0.2 sil 0.2", *labels)
    found = vowel_stress(track)
    np.testing.assert_array_equal(found[[2, 4]], stresses)
    assert np.isnan(found[[0, 1, 3, 5]]).all()


def test_a_mark_does_not_reach_over_a_pause() -> None:
    track = labelled("t 0.1 sil 0.1 aa 0.2", "ˈt", "", "ɑ")
    assert np.isnan(vowel_stress(track)).all()


def test_without_marks_there_is_no_stress() -> None:
    track = track_of(STEADY)
    assert not stress_curve(track, times_of(track)).any()


def test_fast_speech_takes_more_from_the_jaw() -> None:
    slow, fast = track_of(STEADY), track_of("sil 0.3 " + "t 0.06 aa 0.06 " * 16 + "sil 0.3")
    assert syllable_rate(slow, np.array([1.2]))[0] == pytest.approx(USUAL, rel=0.02)
    assert syllable_rate(fast, np.array([1.2]))[0] == pytest.approx(1 / 0.12, rel=0.1)
    gains = effort_gains(fast, np.array([1.2]))
    assert 0.85 < gains["jaw"][0] < gains["lip_gap"][0] < 1.0


def test_pauses_have_no_rate_of_their_own() -> None:
    track = track_of("sil 5 t 0.06 aa 0.06 sil 5")
    rate = syllable_rate(track, times_of(track))
    assert rate[0] == rate[-1] == USUAL
    assert np.abs(np.diff(rate)).max() < 0.3


def test_louder_is_larger_but_lips_stand_out_no_further() -> None:
    track = track_of(STEADY)
    times = times_of(track)
    gains = effort_gains(track, times, reduction=0.0, decibels=np.full(len(times), 5.0))
    np.testing.assert_allclose(gains["jaw"], 1 + 5 * PER_DECIBEL)
    assert "protrusion" not in gains
    assert "lip_width" not in gains


def test_held_vowels_vary_slowly() -> None:
    track = track_of("sil 0.3 m 0.1 aa 2.5 m 0.1 aa 0.3 sil 0.3")
    times = times_of(track)
    varied = held_variation(track, times)
    inside = (times > 0.9) & (times < 2.4)
    assert np.ptp(varied[inside]) > 0.08
    assert np.abs(np.diff(varied)).max() * 60 < 1.0  # a second
    assert not varied[(times < 0.4) | (times > 2.9)].any()
    np.testing.assert_allclose(
        effort_gains(track, times, reduction=0.0, hold=2.0)["jaw"], 1 + 2 * varied, atol=1e-12
    )


def test_any_part_of_a_line_can_be_made_alone() -> None:
    track = labelled(
        "sil 0.2 t 0.1 aa 0.9 t 0.1 iy 0.2 s 0.1 uw 0.3 sil 0.2",
        *["_", "T", "AA1", "T", "IY0", "S", "UW1", "_"],
    )
    times = times_of(track)
    whole, part = effort_gains(track, times), effort_gains(track, times[20:50])
    for name, gain in part.items():
        np.testing.assert_array_equal(gain, whole[name][20:50])
