"""Label files of xwaves, ESPS, Festival and EMU: a header, a line "#", then end time, colour and label."""

from __future__ import annotations

import re

from phonanim.readers._rows import from_ends, lines, split
from phonanim.speech.alignment import Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "xwaves labels"

_ROW = re.compile(r"(\d+(?:\.\d*)?)\s+(-?\d+)\s*(.*)")


def recognizes(source: AlignmentFile) -> bool:
    """Whether a line "#" ends a header, and the first row after it has a time, a colour and a label."""
    rows = lines(source)
    if "#" not in rows[:40]:
        return False
    after = rows[rows.index("#") + 1 :]
    return bool(after and _ROW.fullmatch(after[0]))


def read(source: AlignmentFile) -> Recording:
    """The one tier of the file, with the name in its header if there is one."""
    rows = lines(source)
    first = rows.index("#")
    separator = next((row.split()[1] for row in rows[:first] if re.match(r"separator\s+\S", row)), ";")
    matches = split(source, _ROW, rows[first + 1 :])
    labels = [(float(match[1]), match[3].split(separator)[0].strip()) for match in matches]
    # A label at 0 marks the start of the file.
    intervals = from_ends([(time, label) for time, label in labels if time > 0])
    if not intervals:
        raise source.error("has no labels; align the recording again")
    return Recording((Tier("labels", intervals),), 0.0, intervals[-1].end)
