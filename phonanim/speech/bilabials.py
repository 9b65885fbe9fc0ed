"""Labels that say by their letters that the lips shut, whatever they were read as."""

from __future__ import annotations

import unicodedata
from functools import cache, lru_cache

from phonanim.core.lexicon import LEXICON
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.labels import BRACKETS, LONGEST, Language, is_silent
from phonanim.speech.phones import PhoneTrack

SHUT = ("p", "b", "m")
"""The phones of the inventory with shut lips."""


@lru_cache(maxsize=4096)
def says_shut(label: str, language: Language | None = None) -> bool:
    """Whether a label begins with a letter of p, b or m in any script.

    A label that the language lists with another meaning, as Vietnamese lists `ph`, does not say it; nor does
    X-SAMPA with a capital or a backslash, which are other sounds.
    """
    label = label[:LONGEST]
    letters = unicodedata.normalize("NFKD" if label.isascii() else "NFC", label.strip().strip(BRACKETS))
    if not letters or is_silent(label) or "\\" in letters:
        return False
    if language is not None and (label in language.own_labels or letters in language.own_labels):
        return False
    if language is not None and language.alphabets == ("SAMPA",) and not letters[0].islower():
        return False
    first = unicodedata.normalize("NFD", letters[0].lower())[0]
    return letters[0] in _letters() or first in _letters()


def shut_segments(track: PhoneTrack, language: Language | None = None) -> list[int]:
    """The segments with shut lips: p, b and m, and labels that say so but were read otherwise."""
    codes = set(INVENTORY.codes(SHUT).tolist())
    found = [n for n, code in enumerate(track.codes.tolist()) if code in codes]
    begin = 0
    for end in range(1, len(track.labels) + 1):
        if end < len(track.labels) and track.labels[end] == track.labels[begin]:
            continue
        if says_shut(track.labels[begin], language) and not codes & set(track.codes[begin:end].tolist()):
            found.append(begin)
        begin = end
    return sorted(found)


@cache
def _letters() -> frozenset[str]:
    lines = (LEXICON / "bilabials.tsv").read_text("utf-8").splitlines()[1:]
    return frozenset(letter for line in lines for letter in line.split("\t")[1].split())
