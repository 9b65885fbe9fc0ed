"""Each behaviour against what is published of it."""

import numpy as np
import pytest
from prosodies import sentences, track_of

from phonanim.life import AHEAD, blinks, brows, gaze, head
from phonanim.speech.alignment import Interval
from phonanim.speech.prosody import read_prosody

MINUTES = 10
SECONDS = 60.0 * MINUTES
PROSODY = read_prosody(track_of(sentences(SECONDS - 10), SECONDS), ahead=AHEAD)
SILENCE = read_prosody(track_of((), SECONDS), ahead=AHEAD)
TIMES = np.arange(int(SECONDS * 60)) / 60
NO_SHIFTS = (np.zeros(0), np.zeros(0))


def starts(seed, prosody):
    return blinks.blink_starts(seed, prosody, 0.0, SECONDS, NO_SHIFTS)


def test_people_blink_more_in_talking_than_at_rest():
    talking = np.mean([len(starts(seed, PROSODY)) for seed in range(8)]) / MINUTES
    resting = np.mean([len(starts(seed, SILENCE)) for seed in range(8)]) / MINUTES
    assert 20 < talking < 28
    assert resting == pytest.approx(17, abs=1.5)


def test_gaps_between_blinks_have_a_long_tail():
    gaps = np.concatenate([np.diff(starts(seed, SILENCE)) for seed in range(8)])
    assert gaps.min() > 0.5
    assert gaps.mean() > 1.1 * np.median(gaps)


def test_blinks_fall_on_the_ends_of_phrases():
    begun = starts(1, PROSODY)
    near = [np.abs(begun - end).min() < 0.15 for end in PROSODY.ends]
    assert np.mean(near) > 0.4


def test_lids_close_fully_and_faster_than_they_open():
    closed = blinks.closed(1, PROSODY, TIMES, NO_SHIFTS)
    assert closed.max() == 1.0
    assert closed.min() == 0.0
    speed = np.diff(closed)
    assert speed.max() > -1.5 * speed.min() > 0


def test_large_shifts_of_gaze_bring_blinks():
    shifts = (np.arange(5.0, 595.0, 5.0), np.full(118, 25.0))
    more = len(blinks.blink_starts(1, SILENCE, 0.0, SECONDS, shifts))
    assert more > len(starts(1, SILENCE)) + 40


def test_a_far_look_and_back_does_not_make_the_lids_flutter():
    onsets = np.arange(1.0, 100.0, 0.4)
    found = blinks.blink_starts(2, SILENCE, 0.0, 100.0, (onsets, np.full(len(onsets), 25.0)))
    assert len(found) > 20
    assert np.diff(found).min() >= 0.6 - 1e-9


@pytest.mark.parametrize("degrees", [1.0, 5.0, 10.0, 20.0])
def test_saccades_lie_on_the_main_sequence(degrees):
    onsets, targets = np.array([0.0, 1.0]), np.array([[0.0, 0.0], [degrees, 0.0]])
    times = np.arange(0.9, 1.3, 1e-4)
    speed = np.diff(gaze._jumps(onsets, targets, times)[:, 0]) / 1e-4
    lowest, highest = {1.0: (30, 90), 5.0: (200, 330), 10.0: (330, 480), 20.0: (450, 600)}[degrees]
    assert lowest < speed.max() < highest
    assert (speed > 0).sum() * 1e-4 == pytest.approx(0.021 + 0.0022 * degrees, abs=3e-4)


def test_speakers_look_at_the_listener_most_of_the_time():
    begins, ends = gaze.looks_away(1, PROSODY, 0.0, SECONDS)
    assert (ends > begins).all()
    assert (begins[1:] > ends[:-1]).all()
    assert 0.08 < (ends - begins).sum() / SECONDS < 0.3
    quiet = gaze.looks_away(1, SILENCE, 0.0, SECONDS)
    assert (quiet[1] - quiet[0]).sum() < 0.6 * (ends - begins).sum()


def test_speakers_look_away_as_utterances_begin_and_back_as_they_end():
    begins, ends = gaze.looks_away(1, PROSODY, 0.0, SECONDS)
    long = PROSODY.starts[PROSODY.pauses() >= gaze.BEFORE]
    away = [((begins <= start + 0.3) & (ends > start + 0.3)).any() for start in long]
    back = [not ((begins < end) & (ends > end + gaze.LEAST)).any() for end in PROSODY.ends]
    assert np.mean(away) > 0.4
    assert all(back)


def test_the_eyes_stay_within_their_range():
    look = gaze.look(1, PROSODY, TIMES)
    assert np.abs(look.left).max() < 24
    assert np.abs(look.up).max() < 18
    moved = look.sizes[look.sizes > 0.5]
    assert 3 < np.median(moved) < 8


def test_heads_move_little_and_nod_at_accents():
    look = gaze.look(1, PROSODY, TIMES)
    turned = head.turn(1, PROSODY, TIMES, (look.onsets, look.places), (0.0, 0.0))
    for axis in (turned.pitch, turned.yaw, turned.roll):
        assert 0.4 < axis.std() < 3
        assert np.abs(axis).max() < 9
    rows = np.rint((PROSODY.accents + 0.05) * 60).astype(int)
    assert turned.pitch[rows].mean() > turned.pitch.mean() + 0.3


def test_the_head_goes_from_posture_to_posture_without_a_jump():
    """Phrases that follow each other fast, so that postures to either side overlap."""
    words = [(1.0 * n, 1.0 * n + 0.7) for n in range(60)]
    prosody = read_prosody(track_of(tuple(Interval("AA1", a, b) for a, b in words), 61.0))
    times = np.arange(61 * 60) / 60
    turned = head.turn(4, prosody, times, (np.zeros(0), np.zeros((0, 2))), (0.0, 0.0))
    assert np.ptp(turned.roll) > 2
    for axis in (turned.pitch, turned.yaw, turned.roll):
        assert np.abs(np.diff(axis)).max() * 60 < 40


def test_brows_do_not_rise_again_at_once():
    for seed in range(3):
        up = brows.curves(seed, PROSODY, TIMES)[0] > 0.15
        onsets = TIMES[1:][up[1:] & ~up[:-1]]
        assert len(onsets) > 20
        assert np.diff(onsets).min() > 0.8


def test_brows_rise_at_few_accents_and_at_questions():
    raised = brows.curves(1, PROSODY, TIMES)[0]
    lowered = brows.curves(1, PROSODY, TIMES)[1]
    risen = np.flatnonzero((raised[1:] > 0.1) & (raised[:-1] <= 0.1))
    assert 4 < len(risen) / MINUTES < 18
    assert raised.max() < 0.4
    assert 0 < lowered.max() < 0.2
    asked = read_prosody(track_of((), 5.0), (_question(),))
    rising = brows.curves(1, asked, np.array([0.5, 2.2, 4.0]))[0]
    assert rising[1] == pytest.approx(brows.QUESTION)
    assert rising[[0, 2]].max() < 0.1


def _question():
    from phonanim.speech.alignment import Interval

    return Interval("there?", 2.0, 2.5)
