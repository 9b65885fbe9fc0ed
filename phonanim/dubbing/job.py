"""The messages to and from a worker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from phonanim.dubbing.line import Line
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.storage import Place


@dataclass(frozen=True, slots=True)
class Job:
    """A line to make: its destination, its formats, and its entry in the ledger.

    `run` is different for each run, so that a worker of several runs can distinguish them.
    """

    line: Line
    folder: Place
    formats: tuple[str, ...]
    known: Outcome | None
    run: str = ""


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome, and whether the outputs were made in this run."""

    outcome: Outcome
    made: bool


Task = Callable[[Job], Result]
