"""Tables of lines: CSV, TSV or JSON Lines, with tolerant matching of column names."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeAlias

from phonanim.core.decode import DecodeError, decode_table, decode_text, parse_json
from phonanim.core.files import read_bounded
from phonanim.core.text import printable
from phonanim.dubbing.storage import Place
from phonanim.errors import OptionError

SUFFIXES = (".csv", ".tsv", ".jsonl", ".ndjson")
MAX_BYTES = 1 << 28  # of a table: a million lines have about 60 MB

# Every column and its other names; case, blanks and punctuation are ignored.
COLUMNS: dict[str, tuple[str, ...]] = {
    "id": ("line", "lineid", "key", "name", "utterance", "utteranceid", "uttid", "stringid", "vo", "voiceid"),
    "alignment": ("textgrid", "grid", "alignmentfile", "alignmentpath", "phones", "labels", "align"),
    "audio": ("wav", "sound", "recording", "audiofile", "audiopath", "voicefile", "media"),
    "text": ("transcript", "transcription", "sentence", "said"),
    "voice": ("espeakvoice", "ttsvoice", "spokenby"),
    "language": ("lang", "locale", "alphabet"),
    "fallback": ("fallbacklanguage", "languagefallback"),
    "rig": ("rigname", "face", "head"),
    "character": ("char", "charactername", "avatar", "characterfile", "glb", "vrm"),
    "model": ("modelname",),
    "tier": ("phonetier",),
    "speaker": ("who", "talker", "actor"),
    "lexicon": ("dictionary", "dict", "pronunciations"),
    "fps": ("framerate", "rate", "framespersecond"),
    "unknown": ("unknownlabels",),
    "unit": ("timeunit", "unitoftime"),
    "offset": ("timeoffset",),
    "style": ("manner", "delivery", "stylename"),
    "intensity": ("strength",),
    "jaw": (),
    "lips": (),
    "rounding": (),
    "quickness": (),
    "reduction": (),
    "hold": (),
    "loudness": (),
    "level": ("referencelevel", "levelreference"),
    "pitch": ("pitchmethod",),
    "gain": ("gains", "controlgains"),
    "smooth": ("smoothing",),
    "overlay": ("overlays", "overlayfile", "pose"),
    "life": ("alive", "idlemotion"),
    "life_seed": ("lifeseed", "seed"),
    "look_at": ("lookat", "gaze", "gazetarget"),
    "closure": ("closures",),
    "emotion": ("emotions", "mood", "feeling"),
    "edits": ("edit", "editsfile", "sidecar", "changes", "animatorsedits"),
    "timecode": ("tc", "starttimecode", "timecodein", "tcin"),
    "output": ("out", "outputpath", "outputname", "target", "destination"),
}


_SEPARATOR = re.compile(r"\ufeff?sep=([,;\t|])[ \t]*\r?\n", re.IGNORECASE)
"""A first line in which spreadsheets name the separator of the cells."""


@dataclass(frozen=True, slots=True)
class Row:
    """One row: its place, and its cells by canonical column; empty cells are left out."""

    place: str
    cells: dict[str, str]


@dataclass(frozen=True, slots=True)
class Table:
    """The rows of a file, the damaged rows (place, reason), and the names of unused columns."""

    rows: tuple[Row, ...]
    damaged: tuple[tuple[str, str], ...]
    unused: tuple[str, ...]


def read_table(path: Place) -> Table:
    """Read a table of lines. Raises OptionError, which names the missing column.

    A damaged row costs that row only, unless there is no other.
    """
    found = list(_records(path))
    records = [(number, record) for number, record in found if not isinstance(record, str)]
    damaged = tuple((f"{path.name} row {number}", why) for number, why in found if isinstance(why, str))
    if not records:
        why = f"row {found[0][0]}: {found[0][1]}" if found else "give it a header and one row per line"
        raise OptionError(f"{path}: has no lines; {why}")
    headers = list(dict.fromkeys(header for _, record in records for header in record))
    columns = {header: _canonical(header) for header in headers}
    _check(path, columns)
    rows = tuple(Row(f"{path.name} row {number}", _cells(record, columns)) for number, record in records)
    return Table(rows, damaged, tuple(header for header, column in columns.items() if column is None))


Records: TypeAlias = Iterator[tuple[int, dict[str, Any] | str]]


def _records(path: Place) -> Records:
    """The number of each row in an editor or a spreadsheet (from 1, including the header), and its cells.

    A row that cannot be read is the reason for it.
    """
    text = table_text(path)
    if path.suffix.lower() in (".jsonl", ".ndjson"):
        yield from _json_records(text)
        return
    named = _SEPARATOR.match(text)
    text = text[named.end() :] if named else text
    delimiter = named[1] if named else "\t" if path.suffix.lower() == ".tsv" else table_delimiter(text)
    skipped = 1 if named else 0
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    header: list[str] = []
    while True:
        try:
            row = next(reader, None)
        except csv.Error as error:
            yield reader.line_num + skipped, f"is not a row of a table ({error}); correct it"
            continue
        if row is None:
            return
        more = [cell for cell in row[len(header) :] if cell.strip()] if header else []
        if more:
            count = f"has {len(row)} cells for {len(header)} columns"
            yield reader.line_num + skipped, f"{count}; put a cell that has a {delimiter!r} in quotes"
        elif header and any(cell.strip() for cell in row):
            cells = zip(header, row, strict=False)
            yield reader.line_num + skipped, {name: cell for name, cell in cells if name}
        elif not header and any(cell.strip() for cell in row):
            header = [cell.strip() for cell in row]


def _json_records(text: str) -> Records:
    for number, line in enumerate(text.split("\n"), start=1):
        if line.strip():
            try:
                record = decode_table(parse_json(line), "the row")
                for name, value in record.items():
                    if isinstance(value, (dict, list)):
                        decode_text(value, printable(name))
                yield number, record
            except DecodeError as error:
                yield number, f"{error}; write one object per line"


def table_text(path: Place) -> str:
    """The text of a table, in UTF-8 or UTF-16. Raises OptionError."""
    try:
        data = read_bounded(path, MAX_BYTES) if isinstance(path, Path) else path.read_bytes()
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise OptionError(f"{path}: cannot be read: {error}") from error
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise OptionError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from error


def table_delimiter(text: str) -> str:
    """Comma, semicolon or tab: the most frequent one in the header."""
    header = text.lstrip().split("\n", 1)[0]
    return max(",;\t", key=header.count)


def _canonical(header: str) -> str | None:
    plain = re.sub(r"[\W_]+", "", header.lower())
    for column, others in COLUMNS.items():
        if plain == column or plain in others:
            return column
    return None


def _check(path: Place, columns: dict[str, str | None]) -> None:
    known = [column for column in columns.values() if column]
    if not {"alignment", "audio", "text"} & set(known):
        near = get_close_matches("alignment", list(columns), n=1, cutoff=0.5)
        hint = f"; is it {near[0]!r}?" if near else ""
        raise OptionError(f"{path}: has no column 'alignment', only {', '.join(map(repr, columns))}{hint}")
    for column in known:
        if known.count(column) > 1:
            twice = [header for header, name in columns.items() if name == column]
            raise OptionError(
                f"{path}: the columns {' and '.join(map(repr, twice))} both mean {column!r}; drop one"
            )


def _cells(record: dict[str, Any], columns: dict[str, str | None]) -> dict[str, str]:
    named = {columns[header]: str(value).strip() for header, value in record.items() if value is not None}
    return {column: value for column, value in named.items() if column and value}
