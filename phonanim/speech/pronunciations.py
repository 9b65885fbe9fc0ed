"""Pronunciation dictionaries: convert words with times into phones when there is no phone tier."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from phonanim.errors import AlignmentError
from phonanim.speech.alignment_file import AlignmentFile, quote_label
from phonanim.speech.intervals import Interval, Recording, Tier
from phonanim.speech.labels import is_silent
from phonanim.speech.tiers import PHONE_NAMES, WORD_NAMES, best_named_tiers, speaker_of

NOTE = "the phones come from a dictionary and share the time of each word equally"

# Dictionaries of the Montreal Forced Aligner may have probabilities between the word and its phones.
_PROBABILITY = re.compile(r"\d+\.\d+")
_VARIANT = re.compile(r"\(\d+\)$")


@lru_cache(maxsize=4)
def load_pronunciations(path: Path) -> Mapping[str, tuple[str, ...]]:
    """The first pronunciation of each word. Each line has a word and its phones, as CMU and MFA write them.

    A file is read once per process, since reading takes longer than animating most lines. Raises
    AlignmentError when it cannot be read or has no entries.
    """
    try:
        text = path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise AlignmentError(f"{path}: cannot be read: {reason}") from error
    words: dict[str, tuple[str, ...]] = {}
    for line in text.splitlines():
        word, *phones = line.split() or [""]
        spoken = tuple(phone for phone in phones if not _PROBABILITY.fullmatch(phone))
        if spoken and not word.startswith(";;;"):
            words.setdefault(_VARIANT.sub("", word).lower(), spoken)
    if not words:
        raise AlignmentError(f"{path}: has no line of a word and its phones; name a pronunciation dictionary")
    return words


def spell_out(recording: Recording, path: Path, source: AlignmentFile) -> Recording:
    """The recording with a phone tier next to each word tier, if it has no phone tier yet.

    Raises AlignmentError for a word that the dictionary lacks, with its time.
    """
    word_tiers = best_named_tiers(recording.tiers, WORD_NAMES)
    if best_named_tiers(recording.tiers, PHONE_NAMES) or not word_tiers:
        return recording
    words = load_pronunciations(path)
    spelled = [
        Tier("phones", _spelled(tier, words, path, source), len(recording.tiers) + n, speaker_of(tier))
        for n, tier in enumerate(word_tiers, 1)
    ]
    return replace(recording, tiers=(*recording.tiers, *spelled), notes=(*recording.notes, NOTE))


def _spelled(
    tier: Tier, words: Mapping[str, tuple[str, ...]], path: Path, source: AlignmentFile
) -> tuple[Interval, ...]:
    phones: list[Interval] = []
    for interval in tier.intervals:
        word = interval.label.lower().strip('.,;:!?"()[]«»“”¿¡')
        if is_silent(interval.label):
            phones.append(interval)
        elif word in words:
            phones += _shared(interval, words[word])
        else:
            place = f'word "{quote_label(interval.label)}" at {interval.start:.2f} s'
            raise source.error(f"{place} is not in {path}; add it there")
    return tuple(phones)


def _shared(interval: Interval, phones: tuple[str, ...]) -> list[Interval]:
    step = (interval.end - interval.start) / len(phones)
    bounds = [interval.start + step * n for n in range(len(phones))] + [interval.end]
    return [Interval(phone, bounds[n], bounds[n + 1]) for n, phone in enumerate(phones)]
