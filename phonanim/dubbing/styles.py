"""Styles: named settings of the dials, so that a table can say "shouted" instead of three numbers."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path

from phonanim.core.decode import DecodeError, read_toml
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OptionError

DIALS = ("intensity", "jaw", "lips")
LARGEST = 4.0

Styles = Mapping[str, Mapping[str, float]]


def read_styles(path: Path | None = None) -> Styles:
    """The gains of each style by dial, from a TOML file or the package's. Raises OptionError."""
    path = path or LEXICON / "styles.toml"
    try:
        tables = read_toml(path)
    except OSError as error:
        raise OptionError(f"{path}: cannot be read: {error.strerror}") from error
    except DecodeError as error:
        raise OptionError(f"{path}: {error}; correct it") from error
    return {name.casefold(): _gains(name, table, path) for name, table in tables.items()}


def find_style(name: str, styles: Styles) -> Mapping[str, float]:
    """The gains of one style; case does not matter. Raises OptionError, which suggests the nearest name."""
    if name.casefold() in styles:
        return styles[name.casefold()]
    near = get_close_matches(name.casefold(), styles, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"choose {', '.join(styles)}"
    raise OptionError(f"there is no style {name!r}; {hint}")


def _gains(name: str, table: object, path: Path) -> dict[str, float]:
    if not isinstance(table, dict):
        raise OptionError(f"{path}: {name!r} is not a style; write [{name}] and its dials below")
    for dial, gain in table.items():
        if dial not in DIALS:
            raise OptionError(f"{path}: style {name!r}: {dial!r} is not a dial; there are {', '.join(DIALS)}")
        if isinstance(gain, bool) or not isinstance(gain, int | float) or not 0.0 <= gain <= LARGEST:
            raise OptionError(f"{path}: style {name!r}: {dial} = {gain!r}; give a number from 0 to 4")
    return {dial: float(gain) for dial, gain in table.items()}
