"""Parse life and emotion options from a command line, a table cell or a CSV file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from phonanim.animation.option_parsing import parse_gain, parse_overlay
from phonanim.core.decode import MAX_TIME, DecodeError
from phonanim.errors import OptionError
from phonanim.life.emotion import emotion_names
from phonanim.life.layer import BEHAVIOURS, check_name
from phonanim.options import Emotion

COLUMNS = ("emotion", "weight", "start", "end")
FARTHEST = 1000.0  # metres
MOST_SPANS = 2000  # emotions of a line


def parse_life(text: str) -> float | Mapping[str, float]:
    """Parse the gain of each behaviour: a number for all, or BEHAVIOUR=NUMBER separated by commas.

    Raises OptionError.
    """
    if "=" not in text:
        return parse_gain("life", text.strip())
    found: dict[str, float] = {}
    for part in text.split(","):
        name, _, number = (piece.strip() for piece in part.partition("="))
        check_name("behaviour", name, BEHAVIOURS, "life: ")
        found[name] = parse_gain(f"life {name}", number)
    return found


def parse_seed(text: str) -> int:
    """Parse a seed, a whole number from 0. Raises OptionError."""
    if not text.strip().isdecimal():
        raise OptionError(f"seed {text!r}; give a whole number from 0")
    return int(text)


def parse_look_at(text: str) -> tuple[float, float, float]:
    """Parse the position of the listener's eyes: X,Y,Z in metres to the speaker's left, up and ahead.

    Raises OptionError.
    """
    try:
        left, up, ahead = (float(part) for part in text.split(","))
    except ValueError:
        left = up = ahead = math.nan
    if not (max(abs(left), abs(up), ahead) <= FARTHEST and ahead > 0):
        raise OptionError(
            f"{text!r} is not X,Y,Z in metres to the speaker's left, up and ahead, such as 0,0,1"
        )
    return left, up, ahead


def parse_emotions(texts: Iterable[str]) -> tuple[Emotion, ...]:
    """Parse emotions: NAME[=WEIGHT][@START-END], or CSV files of spans. Raises OptionError."""
    return tuple(emotion for text in texts for emotion in _emotions(text.strip()))


def _emotions(text: str) -> Iterable[Emotion]:
    if text.lower().endswith(".csv"):
        return read_emotions(Path(text))
    parsed = parse_overlay(text)
    check_name("emotion", parsed.source, emotion_names())
    return (Emotion(parsed.source, parsed.gain, parsed.span),)


def read_emotions(path: Path) -> tuple[Emotion, ...]:
    """Read spans from a CSV: emotion, weight, start, end. Raises OptionError naming the row."""
    from phonanim.core.tables import read_rows  # few lines have such a file

    try:
        rows = [(number, row) for number, row in enumerate(read_rows(path), start=1) if row]
    except (OSError, DecodeError) as error:
        raise OptionError(f"{path}: cannot be read: {error}") from error
    if len(rows) > 1 + MOST_SPANS:
        raise OptionError(f"{path}: has {len(rows) - 1} emotions, more than {MOST_SPANS}; join some")
    if not rows or tuple(cell.strip().lower() for cell in rows[0][1]) != COLUMNS:
        raise OptionError(f"{path}: its first row must be {','.join(COLUMNS)}")
    return tuple(_span(path, number, row) for number, row in rows[1:])


def _span(path: Path, number: int, row: list[str]) -> Emotion:
    place = f"{path}, row {number}"
    if len(row) != len(COLUMNS):
        raise OptionError(f"{place}: has {len(row)} cells; give {', '.join(COLUMNS)}")
    name, weight, start, end = (cell.strip() for cell in row)
    check_name("emotion", name, emotion_names(), f"{place}: ")
    try:
        span = float(start), float(end)
    except ValueError:
        span = math.nan, math.nan
    if not 0 <= span[0] < span[1] <= MAX_TIME:
        raise OptionError(f"{place}: start {start!r} and end {end!r} must be seconds, and rise")
    return Emotion(name, parse_gain(f"{place}: weight", weight), span)
