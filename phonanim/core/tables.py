"""Read tables (CSV) that are not trusted: a plain file of limited size, UTF-8, finite numbers.

Every function raises DecodeError, whose message does not name the file.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from phonanim.core.decode import MAX_TIME, DecodeError, decode_number, read_utf8

MAX_TABLE = 1 << 24
"""Bytes of a table: the largest of ours, 400 frames of motion, has 60 kB."""

MAX_ROWS = 200_000
"""Rows of a table."""


def read_rows(path: Path, delimiter: str = ",", most: int = MAX_TABLE) -> list[list[str]]:
    """The rows of a table, the first its header. Raises DecodeError, OSError."""
    return parse_rows(read_utf8(path, most), delimiter)


def parse_rows(text: str, delimiter: str = ",") -> list[list[str]]:
    """The rows of a table that has been read. Raises DecodeError."""
    text = text.removeprefix("\ufeff")
    rows: list[list[str]] = []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    try:
        for row in reader:
            rows.append(row)
            if len(rows) > MAX_ROWS:
                raise DecodeError(f"it has more than {MAX_ROWS} rows")
    except csv.Error as error:
        raise DecodeError(f"line {reader.line_num} is not a row of a table ({error})") from error
    return rows


def read_records(
    path: Path, needed: Sequence[str] = (), delimiter: str = ","
) -> list[tuple[int, dict[str, str]]]:
    """The number of each row that is not empty (the header is row 1) and its cells by column.

    A cell that is missing at the end of a row is empty; cells beyond the header are refused. Raises
    DecodeError, also for a `needed` column that is missing; OSError.
    """
    return to_records(read_rows(path, delimiter), needed)


def to_records(rows: Sequence[Sequence[str]], needed: Sequence[str] = ()) -> list[tuple[int, dict[str, str]]]:
    """The same of rows, the first their header. Raises DecodeError."""
    header = rows[0] if rows else []
    for name in needed:
        if name not in header:
            raise DecodeError(f"it has no column {name!r}; its first line needs {','.join(needed)}")
    for name in needed:
        if header.count(name) > 1:
            raise DecodeError(f"it has two columns {name!r}; keep one")
    return [(number, _record(number, header, row)) for number, row in enumerate(rows[1:], 2) if any(row)]


def parse_cell(text: str, name: str, low: float = -MAX_TIME, high: float = MAX_TIME) -> float:
    """The number in a cell, from `low` to `high`. Raises DecodeError, which names it."""
    try:
        return decode_number(float(text), name, low, high)
    except ValueError as error:
        if isinstance(error, DecodeError):
            raise
        shown = text if len(text) <= 40 else f"{text[:39]}…"
        raise DecodeError(f"{name} is {shown!r}; it is a number from {low:g} to {high:g}") from error


def _record(number: int, header: Sequence[str], row: Sequence[str]) -> dict[str, str]:
    if len(row) > len(header):
        raise DecodeError(f"row {number} has {len(row)} cells, the header {len(header)}")
    return dict(zip(header, [*row, *[""] * (len(header) - len(row))], strict=True))
