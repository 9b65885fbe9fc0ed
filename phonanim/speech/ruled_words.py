"""Words of languages other than English as phones, by the rules of eSpeak NG."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from phonanim.errors import OptionError
from phonanim.media.espeak import can_speak
from phonanim.speech.alignment_file import AlignmentFile, quote_label
from phonanim.speech.espeak_phones import pronounce_words, reading_language
from phonanim.speech.intervals import Interval, Recording, Tier
from phonanim.speech.labels import is_silent
from phonanim.speech.spoken_words import is_sound, plain_word
from phonanim.speech.tiers import WORD_NAMES, best_named_tiers, speaker_of
from phonanim.speech.word_times import settle_words

MOST_SHOWN = 5


def spell_by_rules(recording: Recording, code: str | None, source: AlignmentFile, unknown: str) -> Recording:
    """The recording with phones of its words by the rules of eSpeak NG, for languages other than English.

    It stays as it is without words, a language, or the extra `espeak`. Raises AlignmentError for a word that
    the voice cannot read, unless `unknown` shows it as silence.
    """
    tiers = best_named_tiers(recording.tiers, WORD_NAMES)
    if not tiers or not code or code == "en" or not can_speak() or not any(map(says_something, tiers)):
        return recording
    settled, placed = settle_words(tiers, recording)
    words = [plain_word(one.label) for tier in settled for one in tier.intervals if _is_word(one)]
    try:
        spoken = pronounce_words(words, code)
    except OptionError:
        return recording
    speller = RuledSpeller(spoken, code, source, unknown)
    first = len(recording.tiers) + 1
    spelled = [
        Tier("phones", speller.spell(tier), number, speaker_of(tier))
        for number, tier in enumerate(settled, first)
    ]
    changed = dict(zip(map(id, tiers), settled, strict=True))
    note = f"the phones are those of eSpeak NG for {code} and share the time of each word equally"
    return replace(
        recording,
        tiers=(*(changed.get(id(tier), tier) for tier in recording.tiers), *spelled),
        notes=(*recording.notes, *placed, note, *speller.notes()),
        language=reading_language(code),
    )


def _is_word(interval: Interval) -> bool:
    return not is_silent(interval.label) and not is_sound(interval.label)


@dataclass
class RuledSpeller:
    """Looks words up among those that eSpeak NG has pronounced."""

    words: Mapping[str, tuple[str, ...]]
    code: str
    source: AlignmentFile
    unknown: str
    _sounds: Counter[str] = field(default_factory=Counter)
    _silent: Counter[str] = field(default_factory=Counter)

    def spell(self, tier: Tier) -> tuple[Interval, ...]:
        """The phones of a tier of words; they share the time of each word equally."""
        phones: list[Interval] = []
        for word in tier.intervals:
            if is_silent(word.label):
                phones.append(word)
            elif is_sound(word.label):
                self._sounds[word.label] += 1
            elif spoken := self.words.get(plain_word(word.label), ()):
                phones += share_time(word, spoken)
            elif any(c.isalnum() for c in word.label):
                self._pass_over(word)
        return tuple(phones)

    def _pass_over(self, word: Interval) -> None:
        if self.unknown == "error":
            raise self.source.error(
                f'word "{quote_label(word.label)}" at {word.start:.2f} s is not read by eSpeak NG for '
                f"{self.code}; give --lexicon, or leave it out with --on-unknown-label silence"
            )
        self._silent[word.label] += 1

    def notes(self) -> tuple[str, ...]:
        """A note for sounds, and one for words that are left out."""
        told = {"are sounds, shown as silence": self._sounds, "are not read, and are silence": self._silent}
        return tuple(f"{what}: {list_some(words)}" for what, words in told.items() if words)


def says_something(tier: Tier) -> bool:
    """Whether a tier has any word."""
    return any(not is_silent(one.label) for one in tier.intervals)


def list_some(words: Counter[str]) -> str:
    """The first words, and how many more there are."""
    shown = ", ".join(quote_label(word) for word in list(words)[:MOST_SHOWN])
    more = len(words) - MOST_SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


def share_time(interval: Interval, phones: tuple[str, ...]) -> list[Interval]:
    """The phones of an interval, which share its time equally."""
    step = (interval.end - interval.start) / len(phones)
    bounds = [interval.start + step * n for n in range(len(phones))] + [interval.end]
    return [Interval(phone, bounds[n], bounds[n + 1]) for n, phone in enumerate(phones)]
