"""Check values of a TOML or JSON table against the types of a dataclass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from phonanim.errors import ModelError, PhonanimError

NAMES = {
    int: "a whole number",
    float: "a number",
    str: "a text in quotes",
    bool: "true or false",
    Path: "a path in quotes",
    dict: "a table",
}
WRITTEN: dict[Any, tuple[type, ...]] = {float: (float, int), Path: (str, Path)}  # types accepted for a type


def check_types(
    values: Mapping[str, Any], kind: type, where: str, error: type[PhonanimError] = ModelError
) -> None:
    """Raise an error that names the key of a value of the wrong type; lists are accepted for tuples."""
    types = get_type_hints(kind)
    for key, value in values.items():
        if not _fits(value, types[key]):
            raise error(f"{where}: {key} is {value!r}; take {_name(types[key])}")


def _fits(value: Any, wanted: Any) -> bool:
    origin, inner = get_origin(wanted), get_args(wanted)
    if wanted is Any:
        return True
    if origin is Literal:
        return value in inner
    if origin in (Union, UnionType):
        return any(_fits(value, choice) for choice in inner)
    if origin is tuple:
        return isinstance(value, list | tuple) and _all_fit(value, inner)
    if origin in (dict, Mapping):
        return isinstance(value, Mapping) and all(_fits(one, inner[1]) for one in value.values())
    if is_dataclass(wanted):
        return isinstance(value, dict | wanted)
    if isinstance(value, bool):
        return wanted is bool
    return isinstance(value, WRITTEN.get(wanted, wanted))


def _all_fit(values: Any, types: tuple[Any, ...]) -> bool:
    if types[-1] is ...:
        return all(_fits(value, types[0]) for value in values)
    return len(values) == len(types) and all(map(_fits, values, types))


def _name(wanted: Any) -> str:
    """What a field accepts, in words for messages."""
    origin, inner = get_origin(wanted), get_args(wanted)
    if origin is Literal:
        return ", ".join(map(repr, inner))
    if origin in (Union, UnionType):
        return " or ".join(_name(choice) for choice in inner if choice is not NoneType)
    if origin is tuple:
        count = "" if inner[-1] is ... else f" of {len(inner)}"
        return f"a list{count}, each {_name(inner[0])}"
    if origin in (dict, Mapping):
        return "a table" if inner[1] is Any else f"a table, each value {_name(inner[1])}"
    return NAMES.get(wanted, "a table")
