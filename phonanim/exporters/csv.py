"""Live Link Face CSV, as Epic's app records and Unreal, Blender and Maya tools read it."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.animation.timecode import Timecode, timecode_for_label
from phonanim.core.files import write_text
from phonanim.errors import OptionError, OutputError
from phonanim.exporters._curves import estimate_rate
from phonanim.exporters._livelink import N_ARKIT, columns, turns

SUMMARY = "Live Link Face: a row per frame, ARKit controls by name (rigs with ARKit controls)"
NOMINAL = 60  # the app's timecode counts 60 frames per second, whatever the rate of the rows


def write(animation: Animation, path: Path, timecode: str | None = None) -> None:
    """Write one row per frame; controls that the rig lacks are zero, controls that ARKit lacks are left out.

    Turns of head and eyes are degrees in the animation and radians in the file, as the app writes them.
    `timecode` is that of time zero; else the one that the animation was read with, or 00:00:00:00. With `;`
    before its frames it counts drop-frame.
    Raises OutputError when the rig has no ARKit control or the destination cannot be written, OptionError
    when the timecode is none.
    """
    names = columns()
    if not set(names[:N_ARKIT]) & set(animation.channels):
        raise OutputError(
            f"{path}: the rig {animation.rig} has no ARKit control; choose --rig arkit or another suffix"
        )
    values = np.zeros((len(animation.values), len(names)))
    for column, name in enumerate(names):
        if name in animation.channels:
            curve = animation.channel(name).astype(np.float64)
            values[:, column] = np.radians(curve) if name in turns() else curve
    first = timecode or str(animation.provenance.get("timecode", "00:00:00:00"))
    clock = timecode_for_label(first, NOMINAL)
    origin = clock.parse(first)
    codes = [clock.format(origin + time) for time in animation.times]
    row = ",".join(["%s", str(len(names)), *["%.10f"] * len(names)])
    lines = [",".join((*LEAD, *map(_capital, names)))]
    lines += [row % (code, *line) for code, line in zip(codes, values.tolist(), strict=True)]
    write_text(path, "\n".join(lines) + "\n")


def read(path: Path) -> Animation:
    """Read a recording on a regular grid: frames that the app dropped are filled in between their neighbours.

    Raises OutputError naming the file and the row.
    """
    rows = _rows(path)
    names = tuple(name[:1].lower() + name[1:] for name in rows[0][len(LEAD) :])
    if len(rows) < 3:
        raise OutputError(f"{path}: has fewer than two frames; record it again")
    clock = timecode_for_label(rows[1][0], NOMINAL)
    table = np.array(
        [_numbers(path, line, row, len(names), clock) for line, row in enumerate(rows[1:], start=2)]
    )
    times, values = table[:, 0], table[:, 1:]
    turned = [name in turns() for name in names]
    values[:, turned] = np.degrees(values[:, turned])
    falls = np.flatnonzero(np.diff(times) <= 0)
    if len(falls):
        raise OutputError(f"{path}, row {falls[0] + 3}: its timecode does not rise; remove the row")
    fps = estimate_rate(times)
    places = np.rint((times - times[0]) * fps)
    grid = np.arange(int(places[-1]) + 1)
    curves = [np.interp(grid, places, curve) for curve in values.T]
    about = {"input": path.name, "timecode": rows[1][0].strip()}
    return Animation(np.stack(curves, axis=1).astype(np.float32), names, fps, "arkit", provenance=about)


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


def _numbers(path: Path, line: int, row: list[str], count: int, clock: Timecode) -> list[float]:
    """Seconds and values of a row."""
    try:
        values = [clock.parse(row[0]), *map(float, row[len(LEAD) :])]
    except (ValueError, OptionError) as error:
        raise OutputError(f"{path}, row {line}: {error}") from error
    if len(values) != 1 + count or not np.isfinite(values).all():
        raise OutputError(f"{path}, row {line}: needs {count} finite numbers after the timecode")
    return values


LEAD = ("Timecode", "BlendShapeCount")
