"""The lines to animate: from a folder, a pattern or a table."""

from __future__ import annotations

import glob
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

from phonanim.audio import find_audio
from phonanim.dubbing.names import safe_name, same_file
from phonanim.dubbing.styles import DIALS, Styles, find_style, read_styles
from phonanim.dubbing.table import SUFFIXES as TABLES
from phonanim.dubbing.table import Row, read_table
from phonanim.errors import OptionError, PhonanimError
from phonanim.options import Options
from phonanim.rates import parse_rate

# Taken from a folder; a pattern or a table may name files of any suffix, since readers go by content.
ALIGNMENTS = (".textgrid", ".phn", ".lab", ".ctm", ".eaf", ".par", ".pgo")
WILD = re.compile(r"[*?[]")
TEXTS = ("rig", "model", "language", "tier", "speaker", "unknown")


@dataclass(frozen=True, slots=True)
class Line:
    """One line to animate: absolute paths, and `output`, relative to the output folder, without suffix.

    Where `text` is given, `alignment` is the recording: it is aligned with the text first.
    """

    id: str
    place: str
    alignment: Path
    audio: Path | None
    options: Options
    output: PurePosixPath
    text: str | None = None


@dataclass(frozen=True, slots=True)
class Fault:
    """A line that cannot be made, and why."""

    id: str
    place: str
    message: str


@dataclass(frozen=True, slots=True)
class Lines:
    """What a source holds: lines in order, the rows that are none, and remarks on the whole."""

    lines: tuple[Line, ...]
    faults: tuple[Fault, ...]
    remarks: tuple[str, ...] = ()


def read_lines(source: str, options: Options, styles: Path | None = None) -> Lines:
    """The lines of a folder, of a pattern with wildcards, or of a table (.csv .tsv .jsonl).

    Cells of a table stand before `options`; `styles` is the file of what its styles mean. Raises OptionError
    when the source as a whole is of no use.
    """
    path, known = Path(source), read_styles(styles)
    if path.is_dir():
        found = [file for file in sorted(path.rglob("*")) if file.suffix.lower() in ALIGNMENTS]
        return _checked(
            _rows_of(path, found), Path(), options, known, f"{source}: holds no {' or '.join(ALIGNMENTS)}"
        )
    if path.is_file() and path.suffix.lower() in TABLES:
        table = read_table(path)
        unused = [f"{path.name}: the column {name!r} is not used" for name in table.unused]
        lines = _checked(table.rows, path.parent, options, known, f"{source}: holds no row")
        return replace(lines, remarks=tuple(unused))
    if WILD.search(source):
        found = sorted(map(Path, glob.iglob(source, recursive=True)))  # noqa: PTH207 - may be absolute
        return _checked(
            _rows_of(_root(path), found), Path(), options, known, f"{source}: matches no alignment"
        )
    if path.exists():
        raise OptionError(f"{source}: is no folder and no table ({' '.join(TABLES)}); name one of these")
    raise OptionError(f"{source}: does not exist; name a folder, a pattern in quotes, or a table")


def _root(pattern: Path) -> Path:
    """The folder above the first wildcard."""
    plain = []
    for part in pattern.parts[:-1]:
        if WILD.search(part):
            break
        plain.append(part)
    return Path(*plain)


def _rows_of(root: Path, paths: Iterable[Path]) -> list[Row]:
    """A row for every file that is not hidden; the id is the path below `root` without suffix."""
    return [
        Row(str(path), {"id": _id(path.relative_to(root)), "alignment": str(path)})
        for path in paths
        if path.is_file() and not path.name.startswith(".")
    ]


def _id(path: Path) -> str:
    return path.with_suffix("").as_posix()


def _checked(rows: Iterable[Row], root: Path, options: Options, styles: Styles, empty: str) -> Lines:
    """Rows as lines; a row that repeats an id or an output is a fault, the first one stays."""
    lines: list[Line] = []
    faults: list[Fault] = []
    ids: dict[str, str] = {}
    names: dict[str, str] = {}
    for row in rows:
        id = row.cells.get("id", Path(row.cells.get("alignment", row.cells.get("audio", ""))).stem)
        try:
            line = _line(id, row, root, options, styles)
            _first(ids, line.id, row.place, f"the id {line.id!r}")
            _first(names, same_file(line.output), row.place, f"the output {str(line.output)!r}")
            lines.append(line)
        except PhonanimError as error:
            faults.append(Fault(id, row.place, str(error)))
    if not lines and not faults:
        raise OptionError(empty)
    return Lines(tuple(lines), tuple(faults))


def _first(seen: dict[str, str], key: str, place: str, what: str) -> None:
    if key in seen:
        raise OptionError(f"{what} was taken by {seen[key]}; give every line its own")
    seen[key] = place


def _line(id: str, row: Row, root: Path, options: Options, styles: Styles) -> Line:
    spoken = "alignment" not in row.cells
    if spoken and not {"audio", "text"} <= row.cells.keys():
        raise OptionError("the row names no alignment; fill its cell, or those of audio and text")
    alignment = (root / row.cells["audio" if spoken else "alignment"]).absolute()
    audio = (root / row.cells["audio"]).absolute() if "audio" in row.cells else find_audio(alignment)
    for path in (alignment, audio):
        if path and not path.is_file():
            raise OptionError(f"{path}: does not exist; correct the path")
    return Line(
        id=id,
        place=row.place,
        alignment=alignment,
        audio=audio,
        options=replace(options, **_overrides(row.cells, root, styles)),
        output=safe_name(row.cells.get("output", id)),
        text=row.cells["text"] if spoken else None,
    )


def _overrides(cells: Mapping[str, str], root: Path, styles: Styles) -> dict[str, Any]:
    chosen: dict[str, Any] = {name: cells[name] for name in TEXTS if name in cells}
    if "lexicon" in cells:
        chosen["lexicon"] = str((root / cells["lexicon"]).absolute())
    if chosen.get("unknown", "error") not in ("error", "nearest", "silence"):
        raise OptionError(f"unknown = {chosen['unknown']!r}; choose error, nearest or silence")
    if "style" in cells:
        chosen.update(find_style(cells["style"], styles))
    for name in DIALS:
        if name in cells:
            chosen[name] = _gain(name, cells[name])
    if "fps" in cells:
        chosen["fps"] = parse_rate(cells["fps"])
    return chosen


def _gain(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 4.0:
        raise OptionError(f"{name} = {text!r}; give a number from 0 to 4")
    return value
