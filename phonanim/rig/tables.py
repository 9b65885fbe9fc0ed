"""The tables beside a rig: hinge maps, and maps from one rig's controls to another's."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, read_utf8
from phonanim.core.files import write_text
from phonanim.core.lexicon import LEXICON
from phonanim.errors import RigError
from phonanim.rig.rig import Array, HingeMap
from phonanim.speech.inventory import INVENTORY

VISEME_SHAPES = LEXICON / "rigs" / "viseme_shapes.csv"
VRM = {"aa": "aa", "ih": "I", "ou": "U", "ee": "E", "oh": "O"}
"""VRM's mouth expressions and the corresponding visemes."""

MAX_BYTES = 1 << 24
LARGEST = 1e6  # of a number of a table
BASE = "base"  # the row of a hinge table that holds the constant part


def read_hinges(path: Path, controls: tuple[str, ...]) -> HingeMap:
    """Read a hinge table: hinge, offset, mode1 ..., then the controls that it moves. Raises RigError."""
    rows = _rows(path)
    header, names = rows[0], [row[0] for row in rows[1:]]
    modes = sum(column.startswith("mode") and column[4:].isdecimal() for column in header)
    if header[:2] != ["hinge", "offset"] or modes == 0 or names[:1] != [BASE]:
        raise RigError(f"{path}: needs the columns hinge, offset, mode1 ... and a first row {BASE!r}")
    values = _numbers(path, rows, first=1)
    weights = np.zeros((len(names), len(controls)))
    weights[:, _columns(path, header[2 + modes :], controls)] = values[:, 1 + modes :]
    loads, offsets = values[1:, 1 : 1 + modes], values[1:, 0]
    return HingeMap(tuple(names[1:]), loads, offsets, weights[1:], weights[0])


def write_hinges(path: Path, hinges: HingeMap, controls: tuple[str, ...]) -> None:
    """Write a hinge table with the controls that it moves, atomically."""
    used = np.flatnonzero(np.any(hinges.weights != 0, axis=0) | (hinges.base != 0))
    modes = hinges.loads.shape[1]
    header = ["hinge", "offset", *(f"mode{k + 1}" for k in range(modes)), *(controls[c] for c in used)]
    rows = [[BASE, *_digits(np.zeros(1 + modes)), *_digits(hinges.base[used])]]
    for name, offset, loads, weights in zip(
        hinges.names, hinges.offsets, hinges.loads, hinges.weights, strict=True
    ):
        rows.append([name, *_digits(np.array([offset, *loads])), *_digits(weights[used])])
    write_text(path, "\n".join(",".join(row) for row in [header, *rows]) + "\n")


def read_mixture(path: Path, source: tuple[str, ...], controls: tuple[str, ...]) -> Array:
    """Read a table of rows from, to, weight, (source controls, controls). Raises RigError."""
    rows = _rows(path)
    if rows[0] != ["from", "to", "weight"]:
        raise RigError(f"{path}: needs the columns from, to, weight")
    weights = _numbers(path, rows, first=2)[:, 0]
    table = np.zeros((len(source), len(controls)))
    origins = _columns(path, [row[0] for row in rows[1:]], source)
    table[origins, _columns(path, [row[1] for row in rows[1:]], controls)] = weights
    return table


def read_visemes(path: Path, controls: tuple[str, ...]) -> NDArray[np.int64]:
    """Read a table phone, viseme, end: the control of each half of each phone, (41, 2). Raises RigError.

    `end` is the shape of the second half, empty when it is the same.
    """
    rows = _rows(path)
    if rows[0] != ["phone", "viseme", "end"]:
        raise RigError(f"{path}: needs the columns phone, viseme, end")
    written = {row[0]: (row[1], row[2] or row[1]) for row in rows[1:]}
    missing = [phone for phone in INVENTORY.phones if phone not in written]
    if missing:
        raise RigError(f"{path}: has no row for the phone {missing[0]!r}; every phone needs a viseme")
    halves = [written[phone] for phone in INVENTORY.phones]
    return np.array([_columns(path, list(pair), controls) for pair in halves])


def read_shapes(path: Path, controls: tuple[str, ...]) -> Array:
    """Read the face of each control: viseme, mode1 ..., (controls, modes). Raises RigError."""
    rows = _rows(path)
    if rows[0][:2] != ["viseme", "mode1"]:
        raise RigError(f"{path}: needs the columns viseme, mode1 ...")
    shapes = np.zeros((len(controls), len(rows[0]) - 1))
    shapes[_columns(path, [row[0] for row in rows[1:]], controls)] = _numbers(path, rows, first=1)
    return shapes


def read_viseme_shapes(controls: tuple[str, ...]) -> tuple[tuple[str, ...], Array]:
    """The visemes as mixtures of ARKit controls: names, and weights (visemes, controls)."""
    rows = _rows(VISEME_SHAPES)
    names = tuple(dict.fromkeys(row[0] for row in rows[1:]))
    mixtures = np.zeros((len(names), len(controls)))
    places = [names.index(row[0]) for row in rows[1:]]
    mixtures[places, _columns(VISEME_SHAPES, [row[1] for row in rows[1:]], controls)] = _numbers(
        VISEME_SHAPES, rows, first=2
    )[:, 0]
    return names, mixtures


def write_shapes(path: Path, shapes: Array, controls: tuple[str, ...]) -> None:
    """Write the face of each control, atomically."""
    header = ["viseme", *(f"mode{k + 1}" for k in range(shapes.shape[1]))]
    rows = [[name, *_digits(values)] for name, values in zip(controls, shapes, strict=True)]
    write_text(path, "\n".join(",".join(row) for row in [header, *rows]) + "\n")


def _rows(path: Path) -> list[list[str]]:
    try:
        rows = list(csv.reader(io.StringIO(read_utf8(path, MAX_BYTES), newline="")))
    except (OSError, DecodeError, csv.Error) as error:
        raise RigError(f"{path}: cannot be read: {error}") from error
    if len(rows) < 2:
        raise RigError(f"{path}: needs a header and a row per line")
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(rows[0]):
            raise RigError(f"{path}, line {line}: has {len(row)} cells, the header {len(rows[0])}")
    return rows


def _numbers(path: Path, rows: list[list[str]], first: int) -> Array:
    """The cells from column `first` on; an empty cell is zero."""
    cells = []
    for line, row in enumerate(rows[1:], start=2):
        try:
            cells.append([float(cell or 0) for cell in row[first:]])
        except ValueError as error:
            raise RigError(f"{path}, line {line}: {error}; write a number") from error
    numbers = np.array(cells, np.float64)
    if not (np.abs(numbers) <= LARGEST).all():
        raise RigError(f"{path}: holds a value that is not finite, or above {LARGEST:g}; write numbers")
    return numbers


def _columns(path: Path, names: list[str], controls: tuple[str, ...]) -> list[int]:
    missing = [name for name in names if name not in controls]
    if missing:
        raise RigError(f"{path}: names the control {missing[0]!r}, which the rig does not have")
    return [controls.index(name) for name in names]


def _digits(values: Array) -> list[str]:
    """Five digits; empty for zero, so that the table is easy to read."""
    return ["" if value == 0 else f"{value:.5g}" for value in np.round(values, 5)]
