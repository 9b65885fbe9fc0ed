"""Whether the program runs from a clone of its repository, where extras are installed by another name."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

EXTRAS = re.compile(r"pip install 'phonanim(\[[\w,]+\])'")


@cache
def clone_folder() -> Path | None:
    """The folder of the clone; None where the package is installed."""
    folder = Path(__file__).resolve().parents[2]
    return folder if (folder / "pyproject.toml").is_file() else None


def add_clone_hint(text: str, folder: Path | None) -> str:
    """A message that names an extra, and how to install it from a clone."""
    named = EXTRAS.search(text)
    if folder is None or named is None:
        return text
    return f"{text} (from a clone: pip install '.{named[1]}' in {folder})"
