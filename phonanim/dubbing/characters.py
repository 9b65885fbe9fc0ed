"""The characters of a show: what a name in a table's column `character` stands for."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from phonanim.articulation.styles import DIALS
from phonanim.core.decode import DecodeError, read_toml
from phonanim.dubbing.table import table_delimiter, table_text
from phonanim.errors import OptionError
from phonanim.media.audio import RECORDINGS
from phonanim.rig.read import find_rig

# What a character may have, and the column of a table of lines that it fills.
KEYS = {
    **{"rig": "rig", "mesh": "character", "style": "style", "language": "language", "voice": "level"},
    **{"fallback": "fallback", "lexicon": "lexicon", "model": "model", "gain": "gain"},
    **{dial: dial for dial in DIALS},
}
NAME = "name"


@dataclass(frozen=True, slots=True)
class Characters:
    """The cells that each character fills, by its name in lower case, and the file that they are from."""

    source: str = ""
    cells: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def fill(self, row: Mapping[str, str]) -> dict[str, str]:
        """The cells of a row, and what its character has where they are empty."""
        name = row.get("character", "")
        known = self.cells.get(name.casefold())
        if known is None:
            return dict(row)
        return {**known, **{column: cell for column, cell in row.items() if column != "character"}}

    def suggest(self, name: str) -> str:
        """Where a name was looked for, and the nearest that is there."""
        near = get_close_matches(name.casefold(), list(self.cells), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        if not self.source:
            return "name a rig, or give --characters FILE with an entry of that name"
        return f"add it to {self.source}, or name a rig{hint}"


def read_characters(path: Path | None, meshes: bool = True) -> Characters:
    """Read a file of characters (TOML or CSV); without `meshes` their meshes are left out.

    Files that it names are relative to it. Raises OptionError, RigError for what cannot be used.
    """
    if path is None:
        return Characters()
    found: dict[str, dict[str, str]] = {}
    for name, entry in _entries(path):
        place = f"{path}: {name}"
        if name.casefold() in found:
            raise OptionError(f"{place}: appears twice; give every character one entry")
        cells = {KEYS[key]: _cell(place, key, value, path.parent) for key, value in entry.items()}
        if not meshes:
            cells.pop("character", None)
        found[name.casefold()] = cells
    if not found:
        raise OptionError(f'{path}: has no character; write [NAME] and rig = "metahuman", for example')
    return Characters(path.name, found)


def _entries(path: Path) -> Iterator[tuple[str, dict[str, str]]]:
    tables = _csv_entries(path) if path.suffix.lower() in (".csv", ".tsv") else _toml_entries(path)
    for name, entry in tables:
        for key in entry:
            if key not in KEYS:
                near = get_close_matches(key, list(KEYS), n=1)
                hint = f"did you mean {near[0]!r}?" if near else f"it may have {', '.join(KEYS)}"
                raise OptionError(f"{path}: {name}: has an unknown key {key!r}; {hint}")
        yield name, entry


def _toml_entries(path: Path) -> Iterator[tuple[str, dict[str, str]]]:
    try:
        tree = read_toml(path)
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from error
    except DecodeError as error:
        raise OptionError(f"{path}: {error}") from error
    for name, entry in tree.items():
        if not isinstance(entry, dict):
            raise OptionError(f"{path}: {name!r} is not a character; write [{name}] and its keys below")
        yield name, {key: _plain(path, name, value) for key, value in entry.items()}


def _plain(path: Path, name: str, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise OptionError(f"{path}: {name}: {value!r:.60} is not a text or a number")
    return str(value)


def _csv_entries(path: Path) -> Iterator[tuple[str, dict[str, str]]]:
    text = table_text(path)
    delimiter = "\t" if path.suffix.lower() == ".tsv" else table_delimiter(text)
    try:
        rows = list(csv.DictReader(io.StringIO(text, newline=""), delimiter=delimiter))
    except csv.Error as error:
        raise OptionError(f"{path}: is not a table of characters: {error}") from error
    for number, row in enumerate(rows, start=2):
        cells = {
            str(key).strip().lower(): value.strip() for key, value in row.items() if isinstance(value, str)
        }
        name = cells.pop(NAME, "")
        if not name:
            raise OptionError(f"{path} row {number}: has no {NAME!r}; fill that column")
        yield name, {key: value for key, value in cells.items() if value}


def _cell(place: str, key: str, value: str, folder: Path) -> str:
    """The cell for a value; a file is named by its absolute path. Raises OptionError, RigError."""
    if key == "rig":
        path = folder / value
        if path.suffix == ".toml" and path.is_file():
            return str(path.absolute())
        find_rig(value)
        return value
    is_file = key in ("mesh", "lexicon") or (key == "voice" and value.lower().endswith(RECORDINGS))
    if not is_file:
        return value
    path = (folder / value).absolute()
    if not path.is_file():
        raise OptionError(f"{place}: {key} = {value!r}: {path} does not exist; correct the path")
    return str(path)
