"""Names in local folders, each folder listed once: most of the files that a line may have do not exist."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterable
from functools import cache
from pathlib import Path


def first_listed(base: str, suffixes: Iterable[str]) -> Path | None:
    """The first local file that has this path with one of the suffixes, None where there is none.

    The system is asked only about names that the folder has in some spelling.
    """
    folder, stem = os.path.split(base)
    names, stem = _names(folder), folded_name(stem)
    listed = (Path(base + suffix) for suffix in suffixes if stem + suffix.lower() in names)
    return next((path for path in listed if path.is_file()), None)


def forget_folders() -> None:
    """Forget the names, because files may have come or gone."""
    _names.cache_clear()


@cache
def _names(folder: str) -> frozenset[str]:
    try:
        with os.scandir(folder or ".") as entries:
            return frozenset(folded_name(entry.name) for entry in entries)
    except OSError:
        return frozenset()


def folded_name(name: str) -> str:
    """A key that is equal for names that some file system treats as one: case and composition are folded."""
    return name.casefold() if name.isascii() else unicodedata.normalize("NFC", name).casefold()
