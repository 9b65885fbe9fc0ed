"""The ledger: the outcome of each line, written at once, so that an interrupted run can continue."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import replace
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import IO

from phonanim.core.files import atomic_path, open_plain
from phonanim.dubbing import ledger_parts
from phonanim.dubbing.outcome import Outcome, decode_outcomes, encode_outcome
from phonanim.dubbing.storage import Place, Remote
from phonanim.errors import OutputError

NAME = "ledger.jsonl"
PERIOD = 5.0  # seconds; after a power loss, lines since the last checkpoint may be made again

Record = Callable[[Outcome], None]


def read_ledger(folder: Place) -> dict[str, Outcome]:
    """The last outcome of each id; empty without a ledger. An incomplete line of a killed run is skipped."""
    if isinstance(folder, Remote):
        return ledger_parts.read(folder, NAME)
    path = folder / NAME
    try:
        with open_plain(path) as data, TextIOWrapper(data, "utf-8", errors="replace") as stream:
            return decode_outcomes(stream)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise OutputError(
            f"{path}: cannot be read: {reason}; move it away, and all lines are made again"
        ) from error


def write_ledger(folder: Place, outcomes: Iterable[Outcome]) -> None:
    """Rewrite the ledger: one outcome per id, in the given order."""
    text = "".join(map(encode_outcome, outcomes))
    if isinstance(folder, Remote):
        ledger_parts.write(folder, NAME, text)
        return
    with atomic_path(folder / NAME) as unfinished:
        unfinished.write_text(text, "utf-8")


def settle_ledger(folder: Place, known: dict[str, Outcome], found: dict[str, Outcome]) -> None:
    """Rewrite the ledger that was read as `known` with the outcomes of a run, by id, if that differs."""
    now = known | found
    same = all(known.get(id) is outcome for id, outcome in found.items())
    if same and list(known) == sorted(known) and _count_lines(folder) == len(known):
        return
    write_ledger(folder, [now[id] for id in sorted(now)])


def _count_lines(folder: Place) -> int:
    """The number of lines in a ledger on this machine, 0 without one."""
    if isinstance(folder, Remote) or not (folder / NAME).is_file():
        return 0
    with (folder / NAME).open("rb") as stream:
        return sum(block.count(b"\n") for block in iter(partial(stream.read, 1 << 20), b""))


def ledger_writer(folder: Place) -> AbstractContextManager[Record]:
    """A function that adds an outcome to the ledger, safe against a kill. Raises OutputError."""
    return ledger_parts.part_writer(folder) if isinstance(folder, Remote) else _appending(folder)


@contextmanager
def lock_folder(folder: Place) -> Iterator[None]:
    """Lock the folder for one run; a kill releases the lock. Raises OutputError when another run has it.

    Shared storage has no such locks: the user must not start two runs there.
    """
    try:
        import fcntl
    except ImportError:  # on Windows, the user must not start two runs either
        yield
        return
    if isinstance(folder, Remote):
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise OutputError(
                f"{folder}: another run is writing there; wait for it or choose another"
            ) from error
        yield
    finally:
        os.close(descriptor)


@contextmanager
def _appending(folder: Path) -> Iterator[Record]:
    """The same for a path; first adds a missing line end. Everything is synced to disk every few seconds.

    An outcome gets its stamps once its outputs are on the disk: after a power loss a file may have the right
    size and time, but not its content.
    """
    path = folder / NAME
    with _ledger_errors(path):
        stream = os.fdopen(_open_own(path), "a+", encoding="utf-8")
    waiting: list[Outcome] = []
    last = time.monotonic()

    def record(outcome: Outcome) -> None:
        nonlocal last
        with _ledger_errors(path):
            stream.write(encode_outcome(replace(outcome, stamps={})))
            stream.flush()  # now the operating system has it, so a kill does not lose it
        waiting.append(outcome)
        if time.monotonic() - last >= PERIOD:
            with _ledger_errors(path):
                _store(stream, waiting, folder)
            last = time.monotonic()

    try:
        with _ledger_errors(path):
            _end_line(stream)
        yield record
        with _ledger_errors(path):
            _store(stream, waiting, folder)
    finally:
        with suppress(OSError):
            stream.close()


def _open_own(path: Path) -> int:
    """A descriptor of the ledger. Links are not followed, and a file of several names is copied first."""
    flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
    descriptor = os.open(path, flags, 0o666)
    if os.fstat(descriptor).st_nlink > 1:  # a copy of the folder by hard links, whose ledger is its own
        os.close(descriptor)
        with atomic_path(path) as partial:
            partial.write_bytes(path.read_bytes())
        descriptor = os.open(path, flags, 0o666)
    return descriptor


@contextmanager
def _ledger_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        link = "it is a link; remove it" if error.errno == errno.ELOOP else None
        raise OutputError(f"{path}: cannot be written: {link or error.strerror or error}") from error


def _store(stream: IO[str], waiting: list[Outcome], folder: Path) -> None:
    """Sync outputs to disk, then the ledger with their outcomes, so that a power loss keeps both."""
    outputs = [folder / name for outcome in waiting for name in outcome.outputs]
    for path in (*outputs, *{path.parent for path in outputs}):
        with suppress(FileNotFoundError):
            descriptor = os.open(path, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
    stream.writelines(encode_outcome(outcome) for outcome in waiting if outcome.stamps)
    stream.flush()
    waiting.clear()
    os.fsync(stream.fileno())


def _end_line(stream: IO[str]) -> None:
    size = stream.seek(0, os.SEEK_END)
    if size:
        stream.seek(size - 1)
        if stream.read(1) != "\n":
            stream.write("\n")
