"""The ledger: what became of each line, written as it happens, so that a killed run goes on where it was."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any

from phonanim.errors import OutputError
from phonanim.files import atomic_path

NAME = "ledger.jsonl"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one line.

    `origin` is everything that the outputs depend on; `outputs` are paths relative to the output folder
    with their content hashes; `facts` are for the report; `error` says why there are no outputs.
    """

    id: str
    place: str
    origin: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""

    @property
    def done(self) -> bool:
        """Whether the outputs are there."""
        return not self.error


def read_ledger(folder: Path) -> dict[str, Outcome]:
    """The last outcome of each id; empty when there is no ledger. A line cut short by a kill is left out."""
    try:
        lines = (folder / NAME).read_text("utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return {}
    found = filter(None, map(_outcome, lines))
    return {outcome.id: outcome for outcome in found}


def write_ledger(folder: Path, outcomes: Iterable[Outcome]) -> None:
    """Write the ledger anew: one outcome an id, in the order given."""
    with atomic_path(folder / NAME) as partial:
        partial.write_text("".join(map(_line, outcomes)), "utf-8")


@contextmanager
def appending(folder: Path) -> Iterator[IO[str]]:
    """The ledger open for appending, after a line end if a kill left one out. Raises OutputError."""
    try:
        with (folder / NAME).open("a+", encoding="utf-8") as stream:
            _end_line(stream)
            yield stream
    except OSError as error:
        raise OutputError(f"{folder / NAME}: cannot be written: {error.strerror or error}") from error


def append(stream: IO[str], outcome: Outcome) -> None:
    """Add an outcome; it is with the operating system when this returns."""
    stream.write(_line(outcome))
    stream.flush()


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the folder for one run; a kill releases it. Raises OutputError when another run holds it."""
    try:
        import fcntl
    except ImportError:  # on Windows, where the user must keep two runs apart
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError as error:
        raise OutputError(f"{folder}: another run is writing there; wait for it or choose another") from error
    finally:
        os.close(descriptor)


def _end_line(stream: IO[str]) -> None:
    size = stream.seek(0, os.SEEK_END)
    if size:
        stream.seek(size - 1)
        if stream.read(1) != "\n":
            stream.write("\n")


def _line(outcome: Outcome) -> str:
    return json.dumps(asdict(outcome), ensure_ascii=False) + "\n"


def _outcome(line: str) -> Outcome | None:
    try:
        return Outcome(**json.loads(line))
    except (ValueError, TypeError):
        return None
