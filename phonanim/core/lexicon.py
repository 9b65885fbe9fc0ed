"""Where the data tables lie: those of the package, and those of the folders of PHONANIM_PATH."""

from __future__ import annotations

import os
from pathlib import Path

_PACKAGE = Path(__file__).parent.parent
_INSTALLED = _PACKAGE / "lexicon"
LEXICON = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "lexicon"
"""The folder of data tables: inside the installed package, or beside it in a clone."""


def search_path() -> tuple[Path, ...]:
    """The folders of PHONANIM_PATH, laid out like the lexicon; those that do not exist are left out."""
    places = os.environ.get("PHONANIM_PATH", "").split(os.pathsep)
    return tuple(Path(place) for place in places if place and Path(place).is_dir())


def find_tables(kind: str) -> dict[str, Path]:
    """The TOML files of a kind, such as "languages", by name; the first of a name counts.

    The files of the package come first, then those of each folder of PHONANIM_PATH, each sorted by name.
    """
    found: dict[str, Path] = {}
    for folder in (LEXICON, *search_path()):
        for path in sorted((folder / kind).glob("*.toml")):
            found.setdefault(path.stem, path)
    return found
