"""JSON: the curves by name, for scripts and the web."""

from __future__ import annotations

import json
from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.decode import read_json
from phonanim.core.files import write_text
from phonanim.errors import OutputError
from phonanim.exporters._document import document, from_document

SUMMARY = "JSON: a list of values per channel, phones, words, provenance"


def write(animation: Animation, path: Path) -> None:
    """Write one object; see docs/output.md for its keys. Raises OutputError."""
    write_text(path, json.dumps(document(animation), ensure_ascii=False, separators=(",", ":")) + "\n")


def read(path: Path) -> Animation:
    """Read an animation back. Raises OutputError when phonanim did not write the file."""
    try:
        tree = read_json(path)
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read as JSON: {error}") from error
    return from_document(tree, path)
