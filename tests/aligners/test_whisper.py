from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from phonanim.aligners import whisper
from phonanim.aligners._windows import cut
from phonanim.aligners.pocketsphinx import split_words
from phonanim.aligners.whisper import can_recognize, recognize, recognize_words
from phonanim.errors import AudioError, MissingExtraError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import Sound, read_sound, resample


@pytest.fixture(scope="module", autouse=True)
def extra() -> None:
    if not can_recognize():
        pytest.skip("needs the extra recognize")


def test_words_of_a_reader(shared_data: Path) -> None:
    path = shared_data / "textgrids" / "002_en_LJ006-0114.wav"
    recognized = recognize(read_sound(path), str(path))
    assert recognized.text == (
        "They bought their offices from one another and were thus considered "
        "to have a vested interest in them."
    )
    assert recognized.confidence > 0.9


def test_a_long_recording_is_cut_where_it_is_quiet() -> None:
    samples = np.random.default_rng(0).normal(0, 0.1, 70 * 16000).astype(np.float32)
    for silent in (24, 51):
        samples[silent * 16000 : (silent + 1) * 16000] = 0
    blocks = [samples[n : n + 50_000] for n in range(0, len(samples), 50_000)]
    (a, one), (b, two), (c, three) = cut(blocks, 16000)
    np.testing.assert_array_equal(np.concatenate([one.samples, two.samples, three.samples]), samples)
    assert a == 0
    assert 24 <= b <= 25
    assert 51 <= c <= 52
    assert b == one.duration


def test_words_are_recognized_with_their_times(shared_data: Path) -> None:
    path = shared_data / "textgrids" / "002_en_LJ006-0114.wav"
    sound = read_sound(path)
    words = recognize_words(resample(sound.samples, sound.rate, 16000))
    grid = read_alignment(path.with_suffix(".TextGrid"))
    labels = [word for word in grid.words if word.label]
    assert [split_words(word.text)[0] for word in words] == [word.label.lower() for word in labels]
    errors = np.subtract([word.start for word in words], [word.start for word in labels])
    assert np.abs(errors).max() < 0.3
    assert all(0.2 < word.probability <= 1 for word in words)
    assert recognize_words(np.zeros(16000, np.float32)) == []


def test_silence_has_no_words() -> None:
    with pytest.raises(AudioError, match=r"a\.wav: no English speech is recognized"):
        recognize(Sound(np.zeros(32000, np.float32), 16000), "a.wav")


def test_bytes_of_tokens() -> None:
    assert whisper._text(["\u0120caf", "\u00c3\u00a9", "<|endoftext|>"]) == "caf\u00e9"


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    whisper._model.cache_clear()
    monkeypatch.setattr(whisper, "can_recognize", lambda: False)
    with pytest.raises(MissingExtraError, match=r"phonanim\[recognize\]"):
        recognize(Sound(np.zeros(16000, np.float32), 16000), "a.wav")
