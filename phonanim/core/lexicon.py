"""Where the data tables are: those of the package, and those of the folders on PHONANIM_PATH."""

from __future__ import annotations

import os
import time
from functools import lru_cache
from pathlib import Path

_PACKAGE = Path(__file__).parent.parent
_INSTALLED = _PACKAGE / "lexicon"
LEXICON = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "lexicon"
"""The folder of data tables: inside the installed package, or next to it in a clone."""


SETTLED = 2_000_000_000  # nanoseconds after which a further change of a folder gets another time


def search_path() -> tuple[Path, ...]:
    """The folders of PHONANIM_PATH, laid out like the lexicon; missing folders are left out."""
    places = os.environ.get("PHONANIM_PATH", "").split(os.pathsep)
    return tuple(Path(place) for place in places if place and Path(place).is_dir())


def find_tables(kind: str) -> dict[str, Path]:
    """The TOML files of a kind, such as "languages", by name. The first file of a name wins.

    The files of the package come first, then those of each folder of PHONANIM_PATH, sorted by name.
    """
    found: dict[str, Path] = {}
    for folder in (LEXICON, *search_path()):
        tables = _tables(folder / kind)
        found |= {name: path for name, path in tables.items() if name not in found}
    return found


def _tables(folder: Path) -> dict[str, Path]:
    """The TOML files of a folder by name, sorted; listed again only when the folder has changed."""
    try:
        changed = folder.stat().st_mtime_ns
    except OSError:
        return {}
    if time.time_ns() - changed < SETTLED:  # a further change may get the same time
        return _by_stem(folder)
    return _listed(folder, changed)


@lru_cache(maxsize=64)
def _listed(folder: Path, changed: int) -> dict[str, Path]:
    return _by_stem(folder)


def _by_stem(folder: Path) -> dict[str, Path]:
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}
