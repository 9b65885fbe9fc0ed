"""Names of columns and keys, as many programs spell them: what a column holds, and in which unit of time."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import NamedTuple

from phonanim.readers._times import clock_seconds

STARTS = (
    *("starttime", "start", "begintime", "begin", "timebegin", "timestart", "from", "onset", "tstart"),
    *("tmin", "xmin", "startts", "starttimestamp", "startoffset", "begpos", "audiooffset", "in", "starts"),
    *("audiostart", "begins", "onsets", "startframe", "ts", "frame", "time", "timestamp", "t", "offset"),
    "timeoffset",
)
ENDS = (
    *("endtime", "end", "timeend", "audioend", "stop", "stoptime", "to", "until", "tend", "tmax", "xmax"),
    *("endts", "endtimestamp", "endoffset", "endpos", "out", "ends", "stops", "offsets", "endframe"),
    "offset",
)
LENGTHS = ("duration", "dur", "length", "durations", "timeduration", "audioduration", "len", "lengths")
_TIMES = frozenset((*STARTS, *ENDS, *LENGTHS))
"""Names without their unit, small letters and digits alone; the better ones first."""

PHONES = (
    *("phoneme", "phone", "phonemes", "phones", "phonesymbol", "phonemesymbol", "phonelabel", "ipa", "phon"),
    *("ph", "phonemelabel", "segment", "symbol"),
)
VISEMES = ("viseme", "visemes", "visemename", "mouthshape", "mouth", "shape", "mouthcue")
WORDS = (
    *("word", "words", "punctuatedword", "text", "texts", "content", "token", "tokens", "body", "sentence"),
    *("transcript", "lyric", "lyrics", "utf8", "caption", "surface"),
)
LABELS = ("label", "annotation", "value", "name", "mark", "markname", "markername", "clipname", "labels")
TIERS = ("tier", "type", "level")

_UNITS = {
    **dict.fromkeys(("milliseconds", "millis", "msec", "ms"), 1e-3),
    **dict.fromkeys(("seconds", "secs", "sec"), 1.0),
    **dict.fromkeys(("ticks", "100ns"), 1e-7),
}
_UNIT = re.compile(f"(.+?)({'|'.join(_UNITS)})")
_WRITTEN = re.compile(r"(\w+?)(?:hhmmssms|hhmmssmsec|ssmsec)")
_CLOCK = re.compile(r"\d{1,4}:\d{1,2}(?::\d{1,2})?(?:[.,]\d{1,9})?")
_NUMBER = re.compile(r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?s?")


class Column(NamedTuple):
    """A name as it is written, its name without unit, and the seconds of one number, None where unknown."""

    name: str
    bare: str
    unit: float | None


class Times(NamedTuple):
    """The columns of start, and of end or length; "" where there is none."""

    start: str
    end: str
    length: str
    unit: float | None


@lru_cache(maxsize=4096)  # the names of a file repeat from row to row
def plain_name(name: str) -> str:
    """A name in small letters and digits alone: "Start Time (ms)" is starttimems.

    The prefix that Azure's SDK for JavaScript gives to its fields is left out.
    """
    return re.sub(r"[^a-z0-9]", "", name.lower()).removeprefix("priv")


def find_column(names: Iterable[str], wanted: Iterable[str]) -> str:
    """The first of the wanted names that is there, as it is written; "" for none."""
    return _find_column(tuple(names), tuple(wanted))


@lru_cache(maxsize=256)  # the tables of a file have few sets of names
def _find_column(names: tuple[str, ...], wanted: tuple[str, ...]) -> str:
    plain = {plain_name(name): name for name in names}
    return next((plain[name] for name in wanted if name in plain), "")


def find_times(names: Iterable[str]) -> Times | None:
    """The columns that give the times of a row; None where there is neither a start nor a length."""
    return _find_times(tuple(names))


@lru_cache(maxsize=256)
def _find_times(names: tuple[str, ...]) -> Times | None:
    columns = [_column(name) for name in names]
    start = _first(columns, STARTS)
    end = _first([one for one in columns if one is not start], ENDS)
    length = _first([one for one in columns if one is not start], LENGTHS)
    first = start or length
    if first is None:
        return None
    unit = next((one.unit for one in (start, end, length) if one and one.unit is not None), None)
    return Times(start.name if start else "", end.name if end else "", length.name if length else "", unit)


def read_time(value: object) -> float:
    """A time as a number, NaN for nothing. Raises ValueError or TypeError for what is no time.

    A clock time such as 0:01.250 is in seconds. A time code, whose last part counts frames, is refused.
    """
    if value is None or value == "":
        return math.nan
    if isinstance(value, bool):
        raise TypeError("a time is true or false")
    if isinstance(value, (int, float)):
        return float(value)
    text = str(value).strip()
    if _CLOCK.fullmatch(text):
        clock = text if text.count(":") == 2 else f"0:{text}"
        return clock_seconds(clock if re.search(r"[.,]", clock) else f"{clock}.0")
    if not _NUMBER.fullmatch(text):
        raise ValueError(f"{text[:20]!r} is not a time in seconds")
    return float(text.rstrip("s").replace(",", "."))


def guess_unit(lengths: Iterable[float], labels: int, words: bool) -> float:
    """The seconds of one number, by how long each of `labels` would last: words, or sounds.

    A mean of 40 is no number of seconds. For words it may be frames, for sounds it is milliseconds. NaN for
    frames, whose length differs from program to program.
    """
    finite = [length for length in lengths if math.isfinite(length)]
    mean = sum(finite) / max(labels, 1)
    whole = all(float(length).is_integer() for length in finite)
    frames, most = (4, 100) if words else (1, 30)
    if mean >= 40_000:
        return 1e-7
    return 1e-3 if mean >= most else math.nan if whole and mean >= frames else 1.0


def values_at(row: Mapping[str, object], times: Times) -> tuple[float, float]:
    """Start and end of a row as numbers, NaN for what it lacks; without a start, NaN and the length."""
    if not times.start:
        return math.nan, read_time(row.get(times.length))
    start = read_time(row.get(times.start))
    if times.end and row.get(times.end) not in (None, ""):
        return start, read_time(row.get(times.end))
    return start, start + read_time(row.get(times.length)) if times.length else math.nan


def _column(name: str) -> Column:
    bare = plain_name(name)
    if written := _WRITTEN.fullmatch(bare):  # ELAN says how a time is written, such as "ss.msec"
        return Column(name, _known(written[1]), 1.0)
    found = _UNIT.fullmatch(bare)
    if found and (known := _known(found[1])):
        return Column(name, known, _UNITS[found[2]])
    # One letter of a unit counts where it stands apart: start_s is in seconds, starts is a list.
    if re.search(r"[^A-Za-z]s\W*$", name) and bare[:-1] in _TIMES:
        return Column(name, bare[:-1], 1.0)
    return Column(name, _known(bare), None)


def _known(bare: str) -> str:
    """A name of a time, in the singular where only that is known; "" for others."""
    return bare if bare in _TIMES else bare[:-1] if bare.endswith("s") and bare[:-1] in _TIMES else ""


def _first(columns: list[Column], wanted: tuple[str, ...]) -> Column | None:
    found = [one for one in columns if one.bare in wanted]
    return min(found, key=lambda one: wanted.index(one.bare), default=None)
