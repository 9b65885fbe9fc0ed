"""The file of corrections beside a line: JSON with one item per line, so that it can be read and compared."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from phonanim.animation.corrections import WHOLE, Corrections
from phonanim.animation.edit_file import edits_document, parse_edits
from phonanim.articulation.styles import RANGES
from phonanim.core.decode import (
    DAMAGE,
    MAX_TIME,
    DecodeError,
    decode_list,
    decode_number,
    decode_table,
    decode_text,
    parse_json,
    read_utf8,
)
from phonanim.core.files import write_text
from phonanim.errors import OptionError
from phonanim.options import Closure, Emotion
from phonanim.speech.intervals import pack_intervals, unpack_intervals
from phonanim.speech.phone_changes import PhoneChanges

FORMAT = "phonanim corrections 1"
LARGEST = 4.0  # of a gain
MOST = 1000  # emotions or closures of a line


def write_corrections(corrections: Corrections, path: Path) -> None:
    """Write corrections atomically. Raises OutputError."""
    write_text(path, corrections_text(corrections))


def corrections_text(corrections: Corrections) -> str:
    """The content of a file of corrections."""
    settings = plain_settings(corrections.settings)
    fields = {
        "format": FORMAT,
        "style": corrections.style,
        "settings": settings,
        "read": pack_intervals(corrections.phones.before),
        "spoken": pack_intervals(corrections.phones.after),
    }
    lines = [f"  {_text(name)}: {_text(value)}" for name, value in fields.items()]
    if corrections.curves is not None:
        lines.append(f'  "curves": {edits_document(corrections.curves, "    ")}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def read_corrections(path: Path) -> Corrections:
    """Read corrections back. Raises OptionError when the file is damaged or not one of corrections."""
    try:
        return parse_corrections(read_utf8(path))
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from error
    except KeyError as error:
        raise OptionError(f"{path}: is not a file of corrections: it lacks {error}") from error
    except DAMAGE as error:
        raise OptionError(f"{path}: is not a file of corrections: {error}") from error


def parse_corrections(text: str) -> Corrections:
    """Corrections from the content of their file. Raises KeyError, ValueError or TypeError."""
    tree = decode_table(parse_json(text), "the file")
    if tree["format"] != FORMAT:
        raise ValueError(f"its format is {tree['format']!r}, not {FORMAT!r}")
    return Corrections(
        PhoneChanges(unpack_intervals(tree["read"]), unpack_intervals(tree["spoken"])),
        parse_settings(tree["settings"]),
        decode_text(tree["style"], "the style"),
        parse_edits(tree["curves"]) if "curves" in tree else None,
    )


def parse_settings(tree: Any) -> dict[str, Any]:
    """Settings of a line from their JSON. Raises DecodeError, which names what is wrong."""
    found: dict[str, Any] = {}
    for name, value in decode_table(tree, "the settings").items():
        if name == "language":
            found[name] = decode_text(value, name)
        elif name in WHOLE:
            found[name] = decode_number(value, name, *RANGES.get(name, (0.0, LARGEST)))
        elif name == "gains":
            gains = decode_table(value, name).items()
            found[name] = {control: decode_number(gain, control, 0, LARGEST) for control, gain in gains}
        elif name == "emotions":
            found[name] = tuple(map(_emotion, _items(value, name)))
        elif name == "closures":
            found[name] = tuple(map(_closure, _items(value, name)))
        else:
            raise DecodeError(f"{name!r} is not a setting of a line")
    return found


def is_corrections(path: Path) -> bool:
    """Whether a file says that it is one of corrections; other files of edits are edits alone."""
    try:
        return f'"{FORMAT}"' in read_utf8(path)
    except (OSError, DecodeError):
        return False  # told by who reads it


def plain_settings(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as JSON values, in order of their names; the inverse of `parse_settings`."""
    return {name: _plain(value) for name, value in sorted(settings.items())}


def _items(value: Any, name: str) -> list[Any]:
    items = decode_list(value, name)
    if len(items) > MOST:
        raise DecodeError(f"there are {len(items)} {name}; a line has at most {MOST}")
    return items


def _emotion(item: Any) -> Emotion:
    table = decode_table(item, "an emotion")
    span = table.get("span")
    return Emotion(
        decode_text(table["name"], "an emotion"),
        decode_number(table["weight"], "a weight", 0, LARGEST),
        None if span is None else _span(span),
    )


def _closure(item: Any) -> Closure:
    table = decode_table(item, "a closure")
    if table["kind"] not in ("hold", "release"):
        raise DecodeError(f"a closure is {table['kind']!r:.40}; it is hold or release")
    return Closure(table["kind"], *_span((table["start"], table["end"])))


def _span(pair: Any) -> tuple[float, float]:
    start, end = (decode_number(time, "a time", 0, MAX_TIME) for time in pair)
    if not start < end:
        raise DecodeError(f"the span {start:g}-{end:g} s must end after it starts")
    return start, end


def _plain(value: Any) -> Any:
    return [asdict(item) for item in value] if isinstance(value, tuple) else value


def _text(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
