"""Live Link Face CSV, as Epic's app records and Unreal, Blender and Maya tools read it."""

from __future__ import annotations

import csv
import re
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation import Animation
from phonanim.errors import OutputError
from phonanim.files import write_text
from phonanim.inventory import LEXICON

SUMMARY = "Live Link Face: a row per frame, ARKit controls by name (rigs with ARKit controls)"
LEAD = ("Timecode", "BlendShapeCount")
N_ARKIT = 52  # the first columns; head and eye turns follow
TIMECODE_RATE = 60  # the app counts 60 frames per second, whatever the rate of the rows
TIMECODE = re.compile(r"(\d+):(\d+):(\d+):(\d+(?:\.\d+)?)")
USUAL_RATES = (24000 / 1001, 24.0, 25.0, 30000 / 1001, 30.0, 48.0, 50.0, 60000 / 1001, 60.0, 90.0, 120.0)
RATE_TOLERANCE = 5e-4  # timecodes are written to a thousandth of a frame


def write(animation: Animation, path: Path) -> None:
    """Write one row per frame; controls that the rig lacks are zero, controls that ARKit lacks are left out.

    Raises OutputError when the rig has no ARKit control, or the destination cannot be written.
    """
    names = columns()
    if not set(names[:N_ARKIT]) & set(animation.channels):
        raise OutputError(
            f"{path}: the rig {animation.rig} has no ARKit control; choose --rig arkit or another suffix"
        )
    values = np.zeros((len(animation.values), len(names)))
    for column, name in enumerate(names):
        if name in animation.channels:
            values[:, column] = animation.channel(name)
    lines = [",".join((*LEAD, *map(_capital, names)))]
    row = ",".join(["%s", str(len(names)), *["%.10f"] * len(names)])
    lines += [
        row % (timecode(time), *line) for time, line in zip(animation.times, values.tolist(), strict=True)
    ]
    write_text(path, "\n".join(lines) + "\n")


def read(path: Path) -> Animation:
    """Read a recording on a regular grid: frames that the app dropped are filled in between their neighbours.

    Raises OutputError naming the file and the row.
    """
    rows = _rows(path)
    names = tuple(name[:1].lower() + name[1:] for name in rows[0][len(LEAD) :])
    times = np.array([_seconds(path, line, row) for line, row in enumerate(rows[1:], start=2)])
    values = np.array([_numbers(path, line, row, len(names)) for line, row in enumerate(rows[1:], start=2)])
    if len(times) < 2 or np.any(np.diff(times) <= 0):
        raise OutputError(f"{path}: needs two rows or more whose timecodes rise; record it again")
    fps = rate_of(times)
    places = np.rint((times - times[0]) * fps)
    grid = np.arange(int(places[-1]) + 1)
    curves = [np.interp(grid, places, curve) for curve in values.T]
    return Animation(np.stack(curves, axis=1).astype(np.float32), names, fps, "arkit", start=float(times[0]))


@cache
def columns() -> tuple[str, ...]:
    """Control names in the order of the file, in Apple's spelling."""
    lines = (LEXICON / "formats" / "livelink.txt").read_text(encoding="utf-8").split("\n")
    return tuple(line[:1].lower() + line[1:] for line in lines if line and not line.startswith("#"))


def timecode(time: float) -> str:
    """Seconds as hours:minutes:seconds:frames, with thousandths of a frame; a day starts anew."""
    frames, fraction = divmod(round(time * TIMECODE_RATE * 1000), 1000)
    seconds, frame = divmod(frames, TIMECODE_RATE)
    minutes, second = divmod(seconds, 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours % 24:02}:{minute:02}:{second:02}:{frame:02}.{fraction:03}"


def rate_of(times: NDArray[np.float64]) -> float:
    """Frames per second of rising times, as the usual rate if one is near."""
    rate = 1 / float(np.median(np.diff(times)))
    nearest = min(USUAL_RATES, key=lambda usual: abs(usual - rate))
    return nearest if abs(nearest - rate) < RATE_TOLERANCE * rate else rate


def _capital(name: str) -> str:
    return name[:1].upper() + name[1:]


def _rows(path: Path) -> list[list[str]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error
    if not rows or tuple(rows[0][: len(LEAD)]) != LEAD:
        raise OutputError(
            f"{path}: is no Live Link Face recording; its header must begin with {','.join(LEAD)}"
        )
    return rows


def _seconds(path: Path, line: int, row: list[str]) -> float:
    found = TIMECODE.fullmatch(row[0].strip())
    if not found:
        raise OutputError(f"{path}, row {line}: {row[0]!r} is no timecode; write it as 00:00:01:30.000")
    hours, minutes, seconds, frames = map(float, found.groups())
    return hours * 3600 + minutes * 60 + seconds + frames / TIMECODE_RATE


def _numbers(path: Path, line: int, row: list[str], count: int) -> list[float]:
    try:
        values = [float(cell) for cell in row[len(LEAD) :]]
    except ValueError as error:
        raise OutputError(f"{path}, row {line}: {error}; write numbers alone") from error
    if len(values) != count or not np.isfinite(values).all():
        raise OutputError(f"{path}, row {line}: needs {count} finite numbers after the timecode")
    return values
