"""What goes to a worker and what comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from phonanim.dubbing.ledger import Outcome
from phonanim.dubbing.lines import Line


@dataclass(frozen=True, slots=True)
class Job:
    """A line to make: where to, in which formats, and what the ledger knows of it."""

    line: Line
    folder: Path
    formats: tuple[str, ...]
    known: Outcome | None


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome, and whether the outputs had to be made."""

    outcome: Outcome
    made: bool


Task = Callable[[Job], Result]
