"""HTK and HTS labels: begin and end in 100 ns, and a label; also several files in one (MLF)."""

from __future__ import annotations

import re

from phonanim.readers._rows import FEWEST_TICKS, all_match, lines, mean_span, split
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "HTK or HTS labels"
TICKS = 1e7  # per second

_MASTER = "#!MLF!#"
_ROW = re.compile(r"(\d+)\s+(\d+)\s+(\S+)(?:\s+-?[\d.]+(?:\s+(\S+))?)?")
# The phone in the middle of a context label, as in "sil^m-i+z=u/A:..." or "b-iy+m".
_CENTRE = re.compile(r"(?:[^-]*-)?([^-+]+)\+")
_STATE = re.compile(r"\[\d+\]$|_s\d$")


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
        matches = split(source, _ROW, rows)
        tiers.append(Tier("phones", _phones(matches), len(tiers) + 1, name))
        if any(match[4] for match in matches):
            tiers.append(Tier("words", _words(matches), len(tiers) + 1, name))
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


def _phones(matches: list[re.Match[str]]) -> tuple[Interval, ...]:
    """The phones in the middle of their contexts; the states of one phone are merged."""
    merged: list[Interval] = []
    context = ""
    for match in matches:
        same = _STATE.search(match[3]) and _STATE.sub("", match[3]) == context
        start = merged.pop().start if same and merged else float(match[1]) / TICKS
        context = _STATE.sub("", match[3])
        found = _CENTRE.match(context)
        merged.append(Interval(found[1] if found else context, start, float(match[2]) / TICKS))
    return tuple(merged)


def _words(matches: list[re.Match[str]]) -> tuple[Interval, ...]:
    starts = [n for n, match in enumerate(matches) if match[4]]
    ends = [*(n - 1 for n in starts[1:]), len(matches) - 1]
    return tuple(
        Interval(matches[start][4], float(matches[start][1]) / TICKS, float(matches[end][2]) / TICKS)
        for start, end in zip(starts, ends, strict=True)
    )
