"""Pronunciation dictionaries: convert words with times into phones when there is no phone tier."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import islice
from pathlib import Path

from phonanim.core.decode import DecodeError, read_utf8
from phonanim.errors import AlignmentError, LabelError
from phonanim.media.espeak import can_speak
from phonanim.speech.alignment_file import AlignmentFile, quote_label
from phonanim.speech.cmu_dictionary import find_cmu_dictionary
from phonanim.speech.espeak_phones import pronounce_words
from phonanim.speech.intervals import Interval, Recording, Tier
from phonanim.speech.labels import is_silent
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import is_auto, one_expected
from phonanim.speech.ruled_words import list_some, says_something, share_time, spell_by_rules
from phonanim.speech.spelling import sound_out
from phonanim.speech.spoken_words import is_sound, plain_word, split_word
from phonanim.speech.tiers import (
    PHONE_NAMES,
    WORD_NAMES,
    best_named_tiers,
    best_tiers_by_content,
    speaker_of,
)
from phonanim.speech.word_times import settle_words
from phonanim.speech.written_forms import in_english_words

NOTE = "the phones come from a dictionary and share the time of each word equally"
MOST_SHOWN = 5
MAX_BYTES = 1 << 26  # of a dictionary: that of CMU, with 135,000 words, has 4 MB
MOST_COMPARED = 2_500_000  # words of the dictionary, in the search of all similar ones

UNNAMED = "labels"  # what readers call a tier in formats that have no names
LOOKED_AT = 1000  # words of a dictionary that tell its phone set
ENOUGH_ARPABET = 0.95
ENOUGH_ENGLISH = 0.5  # share of words in the CMU dictionary below which words are not English

# Dictionaries of the Montreal Forced Aligner may have probabilities between the word and its phones.
_PROBABILITY = re.compile(r"\d+\.\d+")
_VARIANT = re.compile(r"\(\d+\)$")

# What a plural or possessive s sounds like after the last sound of a word.
_HISSING = ("S", "Z", "SH", "ZH", "CH", "JH")
_VOICELESS = ("P", "T", "K", "F", "TH")


@lru_cache(maxsize=4)
def load_pronunciations(path: Path) -> Mapping[str, tuple[str, ...]]:
    """The first pronunciation of each word. Each line has a word and its phones, as CMU and MFA write them.

    A file is read once per process, since reading takes longer than animating most lines. Raises
    AlignmentError when it cannot be read or has no entries.
    """
    try:
        text = read_utf8(path, MAX_BYTES).removeprefix("\ufeff")
    except (OSError, DecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise AlignmentError(f"{path}: cannot be read: {reason}") from error
    words: dict[str, tuple[str, ...]] = {}
    for line in text.splitlines():
        word, *phones = line.split(" #")[0].split() or [""]
        spoken = tuple(phone for phone in phones if not _PROBABILITY.fullmatch(phone))
        if spoken and not word.startswith(";;;"):
            words.setdefault(_VARIANT.sub("", word).lower(), spoken)
    if not words:
        raise AlignmentError(f"{path}: has no line of a word and its phones; name a pronunciation dictionary")
    return words


def spell_out(
    recording: Recording,
    path: Path | None,
    source: AlignmentFile,
    unknown: str = "error",
    language: str = "auto",
) -> Recording:
    """The recording with a phone tier next to each word tier, if it has no phone tier yet.

    Without a path, English words are looked up in the CMU dictionary of an installed package. A word that the
    dictionary lacks is spelled by its letters, if they are English; else `unknown` decides, as for labels.
    Raises AlignmentError for a word that cannot be spelled, with its time.
    """
    if best_named_tiers(recording.tiers, PHONE_NAMES):
        return recording
    given = path
    path = given or _default_dictionary(recording, language)
    if path is None:
        return spell_by_rules(recording, _language_of(recording, language), source, unknown)
    word_tiers = best_named_tiers(recording.tiers, WORD_NAMES) or _wordlike_tiers(recording.tiers, path)
    others = [tier for tier in recording.tiers if tier not in word_tiers]
    if not any(map(says_something, word_tiers)) or best_tiers_by_content(others):
        return recording
    if given is None and not _is_english(word_tiers, path):
        return recording
    settled, placed = settle_words(word_tiers, recording)
    voice = _language_of(recording, language) or ""
    speller = Speller(load_pronunciations(path), path, source, unknown, "" if voice == "en" else voice)
    first = len(recording.tiers) + 1
    spelled = [
        Tier("phones", speller.spell(tier), number, speaker_of(tier))
        for number, tier in enumerate(settled, first)
    ]
    named = [tier if _is_named(tier) else replace(tier, name="words") for tier in settled]
    changed = dict(zip(map(id, word_tiers), named, strict=True))
    tiers = tuple(changed.get(id(tier), tier) for tier in recording.tiers)
    notes = (*recording.notes, *placed, NOTE, *speller.notes())
    return replace(recording, tiers=(*tiers, *spelled), notes=notes)


def _default_dictionary(recording: Recording, language: str) -> Path | None:
    """The CMU dictionary, unless the file or the options name a language other than English."""
    spoken = _language_of(recording, language)
    return find_cmu_dictionary() if spoken is not None and spoken in ("", "en") else None


def _language_of(recording: Recording, language: str) -> str | None:
    """The code of the language that the options or the file name, "" without any, "en" for all English.

    None for one that does not exist.
    """
    named = (one_expected(language) if is_auto(language) else language) or recording.spoken
    if not named:
        return ""
    try:
        code = load_language(named).code or "en"
    except LabelError:
        return None
    return "en" if code.startswith("en") else code


def _is_english(tiers: list[Tier], path: Path) -> bool:
    """Whether the CMU dictionary has enough of the words that are spelled with letters."""
    known = load_pronunciations(path)
    words = [plain_word(one.label) for tier in tiers for one in tier.intervals if not is_sound(one.label)]
    words = [word for word in words if any(c.isalpha() for c in word)]
    parts = [part for word in words for part in ([word] if word in known else split_word(word))]
    return sum(part.strip("'.") in known for part in parts) >= ENOUGH_ENGLISH * len(parts)


def _is_named(tier: Tier) -> bool:
    return bool(best_named_tiers([tier], WORD_NAMES))


def _wordlike_tiers(tiers: tuple[Tier, ...], path: Path) -> list[Tier]:
    """The tiers whose labels are words of the dictionary, in formats that do not say what a tier has."""
    found = []
    for tier in tiers:
        if tier.name != UNNAMED:
            continue
        labels = [one.label for one in tier.intervals if not is_silent(one.label) and not is_sound(one.label)]
        if not labels or sum(map(len, labels)) < 3 * len(labels):
            continue
        known = load_pronunciations(path)
        if 3 * sum(plain_word(label) in known for label in labels) >= 2 * len(labels):
            found.append(tier)
    return found


@dataclass
class Speller:
    """Looks words up in a dictionary, and spells those that it lacks."""

    words: Mapping[str, tuple[str, ...]]
    path: Path
    source: AlignmentFile
    unknown: str = "error"
    voice: str = ""
    _told: dict[str, Counter[str]] = field(default_factory=dict)
    _compared: int = 0

    def spell(self, tier: Tier) -> tuple[Interval, ...]:
        """The phones of a tier of words; they share the time of each word equally."""
        phones: list[Interval] = []
        for word in tier.intervals:
            if is_silent(word.label):
                phones.append(word)
            elif is_sound(word.label):
                self._tell("are sounds, shown as silence", word.label)
            elif spoken := self._pronounce(word):
                phones += share_time(word, spoken)
        return tuple(phones)

    def notes(self) -> tuple[str, ...]:
        """A note for each kind of word that was not in the dictionary."""
        return tuple(f"{what}: {list_some(words)}" for what, words in self._told.items())

    def _pronounce(self, word: Interval) -> tuple[str, ...]:
        plain = plain_word(word.label)
        said = in_english_words(word.label) if _has_arpabet(self.path) else word.label
        if not plain or (plain in self.words and said == word.label):
            return self.words.get(plain, ())
        found: list[str] = []
        for one in [plain] if said == word.label else map(plain_word, said.split()):
            for part in [one] if one in self.words else split_word(one):
                found += self._pronounce_part(part, word)
        return tuple(found)

    def _pronounce_part(self, part: str, word: Interval) -> tuple[str, ...]:
        bare = part.strip("'.")
        for form in (part, bare, f"{bare}."):
            if form in self.words:
                return self.words[form]
        english = _has_arpabet(self.path)
        if bare.endswith("'s") and (stem := self.words.get(bare[:-2])) and english:
            return (*stem, *_possessive(stem[-1]))
        spelled = sound_out(bare.upper() if bare.upper() in word.label else bare) if english else ()
        if spelled:
            self._tell(f"are not in {self.path.name}, and are spelled by their letters", part)
            return spelled
        return self._replacement(part, word, english)

    def _replacement(self, part: str, word: Interval, english_phones: bool) -> tuple[str, ...]:
        if self.voice and not english_phones and can_speak():
            spoken = pronounce_words([part], self.voice)[part]
            self._tell(f"are not in {self.path.name}, and are pronounced by eSpeak NG", part)
            if spoken:
                return spoken
        if self.unknown == "silence":
            self._tell(f"are not in {self.path.name}, and are shown as silence", part)
            return ("sil",)
        if self.unknown == "nearest":
            from difflib import get_close_matches

            self._compared += len(self.words)
            if self._compared > max(MOST_COMPARED, len(self.words)):
                raise self.source.error(
                    f"has too many words that are not in {self.path}; add them there, or leave them out with "
                    "--on-unknown-label silence"
                )
            if near := get_close_matches(part, self.words, 1, cutoff=0.5):
                self._tell(f"are not in {self.path.name}, and are shown as {near[0]!r}", part)
                return self.words[near[0]]
        place = f'word "{quote_label(word.label)}" at {word.start:.2f} s'
        raise self.source.error(
            f"{place} is not in {self.path}; add it there, or leave it out with --on-unknown-label silence"
        )

    def _tell(self, what: str, word: str) -> None:
        self._told.setdefault(what, Counter())[word] += 1


@lru_cache(maxsize=4)
def _has_arpabet(path: Path) -> bool:
    """Whether a dictionary's phones are those of CMU, judged by its first words."""
    english = load_language("english")
    some = islice(load_pronunciations(path).values(), LOOKED_AT)
    phones = [phone for spoken in some for phone in spoken]
    known = sum(phone.isascii() and english.resolve_listed(phone) is not None for phone in phones)
    return known >= ENOUGH_ARPABET * len(phones)


def _possessive(last: str) -> tuple[str, ...]:
    bare = last.rstrip("012").upper()
    if bare in _HISSING:
        return ("IH", "Z")
    return ("S",) if bare in _VOICELESS else ("Z",)
