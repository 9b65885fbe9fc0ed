"""IPA: parse any symbol with any diacritics into the articulation of its sounds.

lexicon/ipa.csv has the articulation of each symbol, lexicon/ipa_marks.csv the effect of each diacritic, and
lexicon/ipa_spellings.csv other spellings of IPA symbols.
"""

from __future__ import annotations

import csv
import unicodedata
from dataclasses import dataclass, replace
from functools import cache, lru_cache

from phonanim.core.lexicon import LEXICON


@dataclass(frozen=True, slots=True)
class Articulation:
    """The articulation of one sound: a row of lexicon/ipa.csv.

    In vowels and glides, `height` (0 open, 1 close) and `backness` (0 front, 1 back) describe the tongue;
    elsewhere they are NaN. `rounding` describes the lips, 0 to 1.
    """

    symbol: str
    vowel: bool
    place: str
    manner: str
    voiced: float
    height: float
    backness: float
    rounding: float
    name: str = ""


@lru_cache(maxsize=4096)
def parse_ipa(label: str) -> tuple[Articulation, ...]:
    """The sounds of a label in order, diacritics applied; empty when any character is not IPA."""
    sounds: list[Articulation] = []
    for character in _spelled(label):
        if character in ipa_symbols():
            sounds.append(ipa_symbols()[character])
        elif character not in ipa_diacritics():
            return ()
        elif sounds:
            sounds[-1:] = _marked(sounds[-1], *ipa_diacritics()[character])
    return tuple(sound for n, sound in enumerate(sounds) if n == 0 or sound != sounds[n - 1])


@cache
def ipa_symbols() -> dict[str, Articulation]:
    """The articulation of every symbol."""
    return {
        row["symbol"]: Articulation(
            symbol=row["symbol"],
            vowel=row["class"] == "vowel",
            place=row["place"],
            manner=row["manner"],
            voiced=float(row["voiced"]),
            height=float(row["height"] or "nan"),
            backness=float(row["backness"] or "nan"),
            rounding=float(row["rounding"]),
            name=row["name"],
        )
        for row in _rows("ipa.csv")
    }


@cache
def ipa_diacritics() -> dict[str, tuple[str, str]]:
    """Every diacritic, with the column that it changes (or "none", or "then" a symbol) and the value."""
    return {row["mark"]: (row["effect"], row["value"]) for row in _rows("ipa_marks.csv")}


@cache
def ipa_substitutes() -> dict[str, str]:
    """IPA for characters that are not IPA but are used as such."""
    return {row["spelling"]: row["ipa"] for row in _rows("ipa_spellings.csv")}


def _spelled(label: str) -> str:
    """The label in IPA letters and separate diacritics, without tone digits at its end."""
    label = unicodedata.normalize("NFC", label.strip()).rstrip("0123456789")
    spelled = "".join(ipa_substitutes().get(character, character) for character in label)
    return "".join(c if c in ipa_symbols() else unicodedata.normalize("NFD", c) for c in spelled)


def _marked(sound: Articulation, effect: str, value: str) -> tuple[Articulation, ...]:
    if effect == "none":
        return (sound,)
    if effect == "then":
        after = ipa_symbols()[value]
        return (sound, after) if sound.vowel or not after.vowel else (sound,)
    if effect == "place":
        return (replace(sound, place=value),)
    if effect == "central":
        return (replace(sound, backness=(sound.backness + 0.5) / 2),)
    moved = min(max(getattr(sound, effect) + float(value), 0.0), 1.0)
    return (replace(sound, **{effect: moved}),)


def _rows(name: str) -> list[dict[str, str]]:
    with (LEXICON / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
