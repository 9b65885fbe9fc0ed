"""Annosoft and SAPI lip sync (.anno): lines of `phn` and `word` with start and end in milliseconds."""

from __future__ import annotations

import re

from phonanim.readers._rows import lines
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile, quote_label

FORMAT = "Annosoft lip sync (.anno)"

_PHONE = re.compile(r"^phn\s+\d+\s+\d+\s+\S+\s+\S+", re.MULTILINE)
_TEXT = re.compile(r"%%-begin-anno-text-%%.*?(?:%%-end-anno-text-%%|\Z)", re.DOTALL)
PHONES = {"x": "", "h": "HH", "j": "JH"}
"""Labels that are not those of ARPAbet; x is silence."""


def recognizes(source: AlignmentFile) -> bool:
    """Whether there is a line of a phone near the beginning, outside the text that is spoken."""
    return bool(_PHONE.search(_TEXT.sub("", source.text[:4000])))


def read(source: AlignmentFile) -> Recording:
    """The phones, which are those of English, and the words."""
    phones: list[Interval] = []
    words: list[Interval] = []
    for line in lines(AlignmentFile(source.name, source.stem, _TEXT.sub("", source.text).encode())):
        kind, *rest = line.split()
        try:
            if kind == "phn":
                phones.append(_interval(rest[0], rest[1], PHONES.get(rest[3], rest[3])))
            elif kind == "word":
                words.append(_interval(rest[0], rest[1], " ".join(rest[2:])))
        except DAMAGE as error:
            raise source.error(f'has a damaged line "{quote_label(line)}"; export it again') from error
    end = max(one.end for one in (*phones, *words))
    tiers = (Tier("words", tuple(words), 1), Tier("phones", tuple(phones), 2))
    return Recording(tuple(one for one in tiers if one.intervals), 0.0, end, (), "english", unit=1e-3)


def _interval(start: str, end: str, label: str) -> Interval:
    return Interval(label, int(start) / 1000, int(end) / 1000)
