"""HTK and HTS labels: begin and end in 100 ns, and a label; also several files in one (MLF)."""

from __future__ import annotations

import re
from typing import NamedTuple

from phonanim.readers._rows import FEWEST_TICKS, all_match, lines, mean_span, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "HTK or HTS labels"
TICKS = 1e7  # per second

_MASTER = "#!MLF!#"
_ROW = re.compile(r"(\d+)\s+(\d+)\s+(\S+)(?:\s+-?[\d.]+((?:\s+\S+){0,3}))?")
_SCORE = re.compile(r"-?\d+(?:\.\d+)?")
# The phone in the middle of a context label, as in "sil^m-i+z=u/A:..." or "b-iy+m".
_CENTRE = re.compile(r"(?:[^-]*-)?([^-+]+)\+")
_STATE = re.compile(r"\[\d+\]$|_s\d$")
_BARE_STATE = re.compile(r"s\d{1,2}|\S+\[\d+\]")  # of HVite -f: its model follows, where one begins


class Row(NamedTuple):
    """A row in seconds: the model ("" for another state of the last one), and the word that begins there."""

    start: float
    end: float
    model: str
    state: bool
    word: str


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows are two whole numbers and a label, with numbers too far apart to count samples."""
    if source.text.startswith(_MASTER):
        return True
    rows = all_match(source, _ROW)
    return bool(rows) and mean_span(rows) >= FEWEST_TICKS


def read(source: AlignmentFile) -> Recording:
    """The phones, and the words if there is a fifth column; a master file has such a pair for each file."""
    tiers: list[Tier] = []
    for name, rows in _files(source):
        found = list(map(_row, split(source, _ROW, rows)))
        tiers.append(Tier("phones", _phones(found), len(tiers) + 1, name))
        if any(row.word for row in found):
            tiers.append(Tier("words", _words(found), len(tiers) + 1, name))
    end = max((interval.end for tier in tiers for interval in tier.intervals), default=0.0)
    return Recording(tuple(tiers), 0.0, end, unit=1 / TICKS)


def _files(source: AlignmentFile) -> list[tuple[str, list[str]]]:
    if not source.text.startswith(_MASTER):
        return [("", lines(source))]
    files: list[tuple[str, list[str]]] = []
    for line in lines(source)[1:]:
        if line.startswith('"'):
            files.append((re.sub(r"^.*/|\.\w+$", "", line.strip('"')), []))
        elif line != "." and files:
            files[-1][1].append(line)
    return files


def _phones(rows: list[Row]) -> tuple[Interval, ...]:
    """The phones in the middle of their contexts; the states of one phone are merged."""
    merged: list[Interval] = []
    context = ""
    for row in rows:
        same = row.state and merged and row.model in ("", context)
        start = merged.pop().start if same else row.start
        context = row.model or context
        found = _CENTRE.match(context)
        merged.append(Interval(found[1] if found else context, start, row.end))
    return tuple(merged)


def _words(rows: list[Row]) -> tuple[Interval, ...]:
    starts = [n for n, row in enumerate(rows) if row.word]
    ends = [*(n - 1 for n in starts[1:]), len(rows) - 1]
    return tuple(
        Interval(rows[start].word, rows[start].start, rows[end].end)
        for start, end in zip(starts, ends, strict=True)
    )


def _row(match: re.Match[str]) -> Row:
    """A row; of one of a state, the model that begins with it, where one does, stands behind its score."""
    names = [part for part in (match[4] or "").split() if not _SCORE.fullmatch(part)]
    label, state = match[3], bool(_STATE.search(match[3]))
    if _BARE_STATE.fullmatch(label) and (names or (label[0] == "s" and "[" not in label)):
        model, names = (names[0], names[1:]) if names else ("", [])
        return Row(float(match[1]) / TICKS, float(match[2]) / TICKS, model, not model, "".join(names[:1]))
    bare = _STATE.sub("", label)
    return Row(float(match[1]) / TICKS, float(match[2]) / TICKS, bare, state, "".join(names[:1]))
