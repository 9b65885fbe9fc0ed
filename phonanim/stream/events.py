"""Events of a stream: phones, the time, audio, the end, and unreadable input. A line of JSON is one event."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, parse_json
from phonanim.errors import StreamError
from phonanim.speech.alignment_file import quote_label

FORMS = '{"phone": "AA1", "start": 0.1, "end": 0.2}, {"time": 0.3} or {"end": true}'


@dataclass(frozen=True, slots=True)
class Phone:
    """A phone from `start` to `end` seconds."""

    label: str
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Tick:
    """The clock of the source is at `time` seconds."""

    time: float


@dataclass(frozen=True)
class Samples:
    """The next samples of audio, (n,) float32 mono in -1..1."""

    values: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class End:
    """The end of the input."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Input that could not be read and is ignored."""

    text: str


Event = Phone | Tick | Samples | End | Problem


def parse_event(line: str) -> Event:
    """Parse a line of JSON. Raises StreamError when it has none of the forms."""
    try:
        table = parse_json(line)
    except DecodeError as error:
        raise StreamError(f"a line is ignored ({error}): {quote_label(line)}") from error
    if isinstance(table, dict):
        if "phone" in table:
            return _phone(table, line)
        if table.get("end") is True:
            return End()
        if _is_number(table.get("time")):
            return Tick(float(table["time"]))
    raise StreamError(f"a line is none of {FORMS} and is ignored: {quote_label(line)}")


def _phone(table: dict[str, Any], line: str) -> Phone:
    label, start, end = table["phone"], table.get("start"), table.get("end")
    if not (isinstance(label, str) and _is_number(start) and _is_number(end)):
        raise StreamError(f"a phone needs a label, a start and an end, and is ignored: {quote_label(line)}")
    return Phone(label, float(start), float(end))


def _is_number(value: Any) -> TypeGuard[float]:
    """Whether a JSON value is a finite number, and not a boolean."""
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False
