"""Stamps: the size and the time of the last change of a file, so that an unchanged one is not read again."""

from __future__ import annotations

import stat
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from phonanim.core.decode import DecodeError, decode_list, decode_table
from phonanim.dubbing.line import Line
from phonanim.dubbing.storage import Place

SETTLED = 2_000_000_000  # nanoseconds after which a further change of a file gets another time, on any system
INPUTS = ("alignment", "audio", "edits", "corrections")
OUTPUTS = "outputs"

Stamp: TypeAlias = list[int]
"""Bytes, and nanoseconds since 1970."""


def stamp_file(place: Place | None) -> Stamp | None:
    """The stamp of a local file; None for one that is elsewhere, missing, or no plain file."""
    if not isinstance(place, Path):
        return None
    try:
        found = place.stat()
    except OSError:
        return None
    return [found.st_size, found.st_mtime_ns] if stat.S_ISREG(found.st_mode) else None


def stamp_inputs(line: Line) -> dict[str, Stamp]:
    """The stamps of a line's own files, by their names in its origin; none for what changed just now."""
    found = {name: stamp_file(getattr(line, name)) for name in INPUTS}
    latest = time.time_ns() - SETTLED
    return {name: stamp for name, stamp in found.items() if stamp and stamp[1] < latest}


def stamp_outputs(names: Iterable[str], folder: Place) -> dict[str, Stamp]:
    """The stamps of outputs that lie in `folder`, by their names."""
    found = {name: stamp_file(folder / name) for name in names}
    return {name: stamp for name, stamp in found.items() if stamp}


def check_stamps(stamps: Mapping[str, Any]) -> None:
    """Raise DecodeError for stamps that no run writes."""
    outputs = decode_table(stamps.get(OUTPUTS, {}), "stamps of outputs")
    for stamp in (*(stamps[name] for name in INPUTS if name in stamps), *outputs.values()):
        numbers = decode_list(stamp, "a stamp")
        if len(numbers) != 2 or not all(type(number) is int for number in numbers):
            raise DecodeError("a stamp is a size and a time")
