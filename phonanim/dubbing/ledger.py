"""The ledger: what became of each line, written as it happens, so that a killed run goes on where it was."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import IO

from phonanim.core.files import atomic_path
from phonanim.dubbing import ledger_parts
from phonanim.dubbing.outcome import Outcome, decode_outcomes, encode_outcome
from phonanim.dubbing.storage import Place, Remote
from phonanim.errors import OutputError

NAME = "ledger.jsonl"

Record = Callable[[Outcome], None]


def read_ledger(folder: Place) -> dict[str, Outcome]:
    """The last outcome of each id; empty when there is no ledger. A line cut short by a kill is left out."""
    if isinstance(folder, Remote):
        return ledger_parts.read(folder, NAME)
    try:
        return decode_outcomes((folder / NAME).read_text("utf-8", errors="replace").splitlines())
    except FileNotFoundError:
        return {}


def write_ledger(folder: Place, outcomes: Iterable[Outcome]) -> None:
    """Write the ledger anew: one outcome an id, in the order given."""
    text = "".join(map(encode_outcome, outcomes))
    if isinstance(folder, Remote):
        ledger_parts.write(folder, NAME, text)
        return
    with atomic_path(folder / NAME) as partial:
        partial.write_text(text, "utf-8")


def ledger_writer(folder: Place) -> AbstractContextManager[Record]:
    """A function that adds an outcome to the ledger, so that it outlives a kill. Raises OutputError."""
    return ledger_parts.part_writer(folder) if isinstance(folder, Remote) else _appending(folder)


@contextmanager
def lock_folder(folder: Place) -> Iterator[None]:
    """Hold the folder for one run; a kill releases it. Raises OutputError when another run holds it.

    Shared storage has no such locks: there the user must keep two runs apart.
    """
    try:
        import fcntl
    except ImportError:  # on Windows, where the user must too
        yield
        return
    if isinstance(folder, Remote):
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


@contextmanager
def _appending(folder: Path) -> Iterator[Record]:
    """The same for a path: after a line end, if a kill left one out."""
    try:
        with (folder / NAME).open("a+", encoding="utf-8") as stream:
            _end_line(stream)
            yield partial(_append, stream)
    except OSError as error:
        raise OutputError(f"{folder / NAME}: cannot be written: {error.strerror or error}") from error


def _append(stream: IO[str], outcome: Outcome) -> None:
    """Add an outcome; it is with the operating system when this returns."""
    stream.write(encode_outcome(outcome))
    stream.flush()


def _end_line(stream: IO[str]) -> None:
    size = stream.seek(0, os.SEEK_END)
    if size:
        stream.seek(size - 1)
        if stream.read(1) != "\n":
            stream.write("\n")
