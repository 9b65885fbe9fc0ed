import numpy as np
import pytest
from prosodies import sentences, track_of

from phonanim.media.voice import analyze_voice
from phonanim.speech.alignment import Interval
from phonanim.speech.prosody import eased, measure_prosody, read_prosody, stress


def line(*parts):
    """Phones one after another, (label, seconds) each; no label is silence."""
    time, found = 0.0, []
    for label, seconds in parts:
        if label:
            found.append(Interval(label, time, time + seconds))
        time += seconds
    return track_of(tuple(found), time)


def test_phrases_lie_between_pauses_of_a_fifth_of_a_second():
    track = line(("", 0.5), ("AA1", 0.2), ("", 0.1), ("M", 0.1), ("", 0.3), ("IY1", 0.2), ("", 0.5))
    prosody = read_prosody(track)
    np.testing.assert_allclose(prosody.starts, [0.5, 1.2])
    np.testing.assert_allclose(prosody.ends, [0.9, 1.4])
    np.testing.assert_allclose(prosody.pauses(), [0.5, 0.3])


def test_marked_stress_is_an_accent_and_unmarked_is_none():
    track = line(("B", 0.1), ("AH0", 0.15), ("N", 0.1), ("AE1", 0.18), ("N", 0.3), ("AH2", 0.12))
    prosody = read_prosody(track)
    np.testing.assert_allclose(prosody.accents, [0.44, 0.89])
    assert prosody.strengths[0] == 1.0
    assert 0.3 < prosody.strengths[1] < 0.6


def test_without_marks_long_vowels_are_accented():
    track = line(("M", 0.1), ("AA", 0.06), ("T", 0.4), ("AA", 0.2), ("T", 0.1))
    np.testing.assert_allclose(read_prosody(track).accents, [0.66])


def test_a_weaker_accent_close_behind_is_none():
    track = line(("AA1", 0.18), ("T", 0.1), ("AA2", 0.15), ("T", 0.5), ("AA2", 0.15))
    np.testing.assert_allclose(read_prosody(track).accents, [0.09, 1.005])


@pytest.mark.parametrize(
    ("label", "value"), [("AA1", 1.0), ("AA2_B", 0.5), ("AA0", 0.0), ("ˈaː", 1.0), ("ˌe", 0.5), ('"a', 1.0)]
)
def test_marks_of_stress(label, value):
    assert stress(label) == value


def test_other_labels_mark_no_stress():
    assert np.isnan(stress("aː"))
    assert np.isnan(stress("AA"))


def test_words_with_a_question_mark_end_a_question():
    words = (Interval("is", 0.0, 0.2), Interval('it?"', 0.2, 0.5), Interval("no.", 0.6, 0.8))
    assert read_prosody(line(("IH1", 1.0)), words).questions.tolist() == [[0.2, 0.5]]


def test_an_event_waits_until_it_is_known_so_far_ahead():
    track = line(("", 0.5), ("AA1", 0.2), ("M", 0.8), ("", 1.0))
    prosody = read_prosody(track, ahead=0.1)
    assert prosody.starts_from[0] == pytest.approx(0.6)  # the first phone ends at 0.7
    assert prosody.accents_from[0] == pytest.approx(0.6)
    assert prosody.long_from[0] == pytest.approx(1.4)
    assert prosody.ends_from[0] == pytest.approx(1.6)  # 0.2 s of silence make the end of a phrase


def test_what_goes_on_has_no_end():
    prosody = read_prosody(line(("AA1", 0.2), ("", 0.1)), ahead=0.1, ended=False)
    assert prosody.ends[0] == prosody.ends_from[0] == prosody.duration == np.inf
    assert read_prosody(line(("AA1", 0.2), ("", 0.3)), ahead=0.1, ended=False).ends[0] == pytest.approx(0.2)


def test_nobody_speaks_before_and_after_phrases():
    prosody = read_prosody(line(("", 2.0), ("AA1", 0.5), ("", 3.0)), ahead=0.0)
    times = np.array([0.0, 1.9, 2.9, 5.0])
    speaking = prosody.speaking(times)
    assert speaking[[0, 1, 3]].tolist() == [0, 0, 0]
    assert 0.0 < speaking[2] < 1.0


def test_silence_has_no_event():
    prosody = read_prosody(line(("", 2.0)))
    assert len(prosody.starts) == len(prosody.accents) == len(prosody.pauses()) == 0
    assert prosody.speaking(np.arange(5.0)).tolist() == [0, 0, 0, 0, 0]


def test_pitch_makes_accents_stronger():
    track = line(("AA1", 0.15), ("M", 0.5), ("AA1", 0.15), ("M", 0.2))
    times = np.arange(16000) / 16000
    pitch = np.where(times < 0.5, 100.0, 150.0)
    voice = analyze_voice(np.sign(np.sin(2 * np.pi * np.cumsum(pitch) / 16000)).astype(np.float32), 16000)
    plain, with_voice = read_prosody(track), read_prosody(track, voice=voice)
    assert with_voice.strengths[1] > plain.strengths[1] > with_voice.strengths[0]


def test_a_recording_alone_has_phrases_and_accents():
    rate, seconds = 16000, 4.0
    times = np.arange(int(rate * seconds)) / rate
    spoken = ((times > 0.5) & (times < 1.5)) | ((times > 2.0) & (times < 3.0))
    syllables = 0.2 * (1 + np.sin(2 * np.pi * 4 * times)) * spoken
    samples = (syllables * np.sign(np.sin(2 * np.pi * 120 * times))).astype(np.float32)
    prosody = measure_prosody(analyze_voice(samples, rate), ahead=0.1)
    np.testing.assert_allclose(prosody.starts, [0.5, 2.0], atol=0.06)
    np.testing.assert_allclose(prosody.ends, [1.5, 3.0], atol=0.1)
    assert len(prosody.accents) >= 4
    assert (prosody.accents_from >= prosody.accents).all()
    assert prosody.duration == pytest.approx(4.0)


def test_soft_ends():
    np.testing.assert_allclose(eased(np.array([-1.0, 0.0, 0.5, 1.0, 2.0])), [0, 0, 0.5, 1, 1])


def test_long_lines_have_as_many_phrases_as_sentences():
    prosody = read_prosody(track_of(sentences(60), 60.0 + 10))
    assert len(prosody.starts) == len(prosody.ends) > 8
    assert (prosody.ends > prosody.starts).all()
