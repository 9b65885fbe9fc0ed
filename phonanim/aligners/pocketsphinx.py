"""Align English speech with its text: words and phones by pocketsphinx, offline."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners.espeak import can_speak, pronounce
from phonanim.core.stderr import silent_stderr
from phonanim.errors import AlignmentError, MissingExtraError, OptionError
from phonanim.media.audio import Sound, read_sound, resample
from phonanim.speech.alignment import Interval

RATE = 16000  # hertz of the acoustic model's training data
FRAME = 0.01  # seconds, the step of the acoustic model
FILLERS = ("<", "[", "+", "SIL")  # first characters of entries that are not words: <sil>, [NOISE], [SPEECH]
DITHER = 1e-4  # of full scale: digital silence has no spectrum to recognize


@dataclass(frozen=True, slots=True)
class SpeechAlignment:
    """An alignment: words and phones in seconds (of pocketsphinx: lower case, ARPAbet without stress)."""

    words: tuple[Interval, ...]
    phones: tuple[Interval, ...]
    duration: float
    notes: tuple[str, ...] = ()


def align(audio: Path, text: str | None = None) -> SpeechAlignment:
    """Find the words and phones of `text` in a recording; without text, recognize the words.

    A word that is not in the CMU pronouncing dictionary is pronounced by eSpeak NG, and a note says how.
    Raises OptionError for such a word without the extra `espeak`, AlignmentError when the text does not match
    the audio, AudioError when the recording cannot be read, MissingExtraError.
    """
    return align_sound(read_sound(audio), text, str(audio))


def align_sound(sound: Sound, text: str | None, name: str) -> SpeechAlignment:
    """Align a recording in memory as `align` does; errors call it `name`."""
    samples = _pcm(resample(sound.samples, sound.rate, RATE))
    for bestpath in (True, False):  # the best path may give fillers a single frame, too short to be aligned
        with suppress(RuntimeError):  # raised by pocketsphinx
            decoder, notes = _decoder(text, bestpath)
            words, phones = _two_passes(decoder, samples, sound.duration)
            return SpeechAlignment(tuple(words), tuple(phones), sound.duration, notes)
    raise AlignmentError(f"{name}: the text cannot be found in the audio; check that they match")


FORGIVEN = (RuntimeError, AlignmentError, OptionError)
"""What the alignment of a piece may raise, where it does not have its words."""


class PieceAligner:
    """Aligns pieces of a recording one after the other; the acoustic model is loaded once."""

    def __init__(self) -> None:
        self._decoders: dict[bool, Any] = {}
        self._notes: dict[str, None] = {}

    def align(self, piece: Sound, words: list[str]) -> SpeechAlignment:
        """Find words in a piece. Raises one of FORGIVEN where it does not have them."""
        samples = _pcm(resample(piece.samples, piece.rate, RATE))
        try:
            found, phones = self._passes(samples, piece.duration, words, bestpath=False)
        except RuntimeError:  # raised by pocketsphinx
            found, phones = self._passes(samples, piece.duration, words, bestpath=True)
        return SpeechAlignment(tuple(found), tuple(phones), piece.duration)

    def _passes(
        self, samples: bytes, duration: float, words: list[str], bestpath: bool
    ) -> tuple[list[Interval], list[Interval]]:
        decoder = self._decoders.get(bestpath) or _decoder("", bestpath)[0]
        self._decoders.pop(bestpath, None)  # a decoder that failed is of no more use
        known, notes = _known_words(decoder, " ".join(words))
        self._notes |= dict.fromkeys(notes)
        decoder.set_align_text(" ".join(known))
        found = _two_passes(decoder, samples, duration)
        self._decoders[bestpath] = decoder
        return found

    def notes(self) -> tuple[str, ...]:
        """Notes on the words that the dictionary lacks."""
        return tuple(self._notes)


def split_words(text: str) -> list[str]:
    """The words of a sentence in lower case, without punctuation."""
    return re.findall(r"[^\W_]+(?:['’][^\W_]+)*", text.lower().replace("’", "'"))


def _two_passes(decoder: Any, sound: bytes, duration: float) -> tuple[list[Interval], list[Interval]]:
    """Find the words first; then, with these words fixed, find their phones."""
    _decode(decoder, sound)
    if decoder.hyp() is None:
        raise RuntimeError("no path through the text")
    decoder.set_alignment()
    _decode(decoder, sound)
    words: list[Interval] = []
    phones: list[Interval] = []
    for word in decoder.get_alignment():
        if not word.name.startswith(FILLERS):
            words.append(_interval(strip_variant_number(word.name), word, duration))
            # Read the entry while the iterator is at this word: afterwards its memory is freed.
            phones += [_interval(phone.name, phone, duration) for phone in word]
    return words, phones


def _decode(decoder: Any, sound: bytes) -> None:
    decoder.start_utt()
    decoder.process_raw(sound, full_utt=True)
    decoder.end_utt()


def strip_variant_number(entry: str) -> str:
    """A dictionary entry without the number of its pronunciation: "the(2)" is "the"."""
    return re.sub(r"\(\d+\)$", "", entry)


def _interval(label: str, entry: Any, duration: float) -> Interval:
    return Interval(label, entry.start * FRAME, min((entry.start + entry.duration) * FRAME, duration))


def _known_words(decoder: Any, text: str) -> tuple[list[str], tuple[str, ...]]:
    """The words, once the decoder knows all of them, and a note on those that it had to be taught."""
    words = split_words(text)
    if not words:
        raise OptionError("the text has no words; give the words of the recording")
    unknown = [word for word in dict.fromkeys(words) if decoder.lookup_word(word) is None]
    if not unknown:
        return words, ()
    if not can_speak():
        listed = ", ".join(map(repr, unknown))
        raise OptionError(
            f"not in the pronouncing dictionary: {listed}; spell numbers out and write names as the words "
            "they sound like, or pip install 'phonanim[espeak]', which pronounces them"
        )
    taught = pronounce(unknown)
    for word, phones in taught.items():
        decoder.add_word(word, " ".join(phones))
    said = ", ".join(f"{word!r} ({' '.join(phones)})" for word, phones in taught.items())
    return words, (f"not in the pronouncing dictionary, so pronounced by eSpeak NG: {said}",)


def _pcm(samples: NDArray[np.float32]) -> bytes:
    """16-bit little-endian samples with a small noise, the same in every run."""
    noise = np.random.default_rng(0).normal(0.0, DITHER, len(samples))
    return (np.clip(samples + noise, -1.0, 1.0) * 32767).astype("<i2").tobytes()


def _decoder(text: str | None, bestpath: bool) -> tuple[Any, tuple[str, ...]]:
    """A decoder for a text, or for any words when it is None; and notes."""
    with silent_stderr():  # pocketsphinx opens the sound card on import, and prints an error without one
        try:
            from pocketsphinx import Decoder
        except ImportError as error:
            raise MissingExtraError("aligning speech needs pip install 'phonanim[align]'") from error
    options: dict[str, Any] = {} if text is None else {"lm": None}
    decoder = Decoder(samprate=RATE, loglevel="FATAL", bestpath=bestpath, **options)
    if text is None:
        return decoder, ()
    if not text.strip():
        return decoder, ()
    words, notes = _known_words(decoder, text)
    decoder.set_align_text(" ".join(words))
    return decoder, notes
