"""Styles: named settings of the dials, so that a table can use "shouted" instead of three numbers.

The name of a style that a model has learned is read here, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from phonanim.core.catalog import find_model, learned_styles
from phonanim.core.decode import DecodeError, read_toml
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OptionError

LARGEST = 4.0
RANGES = dict.fromkeys(("intensity", "jaw", "lips", "rounding", "reduction", "hold"), (0.0, LARGEST))
RANGES["quickness"] = 0.5, 2.0
DIALS = tuple(RANGES)
"""The options that a style sets, each within RANGES."""
LEARNED = "learned:"
"""Before the name of a style that a model has learned, where the name alone means another."""

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


@dataclass(frozen=True, slots=True)
class ChosenStyle:
    """A style by its `name`: the `number` of one that a model has learned, or else the gains of `dials`.

    `note` says what else the name could mean.
    """

    name: str = ""
    number: int | None = None
    dials: Mapping[str, float] = field(default_factory=dict)
    note: str = ""


def choose_style(name: str, model: str, styles: Styles) -> ChosenStyle:
    """A style: the number of one that the model has learned, a name of `styles`, or that of a learned one.

    After "learned:" the name is that of a learned style, whatever else it could mean. Raises OptionError for
    another, ModelError for a model that is not there.
    """
    learned = learned_styles(find_model(model))
    if name.startswith(LEARNED):
        return ChosenStyle(name, _learned_number(name.removeprefix(LEARNED), model, learned))
    if name.isdecimal():
        number = int(name)
        others = [one for place, one in enumerate(learned) if one == name and place != number]
        return ChosenStyle(name, number, note=_other_meaning(f"style number {name}", others))
    if name.casefold() in styles:
        others = [one for one in learned if one.casefold() == name.casefold()]
        return ChosenStyle(
            name, dials=find_style(name, styles), note=_other_meaning(f"the preset {name!r}", others)
        )
    if name in learned:
        return ChosenStyle(name, learned.index(name))
    return ChosenStyle(name, dials=find_style(name, styles, learned))


def spell_learned(learned: Sequence[str], styles: Styles) -> tuple[str, ...]:
    """How the learned styles of a model are chosen: by their names, with a prefix where these mean others."""
    return tuple(
        f"{LEARNED}{name}"
        if name.casefold() in styles or name.startswith(LEARNED) or (name.isdecimal() and int(name) != place)
        else name
        for place, name in enumerate(learned)
    )


def _learned_number(name: str, model: str, learned: tuple[str, ...]) -> int:
    if name in learned:
        return learned.index(name)
    near = get_close_matches(name, learned, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"choose {', '.join(learned)}"
    raise OptionError(
        f"the model {model} has learned no style {name!r}; {hint if learned else 'it has no named styles'}"
    )


def _other_meaning(taken: str, others: Sequence[str]) -> str:
    """A note on learned styles that are not taken, "" without any."""
    ways = " or ".join(f"{LEARNED}{name}" for name in others)
    return f"this is {taken}; the style of that name that the model has learned is {ways}" if others else ""


def find_style(name: str, styles: Styles, learned: tuple[str, ...] = ()) -> Mapping[str, float]:
    """The gains of one style; case does not matter.

    Raises OptionError, which suggests the nearest name, also of those that a model has `learned`.
    """
    if name.casefold() in styles:
        return styles[name.casefold()]
    near = get_close_matches(name, learned, n=1) or get_close_matches(name.casefold(), styles, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"choose {', '.join((*learned, *styles))}"
    raise OptionError(f"there is no style {name!r}; {hint}")


def _gains(name: str, table: object, path: Path) -> dict[str, float]:
    if not isinstance(table, dict):
        raise OptionError(f"{path}: {name!r} is not a style; write [{name}] and its settings below")
    for dial, gain in table.items():
        if dial not in DIALS:
            raise OptionError(
                f"{path}: style {name!r}: {dial!r} is not a setting; there are {', '.join(DIALS)}"
            )
        if isinstance(gain, bool) or not isinstance(gain, int | float):
            raise OptionError(f"{path}: style {name!r}: {dial} = {gain!r}; give {_range(dial)}")
        check_dial(dial, gain, f"{path}: style {name!r}: ")
    return {dial: float(gain) for dial, gain in table.items()}


def check_dial(dial: str, value: float, place: str = "") -> None:
    """Raise OptionError when a value is outside the range of its dial."""
    low, high = RANGES[dial]
    if not low <= value <= high:
        raise OptionError(f"{place}{dial} = {value:g}; give {_range(dial)}")


def parse_dial(dial: str, text: str) -> float:
    """The value of a dial. Raises OptionError."""
    try:
        value = float(text)
        check_dial(dial, value)
    except (ValueError, OptionError) as error:
        raise OptionError(f"{dial} = {text!r}; give {_range(dial)}") from error
    return value


def _range(dial: str) -> str:
    low, high = RANGES[dial]
    return f"a number from {low:g} to {high:g}"
