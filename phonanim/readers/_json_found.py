"""What is found in JSON: labels with times, by place, and what names say of them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from phonanim.readers._columns import LABELS, PHONES, VISEMES, WORDS, plain_name

KINDS = {"phones": PHONES, "visemes": VISEMES, "words": WORDS, "labels": LABELS}
PAIRS = ("timestamp", "timestamps", "extent", "interval", "span", "time", "bounds")


@dataclass
class Found:
    """Entries of one place: label, start and end as numbers, NaN where one is missing, and speaker.

    `kind` is one of KINDS, `unit` the seconds of a number, None where the names do not tell, `names` how the
    file calls the label and the times. `untimed` are labels of the same place that have no times.
    """

    kind: str
    unit: float | None
    names: str
    entries: list[tuple[str, float, float, str]] = field(default_factory=list)
    untimed: list[str] = field(default_factory=list)


Groups = dict[tuple[object, ...], Found]


def last_name(path: tuple[str, ...]) -> str:
    """The last name of a path."""
    return next((part for part in reversed(path) if part != "*"), "")


@lru_cache(maxsize=256)  # the tables of a file have few names
def kind_of(name: str) -> str:
    """The kind of labels that a tier of this name has, "" where the name does not tell."""
    return next((kind for kind in ("phones", "visemes", "words") if has_word(name, KINDS[kind])), "")


def name_words(name: str) -> list[str]:
    """The words of a name such as word_start or wordStartTimes, in small letters."""
    spaced = "".join(f" {c.lower()}" if c.isupper() else c for c in name)
    return re.split(r"[^a-z0-9]+", spaced.strip())


def has_word(name: str, wanted: tuple[str, ...]) -> bool:
    """Whether a name, or a word of it, is among some."""
    return plain_name(name) in wanted or any(word in wanted for word in name_words(name))


def is_pair(value: Any) -> bool:
    """Whether a value is a list of two numbers."""
    return isinstance(value, list) and len(value) == 2 and all(isinstance(one, (int, float)) for one in value)
