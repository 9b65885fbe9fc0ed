"""Shared by every command: printing results and messages, and showing progress."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from typing import Any

import click

from phonanim.core.text import printable

PATIENCE = 2.0  # seconds of silent work before a progress bar appears


@dataclass(frozen=True, slots=True)
class Console:
    """Results go to stdout, everything else to stderr."""

    json: bool = False
    quiet: bool = False

    def print(self, text: str) -> None:
        """Print one line for people, on stderr."""
        if not self.quiet and not self.json:
            click.echo(printable(text), err=True)

    def print_result(self, value: object, text: str = "") -> None:
        """Print the result on stdout: as JSON with --json, as text otherwise."""
        if self.json:
            click.echo(printable(json.dumps(value, indent=2, ensure_ascii=False, default=str)))
        elif text:
            click.echo(printable(text))

    def print_event(self, name: str, **facts: object) -> None:
        """Print one line of JSON on stdout, if --json was given."""
        if self.json:
            click.echo(printable(json.dumps({"event": name, **facts}, ensure_ascii=False, default=str)))

    @contextmanager
    def progress(self, label: str) -> Iterator[Callable[..., None]]:
        """Return a function that takes the part done, 0 to 1; slow work draws a bar on stderr.

        Its second argument names the current step; when the step changes, the bar starts again.
        """
        bar = _Bar(label, shown=not (self.quiet or self.json) and sys.stderr.isatty())
        try:
            yield bar.update
        finally:
            bar.close()


class _Bar:
    """A rich progress bar; rich is imported only for slow work."""

    def __init__(self, label: str, shown: bool) -> None:
        self.label = label
        self.shown = shown
        self.started = time.monotonic()
        self.progress: Any = None

    def update(self, done: float, label: str | None = None) -> None:
        if label not in (None, self.label):
            self.label = label or ""
            if self.progress is not None:
                self.progress.reset(self.task, description=self.label)
        if self.progress is None and self.shown and time.monotonic() - self.started > PATIENCE:
            self._open()
        if self.progress is not None:
            self.progress.update(self.task, completed=done)

    def _open(self) -> None:
        from rich.console import Console as RichConsole
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
        self.progress = Progress(*columns, console=RichConsole(stderr=True), transient=True)
        self.task = self.progress.add_task(self.label, total=1.0)
        self.progress.start()

    def close(self) -> None:
        if self.progress is not None:
            self.progress.stop()


def console_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options --json and --quiet, handed to the command as `console`."""

    @wraps(function)
    def wrapped(*args: Any, as_json: bool, quiet: bool, **kwargs: Any) -> Any:
        return function(*args, console=Console(as_json, quiet), **kwargs)

    add_quiet = click.option("--quiet", "-q", is_flag=True, help="Print errors only.")
    add_json = click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
    return add_json(add_quiet(wrapped))
