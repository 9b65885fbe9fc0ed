"""What goes to a worker and what comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from phonanim.dubbing.line import Line
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.storage import Place


@dataclass(frozen=True, slots=True)
class Job:
    """A line to make: where to, in which formats, and what the ledger knows of it.

    `run` differs between runs, so that a worker of many can tell them apart.
    """

    line: Line
    folder: Place
    formats: tuple[str, ...]
    known: Outcome | None
    run: str = ""


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome, and whether the outputs had to be made."""

    outcome: Outcome
    made: bool


Task = Callable[[Job], Result]
