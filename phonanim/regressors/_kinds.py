"""The kinds of regressors by name, and their settings."""

from __future__ import annotations

from dataclasses import fields
from difflib import get_close_matches
from typing import Any

from phonanim.core.plugins import Registry
from phonanim.core.typed import check_types
from phonanim.errors import ModelError
from phonanim.regressors._contract import check_class, check_required
from phonanim.regressors._protocol import Regressor
from phonanim.regressors._ranges import check_range

REGRESSORS = Registry("phonanim.regressors", needs=("REGRESSOR",))


def kinds() -> tuple[str, ...]:
    """Every kind of regressor: the stems of this folder's files, and the plugins."""
    return REGRESSORS.names()


def kind_of(regressor: Regressor) -> str:
    """The name of a regressor's kind: that of the file or of the plugin whose module defines its class."""
    return REGRESSORS.name_of(type(regressor).__module__)


def regressor_class(kind: str) -> type[Regressor]:
    """The class of a kind. Raises ModelError, which suggests the nearest name, when there is none."""
    found = REGRESSORS.find(kind)
    if found is not None:
        check_class(found, kind)
    else:
        near = get_close_matches(kind, kinds(), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ModelError(f"there is no regressor {kind!r}{hint} (known: {', '.join(kinds())})")
    regressor: type[Regressor] = found.REGRESSOR
    return regressor


def make_config(kind: str, values: dict[str, Any], where: str) -> Any:
    """The Config of a kind from a table of values. Raises ModelError, which names an invalid key."""
    config = regressor_class(kind).config_class
    known = [field.name for field in fields(config)]
    for key in values:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(known)}"
            raise ModelError(f"{where}: {kind} has no setting {key!r}; {hint}")
    check_types(values, config, where)
    check_required(config, values, where)
    own = config.__module__.startswith("phonanim.")
    for key, value in values.items():
        check_range(key, value, where, own)
    try:
        return config(**{key: tuple(v) if isinstance(v, list) else v for key, v in values.items()})
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from error
