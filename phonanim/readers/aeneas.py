"""Sync maps of aeneas, as JSON, CSV or text: fragments of text with begin and end in seconds."""

from __future__ import annotations

import re
from typing import Any

from phonanim.readers._rows import all_match, split
from phonanim.readers._words import SPREAD, TimedWord, check_count, spread_text, word_recording
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "aeneas sync map (JSON, CSV, text)"

_NUMBER = r"\d+\.\d+"
_ROW = re.compile(rf'(\S+?)(?:,|[ \t]+)({_NUMBER})(?:,|[ \t]+)({_NUMBER})(?:,|[ \t]+)"(.*)"')


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with fragments, or all rows are a name, two times and a text in quotes."""
    if source.json is None:
        return bool(all_match(source, _ROW))
    return isinstance(source.json, dict) and isinstance(source.json.get("fragments"), list)


def read(source: AlignmentFile) -> Recording:
    """The words; those of a fragment share its time by their letters."""
    words: list[TimedWord] = []
    end = 0.0
    try:
        fragments = _fragments(source)
        for fragment in fragments:
            begin, last = float(fragment["begin"]), float(fragment["end"])
            words += spread_text(" ".join(map(str, fragment["lines"])), begin, last)
            check_count(words)
            end = max(end, last)
    except DAMAGE as error:
        raise source.error(f"has a damaged fragment ({error!r}); align again") from error
    notes = (SPREAD,) if len(words) > len(fragments) else ()
    languages = [one.get("language") for one in fragments]
    spoken = next((name for name in languages if isinstance(name, str)), "")
    return word_recording(words, end, notes, spoken=spoken)


def _fragments(source: AlignmentFile) -> list[dict[str, Any]]:
    if source.json is not None:
        return _leaves(source.json["fragments"], 0)
    rows = split(source, _ROW)
    return [{"begin": row[2], "end": row[3], "lines": [row[4].replace('""', '"')]} for row in rows]


def _leaves(fragments: Any, depth: int) -> list[dict[str, Any]]:
    """The fragments that have no children: the words of a map of several levels."""
    leaves: list[dict[str, Any]] = []
    for fragment in fragments:
        inner = fragment.get("children") if depth < 8 else None
        leaves += _leaves(inner, depth + 1) if inner else [fragment]
    return leaves
