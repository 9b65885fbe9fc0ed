"""The command line: one command per file of phonanim/commands/, imported only when it is called."""

from __future__ import annotations

import gc
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NoReturn

import click
from click.exceptions import NoArgsIsHelpError

from phonanim.core.clone import add_clone_hint, clone_folder
from phonanim.core.plugins import describe_failure
from phonanim.core.text import printable
from phonanim.core.version import __version__
from phonanim.errors import PhonanimError

BAD_INPUT = 2
CLOSED_PIPE = 141  # the exit code that shells use for SIGPIPE
INTERRUPTED = 130


class CommandFolder(click.Group):
    """A click group whose commands are the files of a folder: the stem is the name."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The stems of the folder, in alphabetical order."""
        folder = Path(__file__).parent / "commands"
        return sorted(path.stem for path in folder.glob("[a-z]*.py"))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The object `command` in the file with that name."""
        if cmd_name not in self.list_commands(ctx):
            return None
        command: click.Command = import_module(f"phonanim.commands.{cmd_name}").command
        return command


@click.group(
    cls=CommandFolder, context_settings={"help_option_names": ["-h", "--help"], "show_default": True}
)
@click.version_option(__version__, message="phonanim %(version)s")
def commands() -> None:
    """Speech animation from phone alignments.

    \b
    phonanim animate line.TextGrid                         the shipped head, speaking: line.glb
    phonanim animate line.TextGrid -o line.csv --rig arkit    curves for Live Link Face
    """


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: 0 good, 1 some lines failed, 2 bad input or usage."""
    try:
        code = int(commands.main(arguments, prog_name="phonanim", standalone_mode=False) or 0)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except NoArgsIsHelpError as error:
        return _complain(error.format_message())
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "phonanim"
        return _complain(f"{command}: {_sentence(error.format_message())}; see {command} --help")
    except click.ClickException as error:
        return _complain(f"phonanim: {error.format_message()}")
    except PhonanimError as error:
        return _complain(f"phonanim: {error}")
    except click.Abort:
        return INTERRUPTED
    except (OSError, MemoryError, UnicodeEncodeError) as error:
        return _report_system_error(error)
    except Exception as error:
        failure = describe_failure(error)
        if failure is None:
            raise
        return _complain(f"phonanim: {failure}")


def _report_system_error(error: OSError | MemoryError | UnicodeEncodeError) -> int:
    """Report operating-system errors in one line."""
    if isinstance(error, MemoryError):
        return _complain("phonanim: there is not enough memory for this; close programs, or cut the input")
    if isinstance(error, UnicodeEncodeError):
        return _complain(f"phonanim: {error.object!r:.200} is not UTF-8; rename the file")
    _discard_output()
    if isinstance(error, BrokenPipeError):  # the reader of the output closed it
        return CLOSED_PIPE
    place = f"{error.filename}: " if error.filename else ""
    return _complain(f"phonanim: {place}{error.strerror or error}")


def main() -> NoReturn:
    """Run the command that the arguments name, and exit with its code."""
    open_standard_streams()
    # NumPy warns about non-finite values; phonanim reports them where they matter.
    warnings.simplefilter("ignore", RuntimeWarning)
    code = run()
    gc.freeze()  # the last collection finds nothing that matters, and takes 0.3 s of a process with a model
    sys.exit(code)


def open_standard_streams() -> None:
    """Open an empty stdin, stdout or stderr where the process was started without one.

    Otherwise the next opened file would get that file number, and printed text would be written into it.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDONLY if mode == "r" else os.O_WRONLY)  # the lowest free number
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def _discard_output() -> None:
    """Discard unwritten stdout, so that Python does not fail on it at exit."""
    void = os.open(os.devnull, os.O_WRONLY)
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(void, sys.stdout.fileno())
    os.close(void)


def _sentence(message: str) -> str:
    """Click's message as the first part of a longer line."""
    return " ".join(message.split()).rstrip(".")


def _complain(message: str) -> int:
    with suppress(OSError):
        click.echo(printable(add_clone_hint(message, clone_folder())), err=True)
    return BAD_INPUT


if __name__ == "__main__":
    main()
