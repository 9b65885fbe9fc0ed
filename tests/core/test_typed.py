"""Values of tables against the fields of dataclasses."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pytest

from phonanim.core.typed import check_types
from phonanim.errors import ModelError
from phonanim.regressors import kinds, make_config, regressor_class


@dataclass(frozen=True)
class Inner:
    """Another table."""


@dataclass(frozen=True)
class Settings:
    """A field of every type that tables are read for."""

    share: float = 0.5
    count: int = 1
    name: str = ""
    fast: bool = False
    where: Path | None = None
    way: Literal["left", "right"] = "left"
    sizes: tuple[int, ...] = ()
    pair: tuple[int, int] = (1, 2)
    table: dict[str, Any] | None = None
    inner: Inner | None = None
    free: Any = None


GOOD: list[dict[str, Any]] = [
    {"share": 1},
    {"where": "here"},
    {"where": Path("here")},
    {"where": None},
    {"sizes": [1, 2, 3]},
    {"pair": (1, 2)},
    {"table": {"a": 1}, "inner": {"b": 2}, "free": [object]},
]
BAD = [
    ({"share": "x"}, "here: share is 'x'; take a number"),
    ({"count": 2.5}, "here: count is 2.5; take a whole number"),
    ({"count": True}, "here: count is True; take a whole number"),
    ({"name": 3}, "here: name is 3; take a text in quotes"),
    ({"fast": 1}, "here: fast is 1; take true or false"),
    ({"where": 3}, "here: where is 3; take a path in quotes"),
    ({"way": "up"}, "here: way is 'up'; take 'left', 'right'"),
    ({"sizes": [1, "a"]}, "here: sizes is [1, 'a']; take a list, each a whole number"),
    ({"sizes": "12"}, "here: sizes is '12'; take a list, each a whole number"),
    ({"pair": [1]}, "here: pair is [1]; take a list of 2, each a whole number"),
    ({"inner": 3}, "here: inner is 3; take a table"),
]


@pytest.mark.parametrize("values", GOOD)
def test_what_fits(values: dict[str, Any]) -> None:
    check_types(values, Settings, "here")


@pytest.mark.parametrize(("values", "message"), BAD)
def test_what_does_not(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError) as caught:
        check_types(values, Settings, "here")
    assert str(caught.value) == message


@pytest.mark.parametrize("kind", kinds())
def test_every_kind_takes_its_own_defaults(kind: str) -> None:
    defaults = vars(regressor_class(kind).config_class())
    assert make_config(kind, defaults, "here") == regressor_class(kind).config_class()


def test_a_setting_of_a_recipe_that_is_amiss() -> None:
    with pytest.raises(ModelError, match="here: decoder is 'gruu'; take 'mlp', 'lstm', 'gru', "):
        make_config("two_stage", {"decoder": "gruu"}, "here")
