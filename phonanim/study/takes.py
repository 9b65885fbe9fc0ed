"""The videos of a study: one per system and line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from phonanim.core.decode import DecodeError
from phonanim.core.files import read_bounded
from phonanim.core.tables import read_rows
from phonanim.errors import StudyError

MAX_FILM = 1 << 28  # bytes of a film, which a page holds as text
TYPES = {".mp4": "video/mp4", ".webm": "video/webm"}
TABLES = (".csv", ".tsv")
KINDS = ("test", "practice")
SOUND_MARKS = (b"soun", b"A_OPUS", b"A_VORBIS")  # marks of an audio track in MP4 and in WebM


@dataclass(frozen=True, slots=True)
class Line:
    """One spoken line: its video by system, and whether it is for `practice` or for the `test`."""

    item: str
    films: Mapping[str, Path]
    kind: str = "test"


def read_takes(sources: Sequence[Path]) -> tuple[Line, ...]:
    """The lines of a table, or of folders with one video per line, where the folder's name is the system.

    A table has the column `item`, one column per system with the paths of its videos, and optionally `kind`
    (test or practice). Raises StudyError when a video is missing, or is not a video with sound.
    """
    tables = [source for source in sources if source.suffix.lower() in TABLES]
    if tables and len(sources) > 1:
        raise StudyError(f"{tables[0]}: a table has all systems; give it alone, or give folders")
    lines = _of_table(tables[0]) if tables else _of_folders(sources)
    for line in lines:
        for film in line.films.values():
            check_film(film)
    return lines


def systems_of(lines: Sequence[Line]) -> tuple[str, ...]:
    """The systems, in the given order."""
    return tuple(lines[0].films)


def check_film(path: Path) -> None:
    """Raise StudyError unless the file is an MP4 or WebM video with an audio track."""
    if path.suffix.lower() not in TYPES:
        raise StudyError(f"{path}: browsers play {' and '.join(TYPES)}; convert it to one of them")
    try:
        data = read_bounded(path, MAX_FILM)
    except (OSError, ValueError) as error:
        raise StudyError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from error
    if data[4:8] != b"ftyp" and data[:4] != b"\x1a\x45\xdf\xa3":
        raise StudyError(f"{path}: is not an MP4 or WebM video; make it again")
    if not any(mark in data for mark in SOUND_MARKS):
        raise StudyError(f"{path}: has no audio track; make it with `phonanim animate --audio`")


def _of_folders(folders: Sequence[Path]) -> tuple[Line, ...]:
    films = {folder.resolve().name: _films(folder) for folder in folders}
    if len(films) < len(folders):
        raise StudyError("two folders have the same name; name each after its system")
    if len(films) < 2:
        raise StudyError(f"{folders[0]}: is one system; a study compares two or more folders")
    for (one, before), (other, after) in pairwise(films.items()):
        for stem in sorted(set(before) ^ set(after)):
            lacking = one if stem in after else other
            raise StudyError(f"{lacking}: has no video {stem}; every folder needs one of the same name")
    stems = next(iter(films.values()))
    return tuple(Line(stem, {system: found[stem] for system, found in films.items()}) for stem in stems)


def _films(folder: Path) -> dict[str, Path]:
    """The videos of a folder by their stem."""
    if not folder.is_dir():
        raise StudyError(f"{folder}: is not a folder of videos or a table ({' '.join(TABLES)})")
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() in TYPES and not path.name.startswith("."):
            if path.stem in found:
                raise StudyError(f"{path}: the folder also has {found[path.stem].name}; keep one of them")
            found[path.stem] = path
    if not found:
        raise StudyError(f"{folder}: has no video ({' '.join(TYPES)})")
    return found


def _of_table(path: Path) -> tuple[Line, ...]:
    header, *rows = _cells(path)
    if "item" not in header or len(set(header)) < len(header):
        raise StudyError(
            f"{path}: needs one column 'item' and one per system; it has {', '.join(header)[:200]}"
        )
    systems = [name for name in header if name not in ("item", "kind")]
    if len(systems) < 2:
        raise StudyError(f"{path}: names {len(systems)} systems; a study compares two or more")
    lines = [
        _line(path, number, dict(zip(header, row, strict=False)), systems)
        for number, row in non_empty_rows(rows)
    ]
    known: set[str] = set()
    for line in lines:
        if line.item in known:
            raise StudyError(f"{path}: the item {line.item} is in two rows; name each line once")
        known.add(line.item)
    if not lines:
        raise StudyError(f"{path}: has no line; give it one row per line")
    return tuple(lines)


def non_empty_rows(rows: Sequence[list[str]]) -> list[tuple[int, list[str]]]:
    """Rows that are not empty, with their number; the header is row 1."""
    return [(number, row) for number, row in enumerate(rows, start=2) if any(row)]


def _cells(path: Path) -> list[list[str]]:
    try:
        rows = read_rows(path, "\t" if path.suffix.lower() == ".tsv" else ",")
        return [[cell.strip() for cell in row] for row in rows] or [[]]
    except (OSError, DecodeError) as error:
        raise StudyError(f"{path}: cannot be read as a table: {error}") from error


def _line(path: Path, number: int, cells: Mapping[str, str], systems: Sequence[str]) -> Line:
    place = f"{path} row {number}"
    missing = [name for name in ("item", *systems) if not cells.get(name)]
    if missing:
        raise StudyError(f"{place}: the cell {missing[0]!r} is empty; fill it in")
    kind = cells.get("kind") or "test"
    if kind not in KINDS:
        raise StudyError(f"{place}: the kind is {kind!r}; use one of {', '.join(KINDS)}")
    return Line(cells["item"], {name: path.parent / cells[name] for name in systems}, kind)
