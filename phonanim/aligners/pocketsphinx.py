"""Align English speech with its text: words and phones by pocketsphinx, offline."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners._network import Run, Slot, choices_of, transitions_of
from phonanim.aligners.espeak import can_speak, pronounce
from phonanim.core.stderr import silent_stderr
from phonanim.errors import AlignmentError, MissingExtraError, OptionError
from phonanim.media.audio import Sound, level, read_sound, resample
from phonanim.recognition.scores import phone_misfits
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.doubts import TIER
from phonanim.speech.language import to_phones
from phonanim.speech.written_forms import in_english_words

RATE = 16000  # hertz of the acoustic model's training data
FRAME = 0.01  # seconds, the step of the acoustic model
FILLERS = ("<", "[", "+", "SIL")  # first characters of entries that are not words: <sil>, [NOISE], [SPEECH]
WIDE = {"beam": 1e-80, "pbeam": 1e-80, "wbeam": 1e-60}  # how much less likely a path may be that is kept
MOST_SHOWN = 10  # words of a note
WORST = 5.0  # nats from which a phone does not fit at all
DOUBTFUL = 2.6  # nats on average, from which a text is doubted: right ones had 1.4 and 1.5, another text 3.4
DITHER = 1e-4  # of full scale: digital silence has no spectrum to recognize


@dataclass(frozen=True, slots=True)
class SpeechAlignment:
    """An alignment: words and phones in seconds (of pocketsphinx: lower case, ARPAbet without stress).

    The labels of `confidence` are numbers from 0 to 1: how sure each word is, and 0 for speech without words.
    """

    words: tuple[Interval, ...]
    phones: tuple[Interval, ...]
    duration: float
    notes: tuple[str, ...] = ()
    confidence: tuple[Interval, ...] = ()

    @property
    def tiers(self) -> dict[str, tuple[Interval, ...]]:
        """The tiers of a TextGrid."""
        tiers = {"words": self.words, "phones": self.phones}
        return tiers | ({TIER: self.confidence} if self.confidence else {})


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
            found = _two_passes(decoder, samples, sound.duration)
            words, phones = _tiers(found)
            return SpeechAlignment(words, phones, sound.duration, (*notes, *_doubts(samples, phones)))
    raise AlignmentError(f"{name}: the text cannot be found in the audio; check that they match")


def _doubts(samples: bytes, phones: tuple[Interval, ...]) -> tuple[str, ...]:
    """A note where the phones that were found hardly fit the sound."""
    duration = len(samples) / 2 / RATE
    track, _ = to_phones(Alignment(phones, duration, "", ""), "english", unknown="nearest")
    sound = np.asarray(np.frombuffer(samples, "<i2") / 32768, np.float32)
    misfits = np.minimum(phone_misfits(sound), WORST)
    codes = track.sample(np.arange(len(misfits), dtype=np.float64) * FRAME)
    misfit = misfits[np.arange(len(misfits)), codes][codes > 0]
    if not len(misfit) or misfit.mean() <= DOUBTFUL:
        return ()
    return ("the recording hardly matches the text: its phones do not fit the sound; check the text",)


FORGIVEN = (RuntimeError, AlignmentError, OptionError)
"""What the alignment of a piece may raise, where it does not have its words."""


@dataclass(frozen=True, slots=True)
class FoundWord:
    """A word that was found, and its phones."""

    word: Interval
    phones: tuple[Interval, ...]


class PieceAligner:
    """Aligns pieces of a recording one after the other; the acoustic model is loaded once."""

    def __init__(self) -> None:
        self._decoders: dict[bool, Any] = {}
        self._taught: dict[str, tuple[str, ...]] = {}

    def align(self, piece: Sound, words: list[str]) -> SpeechAlignment:
        """Find words in a piece. Raises one of FORGIVEN where it does not have them."""
        slots: list[Slot] = [((word,),) for word in words]
        if not slots:
            raise OptionError("the text has no words; give the words of the recording")
        found = [word for _, words in self.find(piece, slots) for word in words]
        return SpeechAlignment(*_tiers(found), piece.duration)

    def learn(self, words: Iterable[str]) -> None:
        """Have words pronounced that the dictionary lacks, all at once, which is faster than piece by piece.

        Raises OptionError for words that cannot be pronounced.
        """
        self._decoders[False] = self._decoders.get(False) or _decoder("", bestpath=False, wide=True)[0]
        _teach(self._decoders[False], dict.fromkeys(words), self._taught)

    def find(self, piece: Sound, slots: Sequence[Slot]) -> list[tuple[Run, list[FoundWord]]]:
        """What each slot of a piece says, and where. Raises one of FORGIVEN where no path is found."""
        samples = _pcm(resample(piece.samples, piece.rate, RATE))
        for bestpath in (False, True):
            with suppress(RuntimeError):  # raised by pocketsphinx
                return self._find(samples, piece.duration, slots, bestpath)
        raise AlignmentError("the words of a piece cannot be found in it; check that they match")

    def _find(
        self, samples: bytes, duration: float, slots: Sequence[Slot], bestpath: bool
    ) -> list[tuple[Run, list[FoundWord]]]:
        decoder = self._decoders.pop(bestpath, None) or _decoder("", bestpath, wide=True)[0]
        _teach(decoder, dict.fromkeys(word for slot in slots for run in slot for word in run), self._taught)
        last, transitions = transitions_of(slots)
        decoder.add_fsg("piece", decoder.create_fsg("piece", 0, last, transitions))
        decoder.activate_search("piece")
        found = _two_passes(decoder, samples, duration)
        self._decoders[bestpath] = decoder  # one that failed is of no more use
        runs = choices_of(slots, [one.word.label for one in found])
        if runs is None:
            raise RuntimeError("words are found that are not asked for")
        words = iter(found)
        return [(run, [next(words) for _ in run]) for run in runs]

    def notes(self, words: Iterable[str]) -> tuple[str, ...]:
        """A note on those words that the dictionary lacks."""
        return _pronounced({word: self._taught[word] for word in words if word in self._taught})


def split_words(text: str) -> list[str]:
    """The words of a sentence in lower case, without punctuation."""
    return re.findall(r"[^\W_]+(?:['’][^\W_]+)*", text.lower().replace("’", "'"))


def _two_passes(decoder: Any, sound: bytes, duration: float) -> list[FoundWord]:
    """Find the words first; then, with these words fixed, find their phones."""
    _decode(decoder, sound)
    if decoder.hyp() is None:
        raise RuntimeError("no path through the text")
    decoder.set_alignment()
    _decode(decoder, sound)
    found: list[FoundWord] = []
    for word in decoder.get_alignment():
        if not word.name.startswith(FILLERS):
            # Read the entry while the iterator is at this word: afterwards its memory is freed.
            phones = tuple(_interval(phone.name, phone, duration) for phone in word)
            found.append(FoundWord(_interval(strip_variant_number(word.name), word, duration), phones))
    return found


def _tiers(found: Iterable[FoundWord]) -> tuple[tuple[Interval, ...], tuple[Interval, ...]]:
    """The tiers of words and of phones."""
    words = list(found)
    return tuple(one.word for one in words), tuple(phone for one in words for phone in one.phones)


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
    words = split_words(in_english_words(text))
    if not words:
        raise OptionError("the text has no words; give the words of the recording")
    taught: dict[str, tuple[str, ...]] = {}
    _teach(decoder, dict.fromkeys(words), taught)
    return words, _pronounced(taught)


def _teach(decoder: Any, words: Iterable[str], taught: dict[str, tuple[str, ...]]) -> None:
    """Teach a decoder the words that it lacks, as `taught` has them; what that lacks is added to it."""
    missing = [word for word in words if decoder.lookup_word(word) is None]
    unknown = [word for word in missing if word not in taught]
    if unknown and not can_speak():
        listed = ", ".join(map(repr, unknown))
        raise OptionError(
            f"not in the pronouncing dictionary: {listed}; spell numbers out and write names as the words "
            "they sound like, or pip install 'phonanim[espeak]', which pronounces them"
        )
    if unknown:
        taught |= pronounce(unknown)
    for word in missing:
        decoder.add_word(word, " ".join(taught[word]))


def _pronounced(taught: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    """A note on words that were pronounced."""
    said = [f"{word!r} ({' '.join(phones)})" for word, phones in taught.items()]
    if not said:
        return ()
    more = f" and {len(said) - MOST_SHOWN} more" if len(said) > MOST_SHOWN else ""
    shown = ", ".join(said[:MOST_SHOWN])
    return (f"not in the pronouncing dictionary, so pronounced by eSpeak NG: {shown}{more}",)


def _pcm(samples: NDArray[np.float32]) -> bytes:
    """16-bit little-endian samples with a small noise, the same in every run."""
    noise = np.random.default_rng(0).normal(0.0, DITHER, len(samples))
    return (np.clip(level(samples) + noise, -1.0, 1.0) * 32767).astype("<i2").tobytes()


def _decoder(text: str | None, bestpath: bool, wide: bool = False) -> tuple[Any, tuple[str, ...]]:
    """A decoder for a text, or for any words when it is None; and notes."""
    with silent_stderr():  # pocketsphinx opens the sound card on import, and prints an error without one
        try:
            from pocketsphinx import Decoder
        except ImportError as error:
            raise MissingExtraError("aligning speech needs pip install 'phonanim[align]'") from error
    options: dict[str, Any] = {} if text is None else {"lm": None}
    options |= WIDE if wide else {}
    decoder = Decoder(samprate=RATE, loglevel="FATAL", bestpath=bestpath, **options)
    if text is None:
        return decoder, ()
    if not text.strip():
        return decoder, ()
    words, notes = _known_words(decoder, text)
    decoder.set_align_text(" ".join(words))
    return decoder, notes
