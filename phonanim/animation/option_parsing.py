"""Parse options from a command line or a table cell."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from phonanim.errors import OptionError
from phonanim.options import Closure, Overlay

LARGEST = 4.0  # of a gain
LAID = re.compile(r"(?P<source>.+?)(=(?P<gain>[\d.]+))?(@(?P<start>[\d.]+)-(?P<end>[\d.]+))?")
CLOSED = re.compile(r"(?P<kind>hold|release)@(?P<start>[\d.]+)-(?P<end>[\d.]+)")


def parse_gain(name: str, text: str) -> float:
    """Parse a gain from 0 to 4. Raises OptionError."""
    value = _number(text)
    if not 0.0 <= value <= LARGEST:
        raise OptionError(f"{name} = {text!r}; give a number from 0 to {LARGEST:g}")
    return value


def parse_gains(texts: Iterable[str]) -> dict[str, float]:
    """Parse gains by control, each CONTROL=NUMBER. Raises OptionError."""
    found: dict[str, float] = {}
    for text in texts:
        control, sign, number = text.strip().partition("=")
        if not (control and sign):
            raise OptionError(f"{text!r} is not CONTROL=NUMBER, such as jawOpen=1.2")
        if control in found:
            raise OptionError(f"{control} has two gains; give it one")
        found[control] = parse_gain(control, number)
    return found


def parse_overlay(text: str) -> Overlay:
    """Parse an overlay: FILE, FILE=GAIN, FILE@START-END or FILE=GAIN@START-END. Raises OptionError."""
    parts = LAID.fullmatch(text.strip())
    if parts is None:
        raise OptionError("an overlay names no file; write FILE=GAIN@START-END, such as smile=0.5@1.2-3")
    span = (_number(parts["start"]), _number(parts["end"])) if parts["start"] else None
    if span and not span[0] < span[1]:
        raise OptionError(f"{text}: its span must end after it starts, such as @1.2-3")
    return Overlay(parts["source"], parse_gain(parts["source"], parts["gain"] or "1"), span)


def parse_closures(texts: Iterable[str]) -> tuple[Closure, ...]:
    """Parse closures, each hold@START-END or release@START-END. Raises OptionError."""
    return tuple(map(_closure, texts))


def _closure(text: str) -> Closure:
    parts = CLOSED.fullmatch(text.strip())
    if parts is None:
        raise OptionError(f"{text!r}: write hold@START-END or release@START-END, such as hold@1.2-1.35")
    start, end = _number(parts["start"]), _number(parts["end"])
    if not start < end:
        raise OptionError(f"{text}: its span must end after it starts, such as @1.2-1.35")
    return Closure("hold" if parts["kind"] == "hold" else "release", start, end)


def parse_smoothing(text: str) -> float:
    """Parse smoothing in seconds, given as seconds or as the frequency in Hz whose power it halves.

    Raises OptionError.
    """
    from phonanim.animation.smooth import LONGEST, width_for_cutoff

    number = text.strip().lower().removesuffix("hz")
    try:
        seconds = width_for_cutoff(_number(number)) if number != text.strip().lower() else _number(number)
    except ZeroDivisionError:
        seconds = math.nan
    if not 0 <= seconds <= LONGEST:
        raise OptionError(f"{text!r} is neither 0 to {LONGEST:g} seconds nor a rate such as 8Hz")
    return seconds


def _number(text: str) -> float:
    """The number in a text, or NaN, which is outside every range, when it is not a number."""
    try:
        return float(text)
    except ValueError:
        return math.nan
