"""The values of options: parsers, and how click calls them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import click

from phonanim.animation.option_parsing import parse_overlay
from phonanim.errors import OptionError
from phonanim.options import Emotion, Overlay


def option_callback(parse: Callable[[Any], Any]) -> Callable[[click.Context, click.Parameter, Any], Any]:
    """Make a click callback from a function that raises OptionError."""

    def read(ctx: click.Context, param: click.Parameter, value: Any) -> Any:
        try:
            return parse(value)
        except OptionError as error:
            raise click.BadParameter(str(error)) from error

    return read


def parse_overlays(values: tuple[str, ...]) -> tuple[Overlay, ...]:
    """Parse overlays."""
    return tuple(map(parse_overlay, values))


def read_life(text: str) -> float | Mapping[str, float]:
    """Parse the gain of each behaviour."""
    from phonanim.life.parsing import parse_life

    return parse_life(text)


def read_look_at(text: str | None) -> tuple[float, float, float] | None:
    """Parse the position of the listener's eyes, if it is given."""
    from phonanim.life.parsing import parse_look_at

    return parse_look_at(text) if text else None


def read_emotions(texts: tuple[str, ...]) -> tuple[Emotion, ...]:
    """Parse emotions."""
    from phonanim.life.parsing import parse_emotions

    return parse_emotions(texts)


def read_level(text: str | None) -> float | None:
    """Parse the usual level of speech, if it is given."""
    from phonanim.inputs.level import parse_level

    return parse_level(text) if text else None


def read_unit(text: str | None) -> str | None:
    """Check a unit of time, if it is given."""
    if text:
        from phonanim.speech.clock import parse_unit

        parse_unit(text)
    return text or None
