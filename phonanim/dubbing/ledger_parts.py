"""The ledger on shared storage, where files cannot grow: parts, each a whole object, until the run ends.

A part has the outcomes of a few seconds. When the run ends, the whole ledger is written and the parts are
removed, the oldest first. So the parts that a killed run leaves are the newest, and never outdated.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import PurePosixPath

from phonanim.dubbing.outcome import Outcome, decode_outcomes, encode_outcome
from phonanim.dubbing.storage import Remote, forget_listings

FOLDER = "ledger.parts"
PERIOD = 5.0  # seconds; after a kill, lines that ended after the last part are made again


def read(folder: Remote, name: str) -> dict[str, Outcome]:
    """The ledger of that name, including the parts of a killed run."""
    forget_listings()
    whole = folder / name
    texts = [part.read_bytes() for part in ([whole] if whole.is_file() else []) + _parts(folder)]
    return decode_outcomes(line for text in texts for line in text.decode("utf-8", "replace").splitlines())


def write(folder: Remote, name: str, text: str) -> None:
    """Write the whole ledger, and remove its parts."""
    (folder / name).write_bytes(text.encode("utf-8"))
    for part in _parts(folder):
        part.unlink()


@contextmanager
def part_writer(folder: Remote) -> Iterator[Callable[[Outcome], None]]:
    """A function that takes outcomes and writes them as a part every few seconds and at the end."""
    waiting: list[Outcome] = []
    last = time.monotonic()
    _write(folder, waiting)  # fails before the first line is made if the storage is not writable

    def record(outcome: Outcome) -> None:
        nonlocal last
        waiting.append(outcome)
        if time.monotonic() - last >= PERIOD:
            _write(folder, waiting)
            last = time.monotonic()

    try:
        yield record
    finally:
        if waiting:
            _write(folder, waiting)


def _write(folder: Remote, waiting: list[Outcome]) -> None:
    """Write the waiting outcomes as a part. Its name sorts by time and is unique among runs."""
    name = PurePosixPath(FOLDER, f"{time.time_ns():020}-{secrets.token_hex(4)}.jsonl")
    (folder / name).write_bytes("".join(map(encode_outcome, waiting)).encode("utf-8"))
    waiting.clear()


def _parts(folder: Remote) -> list[Remote]:
    return (folder / FOLDER).files()
