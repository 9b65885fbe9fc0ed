"""The sidecar file of edits: JSON with one edit per line, so that it can be read, compared and merged."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from phonanim.animation.edits import Edit, Edits
from phonanim.core.decode import DAMAGE, read_json
from phonanim.core.files import write_text
from phonanim.errors import OptionError
from phonanim.speech.alignment import pack_intervals, unpack_intervals

FORMAT = "phonanim edits 1"
DIGITS = 9  # of a second, or of full weight: far below any useful error


def write_edits(edits: Edits, path: Path) -> None:
    """Write edits atomically. Raises OutputError."""
    write_text(path, edits_document(edits) + "\n")


def edits_document(edits: Edits, indent: str = "") -> str:
    """The JSON of edits, one edit per line."""
    head = {"format": FORMAT, "rig": edits.rig, "error": edits.error, "phones": pack_intervals(edits.phones)}
    lines = [f"{indent}  {_text(key)}: {_text(value)}" for key, value in head.items()]
    items = ",\n".join(f"{indent}    {_text(_plain(edit))}" for edit in edits.edits)
    lines.append(f'{indent}  "edits": [\n{items}\n{indent}  ]' if items else f'{indent}  "edits": []')
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"


def read_edits(path: Path) -> Edits:
    """Read edits back. Raises OptionError when the file is damaged or not a file of edits."""
    try:
        return parse_edits(read_json(path))
    except KeyError as error:
        raise OptionError(f"{path}: is not a file of edits: it lacks {error}") from error
    except (OSError, *DAMAGE) as error:
        raise OptionError(f"{path}: is not a file of edits: {error}") from error


def parse_edits(tree: Any) -> Edits:
    """Edits from their JSON. Raises KeyError, ValueError or TypeError for what are none."""
    if tree["format"] != FORMAT:
        raise ValueError(f"its format is {tree['format']!r}, not {FORMAT!r}")
    return Edits(
        rig=str(tree["rig"]),
        error=float(tree["error"]),
        phones=unpack_intervals(tree["phones"]),
        edits=tuple(_edit(item) for item in tree["edits"]),
    )


def _text(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _plain(edit: Edit) -> dict[str, Any]:
    keys = zip(edit.times, edit.values, strict=True)
    return {
        "channel": edit.channel,
        "kind": edit.kind,
        "start": round(edit.start, DIGITS),
        "end": round(edit.end, DIGITS),
        "fade": [round(seconds, DIGITS) for seconds in edit.fade],
        "keys": [[round(time, DIGITS), round(value, DIGITS)] for time, value in keys],
    }


def _edit(item: dict[str, Any]) -> Edit:
    """The inverse of `_plain`. Raises ValueError for an invalid edit."""
    if not item["keys"]:
        raise ValueError(f"an edit of {item['channel']} has no keys")
    times, values = zip(*((float(time), float(value)) for time, value in item["keys"]), strict=True)
    come, go = (float(seconds) for seconds in item["fade"])
    edit = Edit(
        str(item["channel"]),
        item["kind"],
        float(item["start"]),
        float(item["end"]),
        (come, go),
        times,
        values,
    )
    if edit.kind not in ("offset", "replace"):
        raise ValueError(f"{edit} has the kind {edit.kind!r}; it is offset or replace")
    if not all(map(math.isfinite, (edit.start, edit.end, come, go, *times, *values))):
        raise ValueError(f"{edit} holds a number that is not finite")
    if list(times) != sorted(times) or edit.start > edit.end:
        raise ValueError(f"{edit} has times that run backwards")
    if min(come, go) < 0 or come + go > edit.end - edit.start + 10.0**-DIGITS * 4:
        raise ValueError(f"{edit} has fades that are longer than it is")
    return edit
