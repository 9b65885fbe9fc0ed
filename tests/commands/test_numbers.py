"""No option takes a number that is not finite."""

from __future__ import annotations

from collections.abc import Iterator

import click
import pytest

from phonanim.__main__ import commands
from phonanim.commands._numbers import Number


def options(command: click.Command, name: str = "") -> Iterator[tuple[str, click.Parameter]]:
    if isinstance(command, click.Group):
        context = click.Context(command)
        for part in command.list_commands(context):
            found = command.get_command(context, part)
            assert found is not None
            yield from options(found, f"{name} {part}")
    else:
        yield from ((f"{name} {parameter.name}", parameter) for parameter in command.params)


def test_every_option_of_a_number_checks_it() -> None:
    plain = [
        name
        for name, option in options(commands)
        if isinstance(option.type, click.FloatRange | type(click.FLOAT))
        and not isinstance(option.type, Number)
    ]
    assert plain == []


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "1e999", "-1", "x", ""])
def test_numbers_that_are_none(text: str) -> None:
    with pytest.raises(click.BadParameter):
        Number(0).convert(text, None, None)


def test_a_number() -> None:
    assert Number(0, 2).convert("1.5", None, None) == 1.5
