"""SSFF, the tracks of EMU: one file per sensor of a recording; the suffix is the sensor."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import Articulation
from phonanim.ema.readers import first_bytes
from phonanim.errors import CorpusError

MARK, END = b"SSFF -- (c) SHLRC", re.compile(rb"^-{17}\r?\n", re.MULTILINE)
TYPES = {"FLOAT": "f4", "DOUBLE": "f8", "SHORT": "i2", "LONG": "i4", "CHAR": "i1", "BYTE": "u1"}
AXES = ("_posx", "_posy", "_posz")  # suffixes of the columns of a sensor's position, mm


@dataclass(frozen=True)
class Columns:
    """The columns of a file by name, (samples, width) each, at `start` + n / `rate` seconds."""

    values: dict[str, NDArray[np.float64]]
    rate: float
    start: float


def recognizes(path: Path) -> bool:
    """Whether the first bytes are those of SSFF."""
    return first_bytes(path, len(MARK)) == MARK


def read(path: Path) -> Articulation:
    """Every sensor of the recording of a file: all files of the same stem that have positions.

    A sensor's name is the file's suffix. Samples whose columns are all zero were not tracked. Raises
    CorpusError when there are no sensors, or when they differ in length or rate.
    """
    files = {p.suffix[1:]: p for p in sorted(path.parent.glob(f"{path.stem}.*")) if recognizes(p)}
    sensors = {name: columns for name, file in files.items() if _axes(columns := read_ssff(file))}
    if not sensors:
        raise CorpusError(f"{path}: has no columns that end in {', '.join(AXES)}")
    shapes = {(len(next(iter(c.values.values()))), c.rate, c.start) for c in sensors.values()}
    if len(shapes) > 1:
        raise CorpusError(f"{path}: its sensors differ in length or rate; cut them to the same length")
    _, rate, start = shapes.pop()
    positions = np.stack([_positions(columns) for columns in sensors.values()], axis=1)
    return Articulation(tuple(sensors), positions, rate, start, str(path))


def read_ssff(path: Path) -> Columns:
    """Read one file with any columns. Raises CorpusError when it is damaged."""
    head, *rest = END.split(first_bytes(path, -1), maxsplit=1)
    lines = [line.split() for line in head.decode("latin-1").splitlines()]
    fields = {words[0]: words[1] for words in lines if len(words) == 2}
    order = ">" if fields.get("Machine", "").upper() == "SPARC" else "<"
    try:
        row = np.dtype([(w[1], order + TYPES[w[2]], (int(w[3]),)) for w in lines if w and w[0] == "Column"])
        rate, start = float(fields["Record_Freq"]), float(fields.get("Start_Time", "0"))
        if not (rest and rate > 0 and row.itemsize and len(rest[0]) % row.itemsize == 0):
            raise ValueError("its rows are not whole")
    except (KeyError, IndexError, ValueError) as error:
        raise CorpusError(f"{path}: is damaged ({error}); fetch it again") from error
    table = np.frombuffer(rest[0], row)
    return Columns({name: table[name].astype(np.float64) for name in row.names or ()}, rate, start)


def _axes(columns: Columns) -> list[str]:
    """The columns of a position; empty if one is missing."""
    found = [name for axis in AXES for name in columns.values if name.endswith(axis)]
    return found if len(found) == len(AXES) else []


def _positions(columns: Columns) -> NDArray[np.float64]:
    """(samples, 3) mm, NaN where every column is zero."""
    tracked = np.any(np.column_stack(list(columns.values.values())) != 0, axis=1, keepdims=True)
    positions = np.column_stack([columns.values[name] for name in _axes(columns)])
    return np.where(tracked, positions, np.nan)
