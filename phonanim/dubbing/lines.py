"""The lines to animate: from a folder, a pattern or a table."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from phonanim.core.text import printable
from phonanim.dubbing.align_lines import voice_of
from phonanim.dubbing.line import Line
from phonanim.dubbing.listing import forget_folders
from phonanim.dubbing.output_names import collision_key
from phonanim.dubbing.pairing import ALIGNMENTS, split_files, stem_of, without_suffix
from phonanim.dubbing.row import EDITS, Common, parse_row
from phonanim.dubbing.storage import Place, Remote, forget_listings, parse_place
from phonanim.dubbing.table import SUFFIXES as TABLES
from phonanim.dubbing.table import Row, read_table
from phonanim.dubbing.walk import WILD, Walk, walk_folder, walk_pattern
from phonanim.errors import OptionError, PhonanimError


@dataclass(frozen=True, slots=True)
class Fault:
    """A line that cannot be made, and the reason."""

    id: str
    place: str
    message: str
    language: str = ""


@dataclass(frozen=True, slots=True)
class Lines:
    """The content of a source: lines in order, invalid rows, and remarks on the whole."""

    lines: tuple[Line, ...]
    faults: tuple[Fault, ...]
    notes: tuple[str, ...] = ()


def read_lines(source: str, common: Common) -> Lines:
    """The lines of a folder, of a pattern with wildcards, or of a table (.csv .tsv .jsonl), by path or URL.

    Cells of a table override `common`. Raises OptionError when the source as a whole is invalid.
    """
    forget_listings()
    forget_folders()
    path = parse_place(source)
    notes: list[str] = []
    if path.suffix.lower() in TABLES and path.is_file():
        table = read_table(path)
        notes = [f"{path.name}: the column {name!r} is not used" for name in table.unused]
        damaged = [Fault(*map(printable, (place, place, why))) for place, why in table.damaged]
        lines = _checked(table.rows, path.parent, common, f"{source}: has no rows", damaged)
    elif path.is_dir() or WILD.search(str(path)):
        root, found = (path, _walked(path)) if path.is_dir() else (_root(path), _matched(path))
        files, spoken, apart = split_files(found[0]) if path.is_dir() else (found[0], {}, [])
        none = f"has no {' or '.join(ALIGNMENTS)}" if path.is_dir() else "matches no alignment"
        rows = [*_rows_of(root, files), *_spoken_rows(root, spoken)]
        lines = _checked(rows, root, common, f"{source}: {none}", found[1])
        notes = [*found[2], *apart]
    else:
        raise _useless(source, path)
    remarks = (*common.remarks, *_spoken(lines.lines), *_idle_edits(common.edits, lines.lines))
    return replace(lines, notes=(*notes, *remarks))


def _spoken(lines: Sequence[Line]) -> list[str]:
    """A remark on the lines that are spoken, with their voices."""
    voices = Counter(voice_of(line) for line in lines if line.is_spoken)
    if not voices:
        return []
    each = ", ".join(f"{voice} {count}" for voice, count in sorted(voices.items()))
    return [f"{voices.total()} of {len(lines)} lines have no recording: eSpeak NG speaks them ({each})"]


def _useless(source: str, path: Place) -> OptionError:
    if path.is_file():
        return OptionError(f"{source}: is not a folder or a table ({' '.join(TABLES)}); name one of these")
    return OptionError(f"{source}: does not exist; name a folder, a pattern in quotes, or a table")


WORDS_OF_ID = 6  # of its text, in the name of a line without an id
Walked = tuple[Sequence[Place], list[Fault], list[str]]


def files_below(folder: Place) -> Sequence[Place]:
    """Every file in a folder and below it, sorted."""
    return _walked(folder)[0]


def _walked(folder: Place) -> Walked:
    """The files of a folder, the folders that cannot be read, and remarks."""
    return (folder.files(), [], []) if isinstance(folder, Remote) else _plain(walk_folder(folder), folder)


def _matched(pattern: Place) -> Walked:
    if isinstance(pattern, Remote):
        return pattern.glob(), [], []
    return _plain(walk_pattern(pattern), Path(str(_root(pattern))))


def _plain(found: Walk, root: Path) -> Walked:
    faults = [
        Fault(
            printable(os.path.relpath(path, root)),
            printable(str(path)),
            f"the folder cannot be read: {why}; change its permissions, or leave it out",
        )
        for path, why in found.unreadable
    ]
    notes = [f"{printable(str(path))}: is a link to a folder, and is not followed" for path in found.links]
    return found.files, faults, notes


def _root(pattern: Place) -> Place:
    """The folder above the first wildcard."""
    root = pattern.parent
    while WILD.search(str(root)):
        root = root.parent
    return root


def _rows_of(root: Place, paths: Iterable[Place]) -> list[Row]:
    """A row for every file that is not hidden; the id is the path below `root` without suffix."""
    files = [path for path in paths if not path.name.startswith(".") and path.is_file()]
    names = [path_below(path, root) for path in files]
    return [
        Row(str(path), {"id": without_suffix(name), "alignment": name})
        for path, name in zip(files, names, strict=True)
    ]


def _spoken_rows(root: Place, spoken: Mapping[Place, str]) -> list[Row]:
    """A row for every recording with its transcript."""
    names = {path: path_below(path, root) for path in spoken}
    return [
        Row(str(path), {"id": without_suffix(names[path]), "audio": names[path], "text": text})
        for path, text in spoken.items()
    ]


def path_below(path: Place, folder: Place) -> str:
    """The path of a file below a folder, with slashes; both are paths, or both are remote."""
    if isinstance(path, Remote) and isinstance(folder, Remote):
        return str(path.relative_to(folder))
    whole, above = str(path), f"{folder}{os.sep}"
    if whole.startswith(above):
        return whole[len(above) :].replace(os.sep, "/")
    return Path(whole).relative_to(Path(str(folder))).as_posix()


def _checked(
    rows: Iterable[Row], root: Place, common: Common, empty: str, known: Sequence[Fault] = ()
) -> Lines:
    """Convert rows to lines; a row that repeats an id or an output is a fault, and the first one is kept."""
    lines: list[Line] = []
    faults: list[Fault] = [*known]
    ids: dict[str, str] = {}
    names: dict[str, str] = {}
    rows = list(rows)
    speaks = not any({"alignment", "audio"} & row.cells.keys() for row in rows)
    for row in rows:
        id = row.cells.get("id") or _named(row.cells)
        try:
            _check_text(row)
            line = parse_row(id, row, root, common, speaks)
            _first(ids, line.id, row.place, f"the id {line.id!r}")
            _first(names, collision_key(line.output), row.place, f"the output {str(line.output)!r}")
            lines.append(line)
        except (PhonanimError, OSError, ValueError) as error:
            why = str(getattr(error, "strerror", None) or error)
            fields = (id, row.place, why, row.cells.get("language", ""))
            faults.append(Fault(*map(printable, fields)))
    if not lines and not faults:
        raise OptionError(empty)
    return Lines(tuple(lines), tuple(faults))


def _named(cells: Mapping[str, str]) -> str:
    """The id of a row without one: the stem of its file, else the first words of its text."""
    file = cells.get("alignment") or cells.get("audio") or cells.get("voice", "")
    if "text" not in cells or "." in file:
        return stem_of(file)
    return "_".join(re.findall(r"\w+", cells["text"])[:WORDS_OF_ID])


def _check_text(row: Row) -> None:
    """Raise OptionError when a cell cannot be written as UTF-8."""
    for column, cell in row.cells.items():
        if printable(cell) != cell:
            raise OptionError(
                f"{column} = {printable(cell)!r} is not UTF-8; rename the file, or write another"
            )


def _first(seen: dict[str, str], key: str, place: str, what: str) -> None:
    if key in seen:
        raise OptionError(f"{what} is already used by {seen[key]}; give every line another")
    seen[key] = place


def _idle_edits(folder: Place | None, lines: Sequence[Line]) -> list[str]:
    """A remark on each file of edits without a line."""
    if folder is None:
        return []
    used = {line.edits for line in lines}
    edits = [path.absolute() for path in files_below(folder) if path.name.endswith(EDITS)]
    return [f"{path}: belongs to no line" for path in edits if path not in used]
