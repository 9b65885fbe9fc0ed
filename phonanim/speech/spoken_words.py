"""Words as transcripts write them: punctuation, curly apostrophes, hyphens, numbers, signs, [MUSIC]."""

from __future__ import annotations

import re
import unicodedata

from phonanim.speech.numbers import spell_number

APOSTROPHES = "\u2019\u2018\u02bc\u00b4`\uff07\u2032"
DASHES = "\u2010\u2011\u2012\u2013\u2014\u2015\u2212"
SIGNS = {"&": "and", "%": "percent", "@": "at", "+": "plus", "=": "equals", "#": "number"}
PIECES = "\u2581\u0120"
"""Marks of the start of a word in tokens: of SentencePiece, and of byte-pair encodings."""

LONGEST = 10_000  # characters of a word that are looked at
_TRANSLATED = str.maketrans({**dict.fromkeys(APOSTROPHES, "'"), **dict.fromkeys(DASHES, "-")})
_SOUND = re.compile(r"[\[(<{*♪#].*[\])>}*♪#]|[♪♫]+", re.DOTALL)
_EDGES = "'.,;:!?\"()[]{}«»“”„‚‹›¿¡…*_~|/\\-"


def is_sound(text: str) -> bool:
    """Whether a transcript's entry is no word but a sound, such as [MUSIC], (laughs) or ♪."""
    return bool(_SOUND.fullmatch(text.strip()))


def plain_word(text: str) -> str:
    """A word in lower case with straight apostrophes and hyphens, without marks around it."""
    text = text.strip().split("\n")[0]  # what an annotator put below it is no part of the word
    word = unicodedata.normalize("NFC", text[:LONGEST])
    word = word.strip(PIECES + " \t\u00a0").translate(_TRANSLATED).lower()
    return word.strip(_EDGES.replace("'", "")) if word.strip(_EDGES) else ""


def split_word(text: str) -> list[str]:
    """The parts of a word that are said one after the other: of a hyphenated word, a number, a sign.

    Numbers and signs are read in English.
    """
    parts: list[str] = []
    for part in re.split(r"[-\s/_]+|(?<=[^\W\d_])(?=\d)|(?<=\d)(?=[&@+=#])|([&@+=#])", text):
        if not part:
            continue
        number = spell_number(part.strip(".,;:!?")) or _number_with_unit(part)
        parts += number or ([SIGNS[part]] if part in SIGNS else [part])
    return parts


def _number_with_unit(part: str) -> list[str]:
    """A number that letters follow, as in "5km"; empty for anything else."""
    found = re.fullmatch(r"(\d[\d,.]*)([^\W\d_]+)", part)
    return [*spell_number(found[1].rstrip(",.")), found[2]] if found else []
