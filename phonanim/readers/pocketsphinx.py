"""Output of Sphinx: JSON with begin (b), duration (d) and text (t), rows of words, segments in frames."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import takewhile
from typing import Any

from phonanim.readers._rows import ROWS_LOOKED_AT, lines, match_row
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "pocketsphinx output"

_ROW = re.compile(r"(\S+)\s+(\d+\.\d+)\s+(\d+\.\d+)\s+(-?\d+(?:\.\d+)?(?:e[-+]\d+)?)")
_VARIANT = re.compile(r"\(\d+\)$")
FRAME = 0.01  # seconds
ENOUGH_ROWS = 0.5  # share of lines that are rows: the text of each utterance stands before them

# sphinx3_align and sphinx_align write .wdseg and .phseg; -backtrace yes writes words to the log.
_SEGMENTED = re.compile(r"^\s*SFrm\s+EFrm\s+SegAScr\s+(Word|Phone)\s*$", re.MULTILINE)
_SEGMENT = re.compile(r"\s*(\d+)\s+(\d+)\s+-?\d+\s+(\S+).*")
_TRACED = re.compile(r"^word\s+start\s+end\s+pprob\s+ascr\s+lscr\s+lback\s*$", re.MULTILINE)
_TRACE = re.compile(r"(\S+)\s+(\d+)\s+(\d+)\s+\S+\s+-?\d+\s+-?\d+\s+-?\d+\s*")


def recognizes(source: AlignmentFile) -> bool:
    """Whether each value is an utterance of this kind, or all rows are a word, its times and a confidence."""
    if source.json_lines:
        return all(isinstance(line, dict) and {"b", "d", "t", "w"} <= line.keys() for line in _values(source))
    if _SEGMENTED.search(source.text[:4000]) or _TRACED.search(source.text):
        return True
    first = lines(source)[:ROWS_LOOKED_AT]
    rows = [match for line in first if (match := match_row(_ROW, line))]
    enough = len(rows) >= ENOUGH_ROWS * len(first)
    return enough and any(row[1] in ("<s>", "<sil>", "</s>") for row in rows)


def read(source: AlignmentFile) -> Recording:
    """The words, and the phones if the aligner was asked for them."""
    if not source.json_lines:
        return _from_text(source)
    try:
        words = list(_items(_values(source)))
        phones = [phone for line in _values(source) for phone in _items(line["w"])]
        end = max(float(line["b"]) + float(line["d"]) for line in _values(source))
    except DAMAGE as error:
        raise source.error(f"has a damaged word ({error!r}); recognize again") from error
    tiers = [Tier("words", tuple(words), 1)]
    if phones:
        tiers.append(Tier("phones", tuple(phones), 2))
    return Recording(tuple(tier for tier in tiers if tier.intervals), 0.0, end)


def _values(source: AlignmentFile) -> list[Any]:
    """The utterances, of a list too."""
    values = source.json_lines
    return values[0] if len(values) == 1 and isinstance(values[0], list) else values


def _rows(source: AlignmentFile) -> list[re.Match[str]]:
    return [match for line in lines(source) if (match := match_row(_ROW, line))]


def _from_text(source: AlignmentFile) -> Recording:
    """Rows of words, in seconds; or segments of words or phones, in frames."""
    header = _SEGMENTED.search(source.text[:4000])
    if header:
        matches = [match for line in lines(source) if (match := match_row(_SEGMENT, line))]
        found = [(match[3], int(match[1]), int(match[2])) for match in matches]
    elif traced := _TRACED.search(source.text):
        after = source.text[traced.end() :].strip("\n").split("\n")
        matches = [match for line in takewhile(_is_trace, after) if (match := match_row(_TRACE, line))]
        found = [(match[1], int(match[2]), int(match[3])) for match in matches]
    else:
        rows = [Interval(_plain(m[1]), float(m[2]), float(m[3])) for m in _rows(source)]
        return Recording((Tier("words", tuple(rows)),), 0.0, rows[-1].end)
    if not found:
        raise source.error("has no segments; align again")
    name = "phones" if header and header[1] == "Phone" else "words"
    intervals = tuple(Interval(_plain(label), a * FRAME, (b + 1) * FRAME) for label, a, b in found)
    return Recording((Tier(name, intervals),), 0.0, intervals[-1].end, unit=FRAME)


def _is_trace(line: str) -> bool:
    return bool(match_row(_TRACE, line))


def _items(entries: list[Any]) -> Iterator[Interval]:
    """The entries within each of these entries."""
    for line in entries:
        for item in line.get("w") or ():
            start = float(item["b"])
            yield Interval(_plain(str(item["t"])), start, start + float(item["d"]))


def _plain(text: str) -> str:
    return _VARIANT.sub("", text)
