"""Renamed options: the old spelling still works; help and errors show the new one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

Function = TypeVar("Function", bound=Callable[..., Any])


class RenamedOption(click.Option):
    """An option with `old` spellings, which are accepted but hidden."""

    def __init__(self, *args: Any, old: tuple[str, ...], **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        self.old = old

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Register all spellings with the command's parser."""
        shown = self.opts
        self.opts = [*shown, *self.old]
        super().add_to_parser(parser, ctx)
        self.opts = shown


def renamed_option(new: str, old: str, **attributes: Any) -> Callable[[Function], Function]:
    """An option `new` that is also accepted as `old`; the parameter of the command is named after `old`."""
    return click.option(new, old[2:], cls=RenamedOption, old=(old,), **attributes)
