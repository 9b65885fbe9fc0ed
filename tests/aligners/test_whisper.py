from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from phonanim.aligners import whisper
from phonanim.aligners.whisper import can_recognize, recognize
from phonanim.errors import AudioError, MissingExtraError
from phonanim.media.audio import Sound, read_sound


@pytest.fixture(scope="module", autouse=True)
def extra() -> None:
    if not can_recognize():
        pytest.skip("needs the extra recognize")


def test_words_of_a_reader(shared_data: Path) -> None:
    path = shared_data / "textgrids" / "002_en_LJ006-0114.wav"
    heard = recognize(read_sound(path), str(path))
    assert heard.text == (
        "They bought their offices from one another and were thus considered "
        "to have a vested interest in them."
    )
    assert heard.confidence > 0.9


def test_a_long_recording_is_cut_where_it_is_quiet() -> None:
    samples = np.random.default_rng(0).normal(0, 0.1, 70 * 16000).astype(np.float32)
    for silent in (24, 51):
        samples[silent * 16000 : (silent + 1) * 16000] = 0
    (a, b), (c, d), (e, f) = whisper.quiet_windows(samples)
    assert (a, f) == (0, len(samples))
    assert (b, d) == (c, e)
    assert 24 <= b / 16000 <= 25
    assert 51 <= d / 16000 <= 52


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
