"""Phones that are recognized in sound: alike in pieces and whole, mostly right, else refused."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from phonanim.core.catalog import RECOGNITION_MODEL
from phonanim.errors import AudioError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import Sound, read_sound, resample
from phonanim.pipeline import load_model
from phonanim.recognition.network import Network, load_network
from phonanim.recognition.recognizer import PhoneRecognizer, look_ahead, recognize_phones
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones

VOWELS = INVENTORY.where(kind="vowel")
RATE = 16000


@pytest.fixture(scope="module")
def weights() -> Path:
    path = load_model(RECOGNITION_MODEL).recognizer
    assert path is not None
    return path


@pytest.fixture(scope="module")
def network(weights: Path) -> Network:
    return load_network(weights)


@pytest.fixture(scope="module")
def line(root: Path) -> Sound:
    """A sentence by eSpeak NG."""
    sound = read_sound(root / "examples" / "line.wav")
    return Sound(resample(sound.samples, sound.rate, RATE), RATE)


def in_pieces(network: Network, samples: np.ndarray, size: int) -> list[Interval]:
    recognizer, found = PhoneRecognizer(network), []
    for begin in range(0, len(samples), size):
        found += recognizer.push(samples[begin : begin + size])
        assert recognizer.until <= recognizer.received / RATE
    return [*found, *recognizer.end()]


@pytest.mark.parametrize("size", [80, 160, 1001, 16000])
def test_pieces_give_what_the_whole_gives(size: int, network: Network, line: Sound) -> None:
    assert in_pieces(network, line.samples, size) == in_pieces(network, line.samples, len(line.samples))


def test_what_comes_later_changes_nothing(network: Network, line: Sound) -> None:
    cut = int(1.4 * RATE)
    recognizer = PhoneRecognizer(network)
    early = recognizer.push(line.samples[:cut])
    assert len(early) > 5
    assert recognizer.until >= cut / RATE - look_ahead(network) - 0.011
    assert in_pieces(network, line.samples, len(line.samples))[: len(early)] == early


def test_it_looks_ahead_a_fifth_of_a_second_at_most_and_is_small(weights: Path, network: Network) -> None:
    assert look_ahead(network) <= 0.2
    assert weights.stat().st_size < 2_000_000


def agreement(found: Alignment, given: Alignment, language: str) -> tuple[float, float]:
    """Shares of steps of 10 ms whose kind (silence, consonant, vowel) and whose phone agree."""
    times = np.arange(0, given.duration, 0.01)
    ours = to_phones(found, "ipa")[0].sample(times)
    theirs = to_phones(given, language)[0].sample(times)
    kinds = [np.where(VOWELS[codes], 2, codes > 0) for codes in (ours, theirs)]
    return float((kinds[0] == kinds[1]).mean()), float((ours == theirs).mean())


def test_vowels_and_consonants_of_a_sentence(weights: Path, line: Sound, root: Path) -> None:
    found = recognize_phones(line, weights, "line.wav")
    kinds, phones = agreement(found, read_alignment(root / "examples" / "line.TextGrid"), "english")
    assert kinds > 0.8
    assert phones > 0.5


def test_another_language(weights: Path) -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    from phonanim.aligners.espeak import speak

    spoken = speak("Bonjour mes amis, vous parlez beaucoup.", "fr+f4")
    samples = (spoken.samples / 32768).astype(np.float32)
    found = recognize_phones(Sound(samples, spoken.rate), weights, "fr")
    kinds, _ = agreement(found, Alignment(spoken.phones, spoken.duration, "", ""), "ipa")
    assert kinds > 0.65


@pytest.mark.parametrize("gain", [0.02, 3.0])
def test_the_level_of_the_sound_hardly_matters(gain: float, weights: Path, line: Sound) -> None:
    usual = recognize_phones(line, weights, "line")
    other = recognize_phones(Sound(line.samples * np.float32(gain), RATE), weights, "line")
    assert agreement(other, usual, "ipa")[0] > 0.9


def test_silence_noise_and_moments_are_refused(weights: Path) -> None:
    silence = np.zeros(RATE, np.float32)
    noise = np.random.default_rng(0).normal(0, 1e-4, RATE).astype(np.float32)
    for samples in (silence, noise):
        with pytest.raises(AudioError, match=r"a\.wav: no speech is recognized in it"):
            recognize_phones(Sound(samples, RATE), weights, "a.wav")
    with pytest.raises(
        AudioError, match=r"a\.wav: lasts 0\.10 s, and phones are recognized in 0\.2 s at least"
    ):
        recognize_phones(Sound(silence[:1600], RATE), weights, "a.wav")


def test_recordings_are_animated_alike_without_torch(root: Path, tmp_path: Path) -> None:
    code = (
        "import sys\nfrom phonanim.__main__ import run\n"
        "for path in sys.argv[1:]:\n"
        "    assert run(['animate', 'examples/line.wav', '--model', 'audio', '-o', path]) == 0\n"
        "assert not {'torch', 'scipy', 'sklearn', 'matplotlib', 'ctranslate2'} & set(sys.modules)"
    )
    first, second = tmp_path / "a" / "line.csv", tmp_path / "b" / "line.csv"
    for path in (first, second):
        path.parent.mkdir()
    subprocess.run([sys.executable, "-c", code, str(first), str(second)], cwd=root, check=True)
    assert first.read_bytes() == second.read_bytes()
