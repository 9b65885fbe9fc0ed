"""The options that `animate` and `batch` share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from typing import Any

import click

from phonanim.errors import OptionError
from phonanim.rates import parse_rate


class Rate(click.ParamType):
    """A frame rate: 60, 29.97 or 30000/1001."""

    name = "rate"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Frames per second; NTSC rates are taken exactly."""
        try:
            return parse_rate(str(value))
        except OptionError as error:
            self.fail(str(error), param, ctx)


GAIN = click.FloatRange(0, 4)

OPTIONS = (
    click.option("--rig", default="arkit", show_default=True, help="Rig, by name or TOML file."),
    click.option("--model", default="default", show_default=True, help="Model, by name or folder."),
    click.option(
        "--fps", type=Rate(), default="60", show_default=True, help="Frames per second: 25, 29.97, ..."
    ),
    click.option("--language", default="auto", show_default=True, help="Label set of the phone tier."),
    click.option("--tier", help="Phone tier, by name; found by name and content otherwise."),
    click.option(
        "--unknown",
        type=click.Choice(["error", "nearest", "silence"]),
        default="error",
        show_default=True,
        help="What becomes of a label that the language lacks.",
    ),
    click.option(
        "--contacts/--no-contacts", default=True, help="Make lips and teeth really meet on p b m f v."
    ),
    click.option(
        "--retarget",
        type=click.Choice(["auto", "poses", "direct"]),
        default="auto",
        show_default=True,
        help="Map to the rig by its eight poses or by its direct map.",
    ),
    click.option("--intensity", type=GAIN, default=1.0, show_default=True, help="Scale all motion."),
    click.option("--jaw", type=GAIN, default=1.0, show_default=True, help="Scale the motion of the jaw."),
    click.option("--lips", type=GAIN, default=1.0, show_default=True, help="Scale the motion of the lips."),
)


def animation_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options of an animation, handed to the command as `options`: phonanim.animate.Options."""

    @wraps(function)
    def wrapped(*args: Any, **given: Any) -> Any:
        from phonanim.animate import Options

        options = Options(**{field.name: given.pop(field.name) for field in fields(Options)})
        return function(*args, options=options, **given)

    decorated: Callable[..., Any] = wrapped
    for add in reversed(OPTIONS):
        decorated = add(decorated)
    return decorated
