"""Labels with times anywhere in JSON: lists of tables, lists side by side, and lists of lists."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import count
from typing import Any

from phonanim.core.decode import DecodeError, parse_json
from phonanim.readers._columns import Times, find_column, find_times, plain_name, read_time, values_at
from phonanim.readers._json_columns import add_columns, add_rows, find_rows
from phonanim.readers._json_found import KINDS, PAIRS, Found, Groups, is_pair, kind_of, last_name

MOST_NESTED = 16
MOST_TABLES = 300_000
"""Tables of a file: two hours of speech have about 150,000 labels."""

MOST_NAMES = 200
"""Names of a table that is a label, or that has lists side by side; larger ones hold other tables."""

TYPES = {"phone": "phones", "phoneme": "phones", "viseme": "visemes", "word": "words"}
"""What the field `type` of an entry makes of it; other entries that have types are of no kind."""

SPEAKERS = ("speaker", "speakerid", "speakerlabel", "speakername")
RATES = ("fps", "framerate")
RANKED = ("alternatives", "nbest", "hypotheses")
"""Lists of which the first entry is the most probable, and the others say the same otherwise."""

UNTIMED = object()  # the first part of the key of labels without times


def find_lists(content: list[Any]) -> list[Found]:
    """The entries of each place of a file that has labels with times. Raises ValueError for damaged times."""
    groups: Groups = {}
    tables = count(1)
    for line in content:
        _walk(line, (), {}, groups, tables)
    untimed = {key[1:]: found for key, found in groups.items() if key[0] is UNTIMED}
    timed = {key: found for key, found in groups.items() if key[0] is not UNTIMED}
    for key, found in timed.items():
        lost = untimed.get(key[:-3]) if _is_of_tables(key) else None
        if lost and lost.names:
            raise ValueError(lost.names)
        found.untimed += [label for label, *_ in lost.entries] if lost else []
    return list(timed.values())


def _is_of_tables(key: tuple[object, ...]) -> bool:
    """Whether a key of groups is that of tables, each a label with its times."""
    return len(key) >= 3 and isinstance(key[-2], Times)


def _walk(
    value: Any, path: tuple[str, ...], around: dict[str, Any], groups: Groups, tables: Iterator[int]
) -> None:
    """Collect what lies in a value; `around` has the speaker and the frame rate of what it lies in.

    `tables` counts them. Raises ValueError for too many.
    """
    if not value or len(path) > MOST_NESTED:
        return
    if isinstance(value, str) and value[:1] in ("{", "[") and len(value) > 2:
        value = _parsed(value)
    if isinstance(value, list):
        if rows := find_rows(value):
            add_rows(rows, path, groups)
            return
        ranked = plain_name(last_name(path)) in RANKED or _are_candidates(value, path)
        for item in value[:1] if ranked else value:
            _walk(item, (*path, "*"), around, groups, tables)
    elif isinstance(value, dict):
        if next(tables) > MOST_TABLES:
            raise ValueError(f"it has more than {MOST_TABLES:,} tables")
        around = _add_entries(value, path, around, groups) if len(value) <= MOST_NAMES else around
        for name, inner in value.items():
            _walk(inner, (*path, name), around, groups, tables)


def _add_entries(
    table: dict[str, Any], path: tuple[str, ...], around: dict[str, Any], groups: Groups
) -> dict[str, Any]:
    """Collect what a table itself has; returns what is around the values in it."""
    told = _told(table)
    _add_table(table, path, around | {key: told[key] for key in told if key != "tier"}, groups)
    around = around | told
    add_columns(table, path, around, groups)
    return around


def _are_candidates(value: list[Any], path: tuple[str, ...]) -> bool:
    """Whether a list of transcripts has several of one recording, by its confidences."""
    ranked = plain_name(last_name(path)) == "transcripts"
    return ranked and all(isinstance(one, dict) and "confidence" in one for one in value)


def _parsed(text: str) -> Any:
    try:
        return parse_json(text, numbers_only=False)
    except DecodeError:
        return None


def _told(table: dict[str, Any]) -> dict[str, Any]:
    """What a table says of all that is in it."""
    found = {}
    for what, names in (("speaker", SPEAKERS), ("rate", RATES), ("tier", ("name", "tier"))):
        name = find_column(table, names)
        if name and isinstance(table[name], (str, int, float)) and table[name] != "":
            found[what] = table[name]
    return found


def _add_table(table: dict[str, Any], path: tuple[str, ...], around: dict[str, Any], groups: Groups) -> None:
    """A table that is one label with its times."""
    flat = _flat(table)
    name, kind = _label(flat, path)
    times = find_times(key for key, value in flat.items() if _is_time(value))
    if not name or times is None or not _is_timed(flat, times):
        if name:
            _add_untimed(flat, name, path, groups)
        return
    if kind in ("words", "labels"):
        kind = kind_of(str(around.get("tier", ""))) or kind_of(last_name(path)) or kind
    typed = next((flat[key] for key in flat if plain_name(key) == "type" and isinstance(flat[key], str)), "")
    if typed and name != "type":
        kind = TYPES.get(_last_word(typed), kind if typed == "labels" else "")
    label = flat[name][0] if isinstance(flat[name], list) else flat[name]
    if not kind or not isinstance(label, (str, int)):
        return
    shown = " and ".join(f'"{one}"' for one in (times.start, times.end or times.length) if one)
    unit = _frame_unit(times, around) if _counts_frames(times) else times.unit
    key = (*path, kind, times, around.get("tier", ""))
    found = groups.setdefault(key, Found(kind, unit, f'"{name}" with {shown}'))
    found.entries.append((str(label), *values_at(flat, times), str(around.get("speaker", ""))))


def _add_untimed(flat: dict[str, Any], name: str, path: tuple[str, ...], groups: Groups) -> None:
    """A table with a label and no times, which counts where others of its place have times."""
    label = _text(flat[name])
    if not any(c.isalnum() for c in label):
        return
    found = groups.setdefault((UNTIMED, *path), Found("labels", None, ""))
    found.entries.append((label, math.nan, math.nan, ""))
    texts = (key for key, value in flat.items() if isinstance(value, (str, bool)) and not _is_time(value))
    damaged = next((key for key in texts if find_times([key])), None)
    if damaged is not None and not found.names:
        found.names = f'{label!r} has the time {str(flat[damaged])[:20]!r} in "{damaged}"'


def _last_word(text: str) -> str:
    return text.lower().replace("boundary", "").rstrip("s").rpartition("_")[2]


def _flat(table: dict[str, Any]) -> dict[str, Any]:
    """A table with pairs of times as `start` and `end`, and small tables of times in it laid open."""
    flat: dict[str, Any] = {}
    for name, value in table.items():
        if plain_name(name) in PAIRS and is_pair(value):
            flat |= {f"{name}.start": value[0], f"{name}.end": value[1], "start": value[0], "end": value[1]}
        elif isinstance(value, dict) and len(value) <= 4 and find_times(value):
            flat |= value
        else:
            flat[name] = value
    return flat


def _label(flat: dict[str, Any], path: tuple[str, ...]) -> tuple[str, str]:
    """The name of the label of a table, and its kind; the number of a viseme is a label too."""
    texts = [name for name, value in flat.items() if _is_text(value)]
    # A label that is empty is silence, but where another name has a text that one is the label.
    for usable in ([name for name in texts if _text(flat[name])], texts):
        for kind, wanted in KINDS.items():
            if name := find_column(usable, wanted):
                return name, kind
    name = find_column(flat, ("viseme", "visemeid", "value", "id"))
    shapes = plain_name(name).startswith("viseme") or plain_name(last_name(path)) in ("visemes", "mouthcues")
    return (name, "visemes") if name and shapes and isinstance(flat[name], int) else ("", "")


def _is_text(value: Any) -> bool:
    return isinstance(value[0] if isinstance(value, list) and len(value) == 1 else value, str)


def _text(value: Any) -> str:
    return str(value[0] if isinstance(value, list) else value).strip()


def _is_timed(flat: dict[str, Any], times: Times) -> bool:
    shown = [flat.get(name) for name in times[:3] if name]
    return any(one is not None for one in shown) and all(_is_time(one) for one in shown)


def _is_time(value: Any) -> bool:
    try:
        read_time(value)
    except (ValueError, TypeError, OverflowError):
        return False
    return True


def _counts_frames(times: Times) -> bool:
    return any("frame" in plain_name(name) for name in times[:3] if name)


def _frame_unit(times: Times, around: dict[str, Any]) -> float:
    """Seconds of a frame. Raises ValueError without a frame rate."""
    rate = around.get("rate")
    if not isinstance(rate, (int, float)) or rate <= 0:
        raise ValueError(f'"{times.start}" counts frames, and the file has no "fps"')
    return 1 / float(rate)
