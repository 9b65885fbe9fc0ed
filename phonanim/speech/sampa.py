"""Convert X-SAMPA, the keyboard form of IPA, by the table lexicon/sampa.tsv (J. C. Wells, 1995)."""

from __future__ import annotations

import re
from functools import cache

from phonanim.core.lexicon import LEXICON


def to_ipa(label: str) -> str:
    """The label in IPA; empty when any part of it is not X-SAMPA."""
    return "".join(_table()[part] for part in split_sampa(label))


def split_sampa(label: str) -> tuple[str, ...]:
    """The symbols and marks of a label, the longest first; () when any part of it is not X-SAMPA."""
    parts = _pattern().findall(label.strip())
    return tuple(parts) if "".join(parts) == label.strip() else ()


@cache
def _pattern() -> re.Pattern[str]:
    longest_first = sorted(_table(), key=len, reverse=True)
    return re.compile("|".join(map(re.escape, longest_first)))


@cache
def _table() -> dict[str, str]:
    lines = (LEXICON / "sampa.tsv").read_text("utf-8").splitlines()[1:]
    return dict(line.split("\t") for line in lines)
