"""Live Link Face CSV, as Epic's app records and Unreal, Blender and Maya tools read it."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from io import TextIOWrapper
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.timecode import Timecode, timecode_for_label
from phonanim.core.decode import DecodeError
from phonanim.core.files import atomic_path, open_plain
from phonanim.errors import OptionError, OutputError
from phonanim.exporters._curves import estimate_rate
from phonanim.exporters._decimals import CELL, LARGEST, decimal_cells, number_cells
from phonanim.exporters._livelink import N_ARKIT, columns, turns
from phonanim.exporters._take import build_take, check_size, sample_curves, take_grid

SUMMARY = "Live Link Face: a row per frame, ARKit controls by name (rigs with ARKit controls)"
RIG = "arkit"
LEAD = ("Timecode", "BlendShapeCount")
ZERO = b"0.0000000000,"  # for every control that the rig lacks
LABEL = ("00:00:00", "00.000")  # before and after the mark of drop-frame counting
LABEL_PLACES = (0, 3, 6, 9, 12)
PIECE = 1024  # rows that are formatted at a time
NOMINAL = 60  # the app's timecode counts 60 frames per second, independent of the rate of the rows


def write(animation: Animation, path: Path, timecode: str | None = None) -> None:
    """Write one row per frame; controls that the rig lacks are zero, controls that ARKit lacks are left out.

    Rotations of head and eyes are degrees in the animation and radians in the file, as in the app's files.
    `timecode` is that of time zero; the default is the one that was read with the animation, or 00:00:00:00.
    With `;` before its frames it counts drop-frame. Raises OutputError when the rig has no ARKit control or
    the destination cannot be written, OptionError when the timecode is invalid.
    """
    names = columns()
    if not fits(animation.channels):
        raise OutputError(
            f"{path}: the rig {animation.rig} has no ARKit control; choose --rig arkit, or .curves.csv"
        )
    first = timecode or str(animation.provenance.get("timecode", "00:00:00:00"))
    clock = timecode_for_label(first, NOMINAL)
    origin = clock.parse(first)
    header = ",".join((*LEAD, *map(_capital, names)))
    with atomic_path(path) as partial, partial.open("wb") as file:
        file.write(f"{header}\n".encode())
        for rows in _pieces(animation, names, clock, origin):
            file.write(rows)


def fits(channels: Sequence[str]) -> bool:
    """Whether a channel is one of ARKit's 52 controls."""
    return not set(columns()[:N_ARKIT]).isdisjoint(channels)


def _pieces(animation: Animation, names: tuple[str, ...], clock: Timecode, origin: float) -> Iterator[bytes]:
    """The rows as text, in pieces; controls that never move have the same text in every row."""
    values = animation.values
    written = np.flatnonzero(values.view(f"u{values.itemsize}").any(axis=0))  # a negative zero, too
    moving = {animation.channels[column] for column in written.tolist()}
    cells = [bytes(CELL) if name in moving else ZERO for name in names]
    row = np.frombuffer(b"".join([clock.mark.join(LABEL).encode(), b",%d," % len(names), *cells]), np.uint8)
    ends = np.cumsum([len(cell) for cell in cells]) + len(row) - sum(map(len, cells))
    places = [int(end) - CELL for name, end in zip(names, ends, strict=True) if name in moving]
    chosen = [animation.channels.index(name) for name in names if name in moving]
    turned = [name in turns() for name in names if name in moving]
    times = origin + animation.times
    for begin in range(0, len(times), PIECE):
        block = values[begin : begin + PIECE, chosen].astype(np.float64)
        block[:, turned] = np.radians(block[:, turned])
        yield _rows(row, clock.counts(times[begin : begin + PIECE]), block, places)


def _rows(
    row: NDArray[np.uint8],
    counts: tuple[NDArray[np.int64], ...],
    values: NDArray[np.float64],
    places: list[int],
) -> bytes:
    """Rows of text from one `row` of all: its timecode by `counts`, and values at `places`."""
    text = np.tile(row, (len(values), 1))
    for count, place in zip(counts, LABEL_PLACES, strict=True):
        digits = 3 if place == LABEL_PLACES[-1] else 2
        text[:, place : place + digits] = number_cells(count, digits)
    if np.abs(values).max(initial=0.0) < LARGEST:
        cells = decimal_cells(values)
        for column, place in enumerate(places):
            text[:, place : place + CELL] = cells[:, column]
        text[:, -1] = ord("\n")
        return text.tobytes().translate(None, b"\0")
    pieces = []
    for line, numbers in zip(text, values.tolist(), strict=True):
        parts = np.split(line, [edge for place in places for edge in (place, place + CELL)])
        parts[1::2] = [np.frombuffer(b"%.10f," % number, np.uint8) for number in numbers]
        pieces.append(b"".join([part.tobytes() for part in parts])[:-1] + b"\n")
    return b"".join(pieces)


def read(path: Path) -> Animation:
    """Read a recording on a regular grid; frames that the app dropped are interpolated.

    Raises OutputError, which names the file and the row.
    """
    try:
        with open_plain(path) as data, TextIOWrapper(data, "utf-8-sig", newline="") as file:
            return _read(path, (row for row in csv.reader(file) if row))
    except DecodeError as error:
        raise OutputError(f"{path}: is not a recording: {error}") from error
    except (OSError, ValueError, csv.Error) as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error


def _read(path: Path, rows: Iterator[list[str]]) -> Animation:
    header = next(rows, [])
    if tuple(header[: len(LEAD)]) != LEAD:
        raise OutputError(
            f"{path}: is not a Live Link Face recording; its header must begin with {','.join(LEAD)}"
        )
    names = [name[:1].lower() + name[1:] for name in header[len(LEAD) :]]
    first = next(rows, None)
    if first is None:
        raise OutputError(f"{path}: has fewer than two frames; record it again")
    times, values = _table(path, first, rows, names)
    if len(times) < 2:
        raise OutputError(f"{path}: has fewer than two frames; record it again")
    falls = np.flatnonzero(np.diff(times) <= 0)
    if len(falls):
        raise OutputError(f"{path}, row {falls[0] + 3}: its timecode does not increase; remove the row")
    fps = estimate_rate(times)
    places = np.rint((times - times[0]) * fps)
    grid = np.arange(len(take_grid(0.0, places[-1] / fps, fps, len(names), path)), dtype=np.float64)
    sampled = sample_curves(grid, [(places, curve) for curve in values.T])
    about = {"provenance": {"input": path.name, "timecode": first[0].strip()}}
    return build_take(sampled, names, fps, 0.0, about, path)


def _capital(name: str) -> str:
    return name[:1].upper() + name[1:]


def _table(
    path: Path, first: list[str], rows: Iterator[list[str]], names: list[str]
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Seconds (frames,) and values (frames, channels) of the rows."""
    count, turned = len(names), [name in turns() for name in names]
    clock = timecode_for_label(first[0], NOMINAL)
    times: list[float] = []
    blocks: list[NDArray[np.float32]] = []
    block: list[list[float]] = []
    for line, row in enumerate(chain([first], rows), start=2):
        numbers = _numbers(path, line, row, count, clock)
        times.append(numbers[0])
        block.append(numbers[1:])
        if len(block) == PIECE:
            blocks.append(_block(block, turned))
            block = []
            check_size(len(times), count, path)
    blocks.append(_block(block, turned))
    return np.array(times), np.concatenate(blocks)


def _block(rows: list[list[float]], turned: list[bool]) -> NDArray[np.float32]:
    """Values of some rows, (rows, channels), with the rotations in degrees."""
    values = np.array(rows, np.float64).reshape(len(rows), len(turned))
    values[:, turned] = np.degrees(values[:, turned])
    return values.astype(np.float32)


def _numbers(path: Path, line: int, row: list[str], count: int, clock: Timecode) -> list[float]:
    """Seconds and values of a row."""
    try:
        values = [clock.parse(row[0]), *map(float, row[len(LEAD) :])]
    except (ValueError, OptionError) as error:
        raise OutputError(f"{path}, row {line}: {error}") from error
    if len(values) != 1 + count or not all(map(math.isfinite, values)):
        raise OutputError(f"{path}, row {line}: needs {count} finite numbers after the timecode")
    return values
