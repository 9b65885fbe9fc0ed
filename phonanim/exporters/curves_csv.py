"""Curves of any rig as a plain table: seconds, then every control by its name."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from io import TextIOWrapper
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.decode import DecodeError
from phonanim.core.files import atomic_path, open_plain
from phonanim.errors import OutputError
from phonanim.exporters._curves import estimate_rate
from phonanim.exporters._take import build_take, check_size, check_times

SUMMARY = "a plain table: seconds, then every control of any rig by its name"
TIME = "seconds"
NO_RIG = "curves"  # the rig of a table, which names none
UNEVEN = 0.1  # of a frame


def write(animation: Animation, path: Path) -> None:
    """Write a row per frame, with nine digits. Raises OutputError when the destination cannot be written."""
    with atomic_path(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow([TIME, *animation.channels])
        for time, values in zip(animation.times.tolist(), animation.values.tolist(), strict=True):
            rows.writerow([f"{time:.9g}", *(f"{value:.9g}" for value in values)])


def read(path: Path) -> Animation:
    """Read such a table of evenly spaced frames. Raises OutputError, which names the file and the row."""
    try:
        with open_plain(path) as data, TextIOWrapper(data, "utf-8-sig", newline="") as file:
            return _read(path, csv.reader(file))
    except DecodeError as error:
        raise OutputError(f"{path}: is not a table of curves: {error}") from error
    except (OSError, ValueError, csv.Error) as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error


def _read(path: Path, rows: Iterator[list[str]]) -> Animation:
    header = next(rows, [])
    if len(header) < 2 or header[0].strip().lower() != TIME:
        raise OutputError(f"{path}: is not a table of curves; its header must begin with {TIME},<control>")
    table = []
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise OutputError(f"{path}, row {line}: has {len(row)} cells, and the header {len(header)}")
        try:
            table.append(np.array(row, np.float64))
        except ValueError as error:
            raise OutputError(f"{path}, row {line}: {error}") from error
        check_size(len(table), len(header), path)
    if len(table) < 2:
        raise OutputError(f"{path}: has fewer than two frames; write it again")
    values = np.array(table)
    check_times(values[:, 0], TIME)
    fps = estimate_rate(values[:, 0])
    uneven = np.flatnonzero(np.abs(np.diff(values[:, 0]) * fps - 1) > UNEVEN)
    if len(uneven):
        raise OutputError(f"{path}, row {uneven[0] + 3}: its frames are not evenly spaced; write them so")
    return build_take(values[:, 1:], header[1:], fps, float(values[0, 0]), {}, path, rig=NO_RIG)
