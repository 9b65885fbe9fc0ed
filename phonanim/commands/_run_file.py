"""run.json: how a batch was called, so that a review of its outputs knows the same lines."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from phonanim.dubbing.storage import Place

FORMAT = "phonanim run 1"
ARGUMENTS = f"{__name__}.arguments"


class KeptCommand(click.Command):
    """A command that remembers the arguments that it was called with."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Remember the arguments, and parse them."""
        ctx.meta[ARGUMENTS] = list(args)
        return super().parse_args(ctx, args)


def keep_arguments(folder: Place) -> None:
    """Write how the running command was called to its output folder, where it is on this machine."""
    from phonanim.dubbing.reserve import RUN
    from phonanim.dubbing.storage import write

    if not isinstance(folder, Path):
        return
    arguments = without_output(click.get_current_context().meta[ARGUMENTS])
    where = os.path.relpath(Path.cwd(), folder)
    document = {"format": FORMAT, "folder": Path(where).as_posix(), "arguments": arguments}
    write(folder / RUN, json.dumps(document, indent=1, ensure_ascii=False) + "\n")


def without_output(arguments: list[str]) -> list[str]:
    """Arguments without the output folder, which is where they are kept."""
    found: list[str] = []
    skipped = False
    for argument in arguments:
        if skipped or argument in ("-o", "--output"):
            skipped = not skipped
        elif not argument.startswith(("-o", "--output=")):
            found.append(argument)
    return found


def call_as_kept(folder: Path, command: click.Command, function: Callable[..., Any]) -> Any:
    """What a function gives for the options of the run in a folder, None where it is not kept.

    Raises OptionError for a damaged file, and what parsing the options raises.
    """
    from phonanim.core.decode import DAMAGE, decode_list, decode_text, read_json
    from phonanim.dubbing.reserve import RUN
    from phonanim.errors import OptionError

    path = folder / RUN
    try:
        tree = read_json(path)
        if tree["format"] != FORMAT:
            raise ValueError(f"its format is {tree['format']!r:.40}, not {FORMAT!r}")
        arguments = [decode_text(one, "an argument") for one in decode_list(tree["arguments"], "arguments")]
        where = folder / decode_text(tree["folder"], "folder")
    except FileNotFoundError:
        return None
    except (OSError, *DAMAGE) as error:
        raise OptionError(f"{path}: is damaged: {error}; remove it, and give --source") from error
    try:
        given = [*arguments, "--output", str(folder.absolute())]
        with _standing_in(where), command.make_context("batch", given) as context:
            return context.invoke(function, **context.params)
    except click.exceptions.Exit as error:  # of an option that prints something, and ends
        raise OptionError(f"{path}: is damaged: it asks for help; remove it, and give --source") from error
    except (click.ClickException, OSError, ValueError) as error:
        why = error.format_message() if isinstance(error, click.ClickException) else str(error)
        raise OptionError(f"{path}: the lines of the run are not there: {why}; give --source") from error


@contextmanager
def _standing_in(folder: Path) -> Iterator[None]:
    """Paths are relative to a folder for a while."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
