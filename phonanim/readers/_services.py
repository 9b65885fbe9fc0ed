"""Entries of the JSON of speech services, found by the paths of lexicon/word_times.toml."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from phonanim.core.decode import read_toml
from phonanim.core.lexicon import LEXICON

MOST_NESTED = 12
Within = tuple[Any, ...]
"""What an entry lies in, from the outside in."""


@dataclass(frozen=True)
class Layout:
    """Where a service puts its entries, and their labels and times; the fields are those of the table."""

    service: str
    items: str
    label: str
    start: str
    seconds: float
    end: str = ""
    duration: str = ""
    base: str = ""
    gives: str = "words"
    columns: bool = False
    pairs: bool = False
    whole: bool = False
    speaker: str = ""
    language: str = ""
    only: dict[str, list[str]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Entry:
    """A label with its start and end in the service's unit, None where it has none, and its speaker."""

    label: str
    start: float | None
    end: float | None
    speaker: str = ""


@cache
def layouts() -> tuple[Layout, ...]:
    """Every layout of the table."""
    content = read_toml(LEXICON / "word_times.toml")
    return tuple(Layout(**row) for row in content["layout"])


def find_layouts(lines: list[Any]) -> tuple[Layout, ...]:
    """The layouts of the service that wrote these JSON values; () for none."""
    roots = list(_roots(lines))
    names = {name for root in roots if isinstance(root, dict) for name in root}
    lists = any(isinstance(root, list) for root in roots)
    near = [one for one in layouts() if lists or one.items.partition(".")[0] in names]
    found = [one for one in near if any(_fits(one, roots))]
    kinds = {one.gives for one in found if one.service == found[0].service}
    whole = "lines" not in kinds or kinds == {"lines"}  # words are used before the lines that they are in
    return tuple(one for one in found if one.service == found[0].service and (whole or one.gives != "lines"))


def entries(layout: Layout, lines: list[Any]) -> Iterator[Entry]:
    """The entries in the order of the file. Raises one of DAMAGE for a time that is none."""
    for root in _roots(lines):
        for item, within in _walk(root, layout.items.split("."), ()):
            if layout.columns:
                yield from _columns(layout, item)
            elif _is_entry(layout, item, within):
                yield _entry(layout, item, within)


def language_of(layout: Layout, lines: list[Any]) -> str:
    """The language that the service names, "" for none."""
    for root in _roots(lines):
        for item, within in _walk(root, layout.items.split("."), ()):
            found = _outward(item, within, layout.language) if layout.language else None
            if isinstance(found, str):
                return found
    return ""


def _roots(lines: list[Any]) -> Iterator[Any]:
    for line in lines:
        yield from line if isinstance(line, list) else (line,)


def _fits(layout: Layout, roots: list[Any]) -> Iterator[bool]:
    """Whether there are entries; where the layout has whole times, whether all are."""
    found = [
        (item, within)
        for root in roots
        for item, within in _walk(root, layout.items.split("."), ())
        if _is_entry(layout, item, within)
    ]
    if layout.whole:
        times = [_at(item, path) for item, _ in found for path in (layout.start, layout.end)]
        yield bool(found) and all(type(time) is int for time in times) and _mean_length(layout, found) >= 20
    else:
        yield bool(found)


def _mean_length(layout: Layout, found: list[tuple[Any, Within]]) -> float:
    lengths = [_at(item, layout.end) - _at(item, layout.start) for item, _ in found]
    return float(sum(lengths)) / len(lengths)


def _walk(value: Any, path: list[str], within: Within) -> Iterator[tuple[Any, Within]]:
    """Every value at a path, with what it lies in."""
    if not path or len(within) > MOST_NESTED:
        if not path:
            yield value, within
        return
    step, rest = path[0], path[1:]
    if step == "*":
        for item in value if isinstance(value, list) else ():
            yield from _walk(item, rest, (*within, value))
    elif (inner := _step(value, step)) is not None:
        yield from _walk(inner, rest, (*within, value))


def _step(value: Any, step: str) -> Any:
    if isinstance(value, dict):
        return value.get(step)
    if isinstance(value, list) and step.isdecimal() and int(step) < len(value):
        return value[int(step)]
    return None


def _at(value: Any, path: str) -> Any:
    for step in path.split("."):
        value = _step(value, step)
    return value


def _outward(item: Any, within: Within, path: str) -> Any:
    """The value at a path from an entry, or from the nearest of what it lies in that has one."""
    found = (_at(place, path) for place in (item, *reversed(within)))
    return next((value for value in found if value is not None), None)


def _is_entry(layout: Layout, item: Any, within: Within) -> bool:
    if layout.columns:
        return all(isinstance(_at(item, path), list) for path in (layout.label, layout.start))
    if not isinstance(_at(item, layout.label), str):
        return False
    if not all(_at(item, key) in values for key, values in layout.only.items()):
        return False
    if layout.base:
        return _outward(item, within, layout.base) is not None
    last = layout.end or layout.duration
    return all(isinstance(_at(item, path), (int, float, str)) for path in (layout.start, last))


def _entry(layout: Layout, item: Any, within: Within) -> Entry:
    start = _number(_at(item, layout.start))
    end = _number(_at(item, layout.end)) if layout.end else None
    if layout.base:
        base = float(_outward(item, within, layout.base))
        start, end = base + (start or 0.0), None if end is None else base + end
    if layout.duration and start is not None:
        end = start + float(_at(item, layout.duration))
    speaker = _outward(item, within, layout.speaker) if layout.speaker else None
    return Entry(_at(item, layout.label), start, end, "" if speaker is None else str(speaker))


def _columns(layout: Layout, item: Any) -> Iterator[Entry]:
    labels, starts = _at(item, layout.label), _at(item, layout.start)
    ends = [pair[1] for pair in starts] if layout.pairs else _at(item, layout.end)
    starts = [pair[0] for pair in starts] if layout.pairs else starts
    for label, start, end in zip(labels, starts, ends, strict=True):
        yield Entry(str(label), float(start), float(end))


def _number(value: Any) -> float | None:
    if isinstance(value, bool):
        raise TypeError("a time is true or false")
    return None if value is None else float(value)
