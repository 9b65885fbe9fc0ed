"""Labels in the letters of a script: kana and Hangul by their Unicode names, others by the package epitran.

lexicon/scripts.tsv has the languages of each script and the mapping of epitran for each.
"""

from __future__ import annotations

import unicodedata
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.util import find_spec
from typing import Any

from phonanim.core.lexicon import LEXICON
from phonanim.speech.ipa import ipa_symbols

LONGEST = 4
"""Letters of a label; more are a word."""

INHERENT = ("DEVANAGARI", "TAMIL", "THAI")
"""Scripts whose single consonant letters are named with a vowel that a label of one letter does not have."""


@dataclass(frozen=True, slots=True)
class Script:
    """A script as a language uses it: epitran's mapping, and letters that no other language has."""

    name: str
    language: str
    mapping: str
    own: str


@lru_cache(maxsize=4096)
def script_of(label: str) -> str:
    """The script of a label, as Unicode names it; "" for Latin, IPA and anything that is not listed."""
    for letter in label:
        if letter.isalpha() and letter not in ipa_symbols():
            first = unicodedata.name(letter, "").split(" ")[0]
            return first if first in {script.name for script in _scripts()} else ""
    return ""


def script_languages(labels: Iterable[str]) -> dict[str, float]:
    """The probability of each language, if most labels are in a script; else {}.

    Letters that one language alone has decide; without them, the first language of lexicon/scripts.tsv is
    twice as probable.
    """
    labels = list(labels)
    found = Counter(script_of(label) for label in labels)
    script, count = found.most_common(1)[0] if found else ("", 0)
    if not script or 2 * count <= len(labels):
        return {}
    text = "".join(labels)
    rows = [row for row in _scripts() if row.name == script]
    telling = [row for row in rows if set(row.own) & set(text)]
    chosen = list(dict.fromkeys(row.language for row in telling or rows))
    if len(chosen) == 1:
        return {chosen[0]: 1.0}
    return {language: (2 if n == 0 else 1) / (len(chosen) + 1) for n, language in enumerate(chosen)}


def needs_package(label: str) -> str:
    """What to install to read a label in the letters of its script, as the end of a message; else ""."""
    script = script_of(label)
    if not script or script in ("HIRAGANA", "KATAKANA", "HANGUL"):
        return ""
    if not any(row.mapping for row in _scripts() if row.name == script):
        return f"{script.capitalize()} letters are not read; give phones in IPA"
    if find_spec("epitran") is not None:
        return ""
    return f"{script.capitalize()} letters are read with pip install 'phonanim[letters]'"


@lru_cache(maxsize=4096)
def spell_letters(label: str, language: str) -> tuple[str, ...]:
    """The sounds of a label in a script, in IPA or as the language lists them; () if unknown."""
    script = script_of(label)
    if not script or len(label) > LONGEST:
        return ()
    if script in ("HIRAGANA", "KATAKANA"):
        return spell_kana(label)
    if script == "HANGUL":
        return spell_hangul(label)
    rows = [row for row in _scripts() if row.name == script and row.language == language and row.mapping]
    if not rows or find_spec("epitran") is None:
        return ()
    sounds = split_ipa(_transliterator(rows[0].mapping).transliterate(label))
    return sounds[:1] if script in INHERENT and len(label) == 1 and len(sounds) > 1 else sounds


def split_ipa(text: str) -> tuple[str, ...]:
    """IPA as single sounds, each with the marks after it."""
    sounds: list[str] = []
    for character in text:
        if character in ipa_symbols() or not sounds:
            sounds.append(character)
        else:
            sounds[-1] += character
    return tuple(sounds)


def spell_kana(label: str) -> tuple[str, ...]:
    """Kana as the romanized labels that the Japanese language lists."""
    sounds: list[str] = []
    for letter in label:
        words = unicodedata.name(letter, "").split(" ")
        name = words[-1].lower()
        if letter == "ー":
            sounds[-1:] = [sounds[-1] + ":"] if sounds and sounds[-1] in "aiueo" else sounds[-1:]
        elif name == "n":
            sounds.append("N")
        elif "SMALL" in words and name == "tu":
            sounds.append("cl")
        elif "SMALL" in words and sounds:
            sounds[-2 if len(sounds) > 1 else -1 :] = _contracted(sounds, name)
        elif "LETTER" in words:
            sounds += [part for part in (KANA.get(name, name[:-1]), name[-1]) if part]
        else:
            return ()
    return tuple(sounds)


KANA = {"si": "sh", "ti": "ch", "tu": "ts", "hu": "f", "zi": "j", "di": "j", "du": "z", "wo": "", "vu": "v"}
"""Consonants that Unicode's names write otherwise than the labels of aligners."""


def _contracted(sounds: list[str], name: str) -> list[str]:
    """A syllable with a small vowel or y: "ki" and "ya" are ky a, "fu" and "a" are f a."""
    before = sounds[-2] if len(sounds) > 1 else ""
    if not name.startswith("y"):
        return [before, name[-1]] if before else [name[-1]]
    return [before if before in ("sh", "ch", "j") else before + "y", name[-1]]


def spell_hangul(label: str) -> tuple[str, ...]:
    """Hangul syllables as the letters that the Korean language lists, without the silent initial."""
    sounds = []
    for character in unicodedata.normalize("NFD", label):
        _, _, rest = unicodedata.name(character, "").partition("HANGUL ")
        kind, _, name = rest.partition(" ")
        if kind not in ("CHOSEONG", "JUNGSEONG", "JONGSEONG") or (kind, name) == ("CHOSEONG", "IEUNG"):
            continue
        try:
            sounds.append(unicodedata.lookup(f"HANGUL LETTER {name.split('-')[0]}"))
        except KeyError:
            return ()
    return tuple(sounds)


@cache
def _transliterator(mapping: str) -> Any:
    import epitran

    return epitran.Epitran(mapping)


@cache
def _scripts() -> tuple[Script, ...]:
    lines = (LEXICON / "scripts.tsv").read_text("utf-8").splitlines()[1:]
    return tuple(Script(*line.split("\t")) for line in lines)
