"""Where the data tables lie."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parent.parent
_INSTALLED = _PACKAGE / "lexicon"
LEXICON = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "lexicon"
"""The folder of data tables: inside the installed package, or beside it in a clone."""
