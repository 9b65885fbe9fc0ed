"""JSON: the curves by name, for scripts and the web."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE, read_json
from phonanim.core.files import write_pieces
from phonanim.errors import OutputError
from phonanim.exporters._a2f import from_audio2face, is_audio2face
from phonanim.exporters._document import curves, facts, from_document

SUMMARY = "JSON: a list of values per channel, phones, words, provenance"


def write(animation: Animation, path: Path) -> None:
    """Write one object; see docs/output.md for its keys. Raises OutputError."""
    write_pieces(path, _pieces(animation))


def _pieces(animation: Animation) -> Iterator[str]:
    """The text of the object, curve by curve."""
    yield _text(facts(animation))[:-1] + ',"curves":{'
    for number, (name, values) in enumerate(curves(animation)):
        yield f"{',' if number else ''}{_text(name)}:{_text(values)}"
    yield "}}\n"


def _text(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def read(path: Path) -> Animation:
    """Read an animation back, or an export of Audio2Face. Raises OutputError for any other file."""
    try:
        tree = read_json(path)
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read as JSON: {error}") from error
    if not is_audio2face(tree):
        return from_document(tree, path)
    try:
        return from_audio2face(tree, path)
    except DAMAGE as error:
        raise OutputError(f"{path}: is not an export of Audio2Face: {error}") from error
