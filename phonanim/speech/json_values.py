"""The JSON values of a file, as programs and services write them: one, or many as they came.

Streams are saved as lines, as values one behind the other, or as server-sent events (`data: {...}`). What a
service took back is left out: recognizers send a result several times until it is final.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from phonanim.core.decode import DecodeError, check_nesting, parse_json

MOST_VALUES = 500_000
"""Values of one file: a service sends some ten in a second, and two hours have 7200 seconds."""

NESTED = 4
"""Levels in which results may say that they are not final."""

_EVENT = re.compile(r"^(?:data:[ \t]*(?:\[DONE\])?|(?:event|id|retry):.*|:.*)", re.MULTILINE)
_BETWEEN = re.compile(r"[\s,\x1e]*")
_TRAILING = re.compile(r",(\s*[\]}])")

# A field with this value marks a result that a later one replaces.
PARTIAL: tuple[tuple[str, Any], ...] = (
    *(("is_final", False), ("isFinal", False), ("IsPartial", True), ("is_partial", True)),
    *(("end_of_turn", False), ("message", "AddPartialTranscript"), ("message_type", "PartialTranscript")),
    *(("type", "partial"), ("type", "PARTIAL_TRANSCRIPTION")),
)
SPOKEN = ("audio", "alignment", "normalizedAlignment", "audio_base64")
"""Fields of speech that was synthesized, where "isFinal" is said of the stream."""


def parse_value(text: str) -> Any:
    """A JSON value; commas before a closing bracket are allowed. None where it is not JSON."""
    if text.lstrip()[:1] not in ("{", "["):
        return None
    try:
        return parse_json(text, numbers_only=False)
    except DecodeError:
        loose = _TRAILING.sub(r"\1", text)
    try:
        return None if loose == text else parse_json(loose, numbers_only=False)
    except DecodeError:
        return None


def parse_stream(text: str) -> list[Any]:
    """The JSON values that follow each other; [] where something else is between them."""
    start = text.lstrip()[:6]
    if start.startswith(("data:", "event:", "id:", "retry:", ":")):
        text = _EVENT.sub("", text)
    elif not start.startswith("{"):
        return []
    try:
        return list(_values(text))
    except DecodeError:
        return []


def without_partial(values: list[Any]) -> list[Any]:
    """Values without the results that a later result replaces."""
    kept = [_final(value, NESTED) for value in values if not _is_partial(value)]
    turns = {value["turn_order"]: n for n, value in enumerate(kept) if _has_turn(value)}
    return [value for n, value in enumerate(kept) if not _has_turn(value) or turns[value["turn_order"]] == n]


def _values(text: str) -> Iterator[Any]:
    decoder = json.JSONDecoder()
    place, count = _end_of(text, 0), 0
    while place < len(text):
        try:
            value, end = decoder.raw_decode(text, place)
        except (ValueError, RecursionError) as error:
            raise DecodeError(f"it is not JSON: {type(error).__name__}") from error
        count += 1
        if count > MOST_VALUES or not isinstance(value, (dict, list)):
            raise DecodeError("it is not a stream of results")
        check_nesting(value, text[place:end])
        yield value
        place = _end_of(text, end)


def _end_of(text: str, place: int) -> int:
    found = _BETWEEN.match(text, place)
    return found.end() if found else place


def _final(value: Any, levels: int) -> Any:
    """A value without the partial results in it."""
    if levels == 0:
        return value
    if isinstance(value, list):
        return [_final(item, levels - 1) for item in value if not _is_partial(item)]
    if isinstance(value, dict):
        return {key: _final(item, levels - 1) for key, item in value.items()}
    return value


def _is_partial(value: Any) -> bool:
    if not isinstance(value, dict) or any(key in value for key in SPOKEN):
        return False
    return any(type(value.get(key)) is type(told) and value[key] == told for key, told in PARTIAL)


def _has_turn(value: Any) -> bool:
    return isinstance(value, dict) and isinstance(value.get("turn_order"), (int, str))
