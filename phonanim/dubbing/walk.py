"""Find the files of a local folder or pattern, report unreadable folders, and follow no links to folders."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from operator import attrgetter
from pathlib import Path

WILD = re.compile(r"[*?[]")
ANY_DEPTH = "**"


@dataclass(slots=True)
class Walk:
    """Files, sorted; the folders that cannot be read, with the reason; and links to folders, not followed."""

    files: list[Path] = field(default_factory=list)
    unreadable: list[tuple[Path, str]] = field(default_factory=list)
    links: list[Path] = field(default_factory=list)


def walk_folder(folder: Path) -> Walk:
    """Every file in a folder and below it; links to folders are not followed."""
    found = Walk()
    _below(folder, (ANY_DEPTH, "*"), found, hidden=True)
    return _sorted(found)


def walk_pattern(pattern: Path) -> Walk:
    """Every file that a pattern with wildcards matches, as in a shell; `**` does not follow links."""
    parts = pattern.parts
    first = next(number for number, part in enumerate(parts) if WILD.search(part))
    rest = [part for before, part in zip(("", *parts[first:]), parts[first:], strict=False) if part != before]
    rest = rest if rest[-1] != ANY_DEPTH else [*rest, "*"]
    found = Walk()
    _below(Path(*parts[:first]), tuple(rest), found, hidden=False)
    return _sorted(found)


def _sorted(found: Walk) -> Walk:
    files = sorted(set(found.files), key=attrgetter("parts"))  # much faster than comparing paths
    return Walk(files, sorted(set(found.unreadable)), sorted(set(found.links)))


def _below(folder: Path, parts: tuple[str, ...], found: Walk, hidden: bool) -> None:
    """Add the matches of a pattern's parts in a folder."""
    head, rest = parts[0], parts[1:]
    if head == ANY_DEPTH:
        _below(folder, rest, found, hidden)
        for entry in _entries(folder, found):
            if entry.is_dir(follow_symlinks=False) and (hidden or not entry.name.startswith(".")):
                _below(folder / entry.name, parts, found, hidden)
            elif entry.is_symlink() and entry.is_dir():
                found.links.append(folder / entry.name)
    elif WILD.search(head):
        for entry in _entries(folder, found):
            shown = hidden or head.startswith(".") or not entry.name.startswith(".")
            if shown and fnmatchcase(entry.name, head):
                _take(folder / entry.name, rest, found, hidden, entry.is_dir())
    else:
        _take(folder / head, rest, found, hidden, (folder / head).is_dir())


def _take(path: Path, rest: tuple[str, ...], found: Walk, hidden: bool, is_folder: bool) -> None:
    if rest and is_folder:
        _below(path, rest, found, hidden)
    elif not rest and not is_folder:
        found.files.append(path)


def _entries(folder: Path, found: Walk) -> Iterator[os.DirEntry[str]]:
    try:
        with os.scandir(folder or ".") as entries:
            yield from list(entries)
    except OSError as error:
        found.unreadable.append((folder, error.strerror or str(error)))
