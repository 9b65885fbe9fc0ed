from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("espeakng_loader", reason="needs the extra espeak")

from phonanim.aligners.espeak import MARGIN, speak, write_speech
from phonanim.aligners.warping import align_by_speech, warp
from phonanim.errors import AlignmentError, AudioError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import Sound, read_sound

TEXT = "My father watched Bob move a cheap blue lamp from the wash room."


def onsets(intervals: tuple) -> np.ndarray:
    return np.array([interval.start for interval in intervals])


@pytest.fixture(scope="module")
def slow_speaker(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    """Another voice in noise, with a second of silence after the fifth word; and the onsets of its words."""
    spoken = speak(TEXT, "en-gb")
    rng = np.random.default_rng(2)
    cut = round(spoken.words[5].start * spoken.rate)
    pause = np.zeros(spoken.rate)
    samples = np.concatenate([spoken.samples[:cut], pause, spoken.samples[cut:]])
    noisy = samples + rng.normal(0, 60, len(samples))
    path = tmp_path_factory.mktemp("slow") / "slow.wav"
    made = type(spoken)(noisy.astype(np.int16), spoken.rate, spoken.words, spoken.phones)
    write_speech(path, made)
    return path, onsets(spoken.words) + np.where(np.arange(len(spoken.words)) >= 5, 1.0, 0.0)


def test_words_of_another_voice_with_a_pause(slow_speaker: tuple[Path, np.ndarray]) -> None:
    path, expected = slow_speaker
    found = align_by_speech(path, TEXT, "en-us")
    assert " ".join(word.label for word in found.words) == TEXT.rstrip(".")
    errors = np.abs(onsets(found.words) - expected)
    assert np.median(errors) < 0.03
    assert errors.max() < 0.12
    assert found.notes == ()


def test_phones_are_in_order_and_in_the_recording(slow_speaker: tuple[Path, np.ndarray]) -> None:
    found = align_by_speech(slow_speaker[0], TEXT, "en-us")
    bounds = np.array([(phone.start, phone.end) for phone in found.phones])
    assert (bounds[:, 1] > bounds[:, 0]).all()
    assert (bounds[1:, 0] >= bounds[:-1, 1] - 1e-9).all()
    assert bounds[0, 0] > MARGIN / 2
    assert bounds[-1, 1] <= found.duration


def test_another_text_is_doubted(slow_speaker: tuple[Path, np.ndarray]) -> None:
    other = "Nobody knows where those seven green bottles on their shelf were going this evening."
    assert "hardly matches the text" in align_by_speech(slow_speaker[0], other, "en-us").notes[0]


def test_what_cannot_be_aligned(tmp_path: Path, slow_speaker: tuple[Path, np.ndarray]) -> None:
    with pytest.raises(AudioError, match="no speech"):
        warp(Sound(np.zeros(32000, np.float32), 16000), speak("Hello."))
    short = read_sound(slow_speaker[0])
    with pytest.raises(AlignmentError, match="much too short for the text"):
        warp(Sound(short.samples[:8000], short.rate), speak(TEXT))
    long = tmp_path / "long.wav"
    spoken = speak("Hello.")
    write_speech(long, type(spoken)(np.zeros(121 * spoken.rate, np.int16), spoken.rate, (), ()))
    with pytest.raises(AlignmentError, match=r"long\.wav: lasts 121 s; at most 120 s"):
        align_by_speech(long, "Hello.", "en")


def test_german_speech_with_labels_by_hand(shared_data: Path) -> None:
    stem = shared_data / "ema_de" / "dfgspp_mo1_prosody_0020"
    reference = read_alignment(stem.with_name(f"{stem.name}_bndl.json"))
    expected = onsets(tuple(i for i in reference.intervals if not i.label.startswith("&")))
    found = align_by_speech(stem.with_suffix(".wav"), "Sie arbeitet in einer Kneipe als Kellnerin.", "de")
    assert len(found.phones) == len(expected)
    errors = np.abs(onsets(found.phones) - expected)
    assert np.median(errors) < 0.03
    assert np.percentile(errors, 90) < 0.06
