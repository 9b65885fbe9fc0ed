"""Names of languages: ISO 639-1 and 639-3, BCP 47, English, native, and names of aligners' models.

lexicon/language_names.tsv has the codes and names of each language file, and its weight: how common
alignments in the language are, which decides where labels do not.
"""

from __future__ import annotations

import re
import unicodedata
from functools import cache

from phonanim.core.lexicon import LEXICON, find_tables

LONGEST = 64
"""Characters of the name of a language file."""


AUTO = "auto"


def is_auto(name: str) -> bool:
    """Whether the labels decide on the language: "auto", or "auto:" with the languages that are expected."""
    return name == AUTO or name.startswith(f"{AUTO}:")


def expected_languages(name: str) -> tuple[str, ...]:
    """The languages that "auto:japanese" or "auto:french+german" expects, as they are named; else ()."""
    return tuple(part for part in name.partition(":")[2].split("+") if part) if is_auto(name) else ()


def one_expected(name: str) -> str:
    """The language that "auto:japanese" expects; "" where there is none, or more than one."""
    expected = expected_languages(name)
    return expected[0] if len(expected) == 1 else ""


def language_names() -> tuple[str, ...]:
    """The languages of the package, then those on PHONANIM_PATH."""
    return tuple(find_tables("languages"))


def find_language(name: str) -> str | None:
    """The language file that a name stands for; None when there is none.

    Examples:
        >>> [find_language(name) for name in ("jpn", "Français", "de-AT", "german_mfa", "zh-yue")]
        ['japanese', 'french', 'german', 'german', 'cantonese']
    """
    if name.isidentifier() and len(name) < LONGEST and (LEXICON / "languages" / f"{name}.toml").is_file():
        return name
    stems = language_names()
    known = {simplify(stem): stem for stem in stems}
    known |= {key: stem for key, stem in _named().items() if stem in stems}
    whole = simplify(name)
    parts = [part for part in re.split(r"[\s_\-.,()]+", whole) if part]
    pairs = ["-".join(parts[:n]) for n in range(len(parts), 0, -1)]  # the longest tag first
    spelled = [part for part in parts if len(part) > 3]  # "Brazilian Portuguese"
    region = f"{parts[0]}-{parts[-1]}" if len(parts) > 2 else ""  # without the script: zh-Hant-HK
    candidates = (whole, whole.replace("-", "_"), region, *pairs, *reversed(spelled))
    return next((known[candidate] for candidate in candidates if candidate in known), None)


def simplify(name: str) -> str:
    """A name without case, accents and outer blanks."""
    letters = unicodedata.normalize("NFKD", name.strip().casefold())
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


@cache
def language_weights() -> dict[str, float]:
    """How common alignments in each language are, against the others."""
    return {stem: float(weight) for stem, weight, *_ in _rows()}


@cache
def _rows() -> tuple[list[str], ...]:
    lines = (LEXICON / "language_names.tsv").read_text("utf-8").splitlines()[1:]
    return tuple(line.split("\t") for line in lines)


@cache
def _named() -> dict[str, str]:
    found: dict[str, str] = {}
    for stem, _, codes, names in _rows():
        for name in (*codes.split(), *names.split(", ")):
            found.setdefault(simplify(name), stem)
    return found
