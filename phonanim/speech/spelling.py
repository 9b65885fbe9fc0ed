"""Letters to sounds for English words that no dictionary has, by the table lexicon/english_spelling.csv.

The table has the phones of a letter in contexts of growing length; the longest context that it has decides
(Daelemans and van den Bosch, 1997). `scripts/fit_spelling.py` fits it to the CMU pronouncing dictionary.
"""

from __future__ import annotations

import csv
import re
import unicodedata
from functools import cache

from phonanim.core.lexicon import LEXICON

SpellingTable = dict[str, str]

CONTEXTS = ((0, 0), (0, 1), (1, 1), (1, 2), (2, 2), (2, 3), (3, 3), (4, 4))
"""Letters to the left and right of a letter, from the shortest context to the longest."""

EDGE = "_"

LETTERS = {
    **{"a": "EY", "b": "B IY", "c": "S IY", "d": "D IY", "e": "IY", "f": "EH F", "g": "JH IY", "h": "EY CH"},
    **{"i": "AY", "j": "JH EY", "k": "K EY", "l": "EH L", "m": "EH M", "n": "EH N", "o": "OW", "p": "P IY"},
    **{
        "q": "K Y UW",
        "r": "AA R",
        "s": "EH S",
        "t": "T IY",
        "u": "Y UW",
        "v": "V IY",
        "w": "D AH B AH L Y UW",
    },
    **{"x": "EH K S", "y": "W AY", "z": "Z IY"},
}
"""The names of the letters, for what is said letter by letter."""


def sound_out(word: str) -> tuple[str, ...]:
    """The ARPAbet phones of an English word by its letters; empty when it has none of a to z.

    Accents are dropped. A word without a vowel, or of capitals such as "UFO", is said letter by letter.
    """
    plain = "".join(c for c in unicodedata.normalize("NFD", word) if unicodedata.category(c) != "Mn")
    letters = re.sub("[^a-z]", "", plain.lower())
    if len(letters) < sum(c.isalpha() for c in plain):
        return ()  # other letters are in it
    named = len(letters) > 1 and plain.isupper() and len(letters) <= 5
    if named or not re.search("[aeiouy]", letters):
        return tuple(phone for letter in letters for phone in LETTERS[letter].split())
    return spell_word(letters, _table())


def spell_word(letters: str, table: SpellingTable) -> tuple[str, ...]:
    """The phones of letters from a to z, without repeats of a consonant."""
    phones: list[str] = []
    for place in range(len(letters)):
        for phone in _phones_of(letters, place, table):
            if not (phones and phones[-1] == phone and phone[0] not in "AEIOU"):
                phones.append(phone)
    return tuple(phones)


def _phones_of(letters: str, place: int, table: SpellingTable) -> list[str]:
    contexts = (context_of(letters, place, sizes) for sizes in reversed(CONTEXTS))
    return next((table[context] for context in contexts if context in table), "").split()


def context_of(word: str, place: int, sizes: tuple[int, int]) -> str:
    """A letter with those around it, as in "e<a>t_"."""
    before, after = sizes
    left = (EDGE * before + word[:place])[-before:] if before else ""
    right = (word[place + 1 :] + EDGE * after)[:after]
    return f"{left}<{word[place]}>{right}"


@cache
def _table() -> SpellingTable:
    with (LEXICON / "english_spelling.csv").open(encoding="utf-8", newline="") as file:
        return {row["context"]: row["phones"] for row in csv.DictReader(file)}
