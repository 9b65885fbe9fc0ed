import sys
from itertools import pairwise

import numpy as np
import pytest

from phonanim.aligners.pocketsphinx import align, split_words, strip_variant_number
from phonanim.errors import AlignmentError, AudioError, MissingExtraError, OptionError

TEXT = "My father watched Bob move a cheap blue lamp from the wash room."


@pytest.fixture
def pocketsphinx():
    return pytest.importorskip("pocketsphinx")


@pytest.fixture
def line(root):
    return root / "examples" / "line.wav"


def test_words_without_punctuation():
    assert split_words("Don't go -- it’s «three», Bob!") == ["don't", "go", "it's", "three", "bob"]
    assert split_words("... --") == []


def test_pronunciation_numbers_are_taken_off():
    assert [strip_variant_number(entry) for entry in ("the(2)", "a", "read(12)")] == ["the", "a", "read"]


def test_the_example_is_what_the_aligner_finds(line, pocketsphinx):
    from phonanim.inputs.alignment import read_alignment

    found = align(line, TEXT)
    kept = read_alignment(line.with_suffix(".TextGrid"))
    spoken = [interval for interval in kept.intervals if interval.label]
    assert [phone.label for phone in found.phones] == [interval.label for interval in spoken]
    starts = [phone.start for phone in found.phones], [interval.start for interval in spoken]
    np.testing.assert_allclose(*starts, atol=0.02)


def test_the_laws_of_an_alignment(line, pocketsphinx):
    found = align(line, TEXT)
    assert [word.label for word in found.words] == split_words(TEXT)
    for tier in (found.words, found.phones):
        assert all(part.start < part.end for part in tier)
        assert all(before.end <= after.start + 1e-9 for before, after in pairwise(tier))
        assert tier[-1].end <= found.duration
    assert found.phones[0].start == found.words[0].start
    assert found.phones[-1].end == found.words[-1].end


def test_without_text_the_words_are_recognized(line, pocketsphinx):
    found = align(line)
    recognized = {word.label for word in found.words}
    assert {"my", "father"} <= recognized  # a synthetic voice is hard to recognize


def test_noises_are_no_words(shared_data, pocketsphinx):
    """In this recording the recognizer finds speech that is no word, which is not a phone either."""
    found = align(shared_data / "textgrids/061_en_damon_set_test.wav")
    assert [word.label for word in found.words] == ["damon", "said"]
    assert not [phone.label for phone in found.phones if not phone.label.isalpha()]


def test_words_that_the_dictionary_lacks_are_pronounced(line, pocketsphinx):
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    found = align(line, TEXT.replace("blue", "bloough"))
    assert "bloough" in [word.label for word in found.words]
    (note,) = found.notes
    assert note.startswith("not in the pronouncing dictionary, so pronounced by eSpeak NG: 'bloough' (")


def test_words_that_the_dictionary_lacks(line, pocketsphinx, monkeypatch):
    monkeypatch.setattr("phonanim.aligners.pocketsphinx.can_speak", lambda: False)
    with pytest.raises(OptionError, match="dictionary: 'grzegorz', '42'; spell numbers out"):
        align(line, "my father grzegorz watched 42")


def test_no_words(line, pocketsphinx):
    with pytest.raises(OptionError, match="the text has no words; give the words of the recording"):
        align(line, "...")


def test_a_text_that_is_not_said_is_doubted(shared_data, pocketsphinx):
    recording = shared_data / "textgrids" / "002_en_LJ006-0114.wav"
    other = align(recording, "seven green bottles hang on the old garden wall tonight")
    assert other.notes == (
        "the recording hardly matches the text: its phones do not fit the sound; check the text",
    )


def test_another_text(line, pocketsphinx):
    with pytest.raises(AlignmentError, match=r"line.wav: the text cannot be found in the audio"):
        align(line, "yes " * 400)


def test_no_recording(tmp_path, pocketsphinx):
    with pytest.raises(AudioError, match=r"a.wav: cannot be read: No such file"):
        align(tmp_path / "a.wav", TEXT)


def test_the_extra_is_named(line, monkeypatch):
    monkeypatch.setitem(sys.modules, "pocketsphinx", None)
    with pytest.raises(MissingExtraError, match=r"aligning speech needs pip install 'phonanim\[align\]'"):
        align(line, TEXT)


def test_fillers_of_a_single_frame(shared_data, pocketsphinx):
    """Here the best path through the lattice begins with a silence too short to be aligned."""
    found = align(shared_data / "grid_s1/audio/bbwg3a.flac", "bin blue with g three again")
    assert [word.label for word in found.words] == ["bin", "blue", "with", "g", "three", "again"]
