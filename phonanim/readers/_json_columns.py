"""Labels with times in JSON as lists side by side, and as lists of lists."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from phonanim.readers._columns import WORDS, find_times, plain_name, values_at
from phonanim.readers._json_found import (
    PAIRS,
    Found,
    Groups,
    has_word,
    is_pair,
    kind_of,
    last_name,
    name_words,
)

ROUNDING = 1e-3
MOST_BEGINNINGS = 100
"""Lists of labels, side by side, that each begin again: of phones, words, speakers."""


def add_columns(table: dict[str, Any], path: tuple[str, ...], around: dict[str, Any], groups: Groups) -> None:
    """Lists side by side: one of labels, and one or two of times."""
    lists = {name: value for name, value in table.items() if isinstance(value, list) and value}
    numbers = {name: value for name, value in lists.items() if all(map(_is_number, value))}
    pairs = {
        name: value for name, value in lists.items() if has_word(name, PAIRS) and all(map(is_pair, value))
    }
    for name, labels in _label_lists(table, lists):
        same = {other: value for other, value in numbers.items() if len(value) == len(labels)}
        times = find_times(_without_prefix(name, same))
        both = next((value for value in pairs.values() if len(value) == len(labels)), None)
        kind = kind_of(name) or "labels"
        if times is None and both is None:
            continue
        shown = " and ".join(f'"{one}"' for one in (same if times else pairs))
        unit = times.unit if times else None
        found = groups.setdefault((*path, name, "columns"), Found(kind, unit, f'"{name}" with {shown}'))
        for place, label in enumerate(labels):
            row = {short: value[place] for short, value in _without_prefix(name, same).items()}
            start, end = both[place] if times is None and both else values_at(row, times)  # type: ignore[arg-type]
            found.entries.append((label, float(start), float(end), str(around.get("speaker", ""))))


def _label_lists(table: dict[str, Any], lists: dict[str, Any]) -> Iterator[tuple[str, list[str]]]:
    """The lists of labels, and a text as the list of its words or signs."""
    texts = {name: value for name, value in lists.items() if all(isinstance(one, str) for one in value)}
    yield from texts.items()
    if not texts:
        for name, value in table.items():
            if plain_name(name) in WORDS and isinstance(value, str) and value.strip():
                words = value.split()
                yield name, words
                if len(words) == 1 and len(value) > 1:
                    yield name, list(value)


def _without_prefix(name: str, lists: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """Lists by what is left of their names without the word that the list of labels has as well."""
    words = {word.rstrip("s") for word in name_words(name)}
    short: dict[str, list[Any]] = {}
    for other, value in lists.items():
        rest = [word for word in name_words(other) if word.rstrip("s") not in words]
        short["_".join(rest) or other] = value
    return short


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def find_rows(value: list[Any]) -> list[tuple[str, float, float]]:
    """Label, start and end of a list of lists such as ["b", 0.2, 0.3] or [0.2, 0.3, "b"]; [] for others."""
    rows = []
    for item in value:
        if not isinstance(item, list) or not 3 <= len(item) <= 6:
            return []
        first = item[0] if isinstance(item[0], str) else item[2] if isinstance(item[2], str) else None
        numbers = item[1:3] if isinstance(item[0], str) else item[:2]
        if first is None or not all(map(_is_number, numbers)):
            return []
        rows.append((first, float(numbers[0]), float(numbers[1])))
    if any(end < start for _, start, end in rows):  # the second number is a length
        rows = [(label, start, start + length) for label, start, length in rows]
    return rows


def add_rows(rows: list[tuple[str, float, float]], path: tuple[str, ...], groups: Groups) -> None:
    """Collect rows of one place. Raises ValueError where too many lists begin again."""
    kind = kind_of(last_name(path)) or "labels"
    number = 0  # lists that begin again are of another kind, such as words after phones
    while (last := groups.get((*path, "rows", number))) and last.entries[-1][2] > rows[0][1] + ROUNDING:
        number += 1
        if number > MOST_BEGINNINGS:
            raise ValueError(f"more than {MOST_BEGINNINGS} lists of labels begin again")
    found = groups.setdefault((*path, "rows", number), Found(kind, None, "lists of a label and two times"))
    found.entries += [(label, start, end, "") for label, start, end in rows]
