"""Speech from text by eSpeak NG, offline, in about a hundred languages, with the times of words and phones.

Times are those that the synthesizer itself reports (`speak_lib.h`, events of phonemes and words).
"""

from __future__ import annotations

import base64
import wave
from collections.abc import Iterable
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from unicodedata import category

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path
from phonanim.errors import OptionError
from phonanim.media.espeak import ask_espeak, can_speak
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.espeak_phones import plain_ipa, pronounce_words, reading_language
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones
from phonanim.speech.spoken_text import espeak_voice, plain_label, prepare_text

__all__ = ["VOICE", "SpokenText", "can_speak", "pronounce", "reading_language", "speak", "write_speech"]

VOICE = "en-us"
MARGIN = 0.25  # seconds of silence before and after, so that a mouth can open and rest

WORD, PHONEME = 1, 7  # types of events in speak_lib.h


@dataclass(frozen=True)
class SpokenText:
    """Speech: `samples` (n,) 16-bit at `rate` Hz, and its words and phones (IPA with stress) in seconds.

    `notes` say what of the text is not spoken, or may be spoken wrongly.
    """

    samples: NDArray[np.int16]
    rate: int
    words: tuple[Interval, ...]
    phones: tuple[Interval, ...]
    notes: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Seconds."""
        return len(self.samples) / self.rate


def speaker_version() -> str:
    """The version of the package that carries eSpeak NG, "" without it."""
    try:
        return version("espeakng-loader")
    except PackageNotFoundError:
        return ""


def pronounce(words: Iterable[str], voice: str = VOICE) -> dict[str, tuple[str, ...]]:
    """Words, numbers and names as phones of the inventory in upper case (ARPAbet without stress).

    Raises OptionError for a word that cannot be spoken, and what `pronounce_words` raises.
    """
    found = {}
    for word, labels in pronounce_words(words, voice).items():
        if not labels:
            raise OptionError(f"{word[:40]!r}: the voice {voice} cannot speak any of it; give another text")
        phones = tuple(Interval(label, float(n), n + 1.0) for n, label in enumerate(labels))
        track, _ = to_phones(Alignment(phones, float(len(phones)), "", word), "ipa", unknown="nearest")
        found[word] = tuple(INVENTORY.phones[code].upper() for code in track.codes if code)
    return found


def speak(text: str, voice: str = VOICE, words_per_minute: int | None = None) -> SpokenText:
    """Speak a text, at eSpeak NG's own rate (175 words a minute) unless another is given.

    `voice` is a language code (`de`, `en-us`, `cmn`) or a name (`german`) that eSpeak NG has, and may name a
    variant after a plus sign (`de+f2`). Marks, directions in brackets and emoji are not spoken, with a note;
    a text with a `<speak>` is SSML. Raises OptionError for an unknown voice, suggesting the nearest, for
    letters that the voice cannot read, and for a text without anything to say; MissingExtraError without the
    extra.
    """
    form = prepare_text(text, voice)
    answer = ask_espeak(
        {
            **{"text": form.text, "voice": espeak_voice(voice), "words_per_minute": words_per_minute},
            "is_ssml": form.is_ssml,
        }
    )
    samples = np.frombuffer(base64.b64decode(answer["samples"]), "<i2")
    spoken = _timed(samples, answer["rate"], answer["events"], form.text)
    if not spoken.phones:
        raise OptionError(f"{text[:40]!r}: the voice {voice} cannot speak any of it; give another text")
    words = (replace(word, label=plain_label(form, word.label)) for word in spoken.words)
    return replace(spoken, words=tuple(words), notes=form.notes)


def write_speech(path: Path, spoken: SpokenText) -> None:
    """Write the sound as a 16-bit WAV file, atomically."""
    with atomic_path(path) as partial, wave.open(str(partial), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(spoken.rate)
        stream.writeframes(spoken.samples.astype("<i2").tobytes())


def _timed(
    samples: NDArray[np.int16], rate: int, events: list[tuple[int, int, int, int, str]], text: str
) -> SpokenText:
    """Events -> intervals, with MARGIN of silence around all. A phone lasts until the next event begins."""
    margin = np.zeros(round(MARGIN * rate), np.int16)
    marks = [
        (MARGIN + sample / rate, plain_ipa(label)) for kind, sample, _, _, label in events if kind == PHONEME
    ]
    ends = [*(start for start, _ in marks[1:]), MARGIN + len(samples) / rate]
    phones: list[Interval] = []
    for (start, label), end in zip(marks, ends, strict=True):
        if not label or end <= start:
            continue
        if phones and all(category(sign) in ("Lm", "Mn") for sign in label):  # a mark of the phone before it
            phones[-1] = Interval(phones[-1].label + label, phones[-1].start, end)
        else:
            phones += _shared(label.split(), start, end)
    words = _words([event for event in events if event[0] == WORD], text, phones, rate)
    return SpokenText(np.concatenate([margin, samples, margin]), rate, words, tuple(phones))


def _shared(labels: list[str], start: float, end: float) -> list[Interval]:
    bounds = np.linspace(start, end, len(labels) + 1).tolist()
    return [Interval(label, a, b) for label, a, b in zip(labels, bounds, bounds[1:], strict=False)]


def _words(
    events: list[tuple[int, int, int, int, str]], text: str, phones: list[Interval], rate: int
) -> tuple[Interval, ...]:
    """The words that are spoken. Words that are spoken as one stay together, and so does a number."""
    begins: list[tuple[float, int, int]] = []  # seconds, first and last + 1 character
    for _, sample, at, length, _ in events:
        if not begins or at > begins[-1][2]:
            begins.append((MARGIN + sample / rate, at, at - 1 + length))
    words = []
    stops = [*((start, at) for start, at, _ in begins[1:]), (float("inf"), len(text) + 1)]
    for (start, at, _), (stop, after) in zip(begins, stops, strict=False):
        inside = [phone for phone in phones if start <= phone.start < stop]
        if inside and (word := _without_punctuation(text[at - 1 : after - 1])):
            words.append(Interval(word, inside[0].start, inside[-1].end))
    return tuple(words)


def _without_punctuation(word: str) -> str:
    kept = [number for number, sign in enumerate(word) if category(sign)[0] not in "PZSC"]
    return word[kept[0] : kept[-1] + 1] if kept else ""
