"""Decisions of a review: who approved, rejected, corrected or commented which line, and when, in SQLite.

Each line has a revision. Who changes a line says which revision they saw; when it is an older one, nothing is
changed, so two people on one run do not lose each other's work.
"""

from __future__ import annotations

import sqlite3
import stat
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import datetime, timezone
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args

from phonanim.core.decode import DecodeError, decode_text, decode_whole
from phonanim.errors import ConflictError, OptionError, OutputError

NAME = "review.sqlite"
FILES = tuple(f"{NAME}{end}" for end in ("", "-wal", "-shm", "-journal"))
MOST = 2**53  # of a count
PATIENCE = 5.0  # seconds to wait for another process that writes
OLD = 1000  # events of a line that are told at most

Status = Literal["", "approved", "rejected"]
STATUSES: tuple[str, ...] = get_args(Status)

SCHEMA = """
CREATE TABLE IF NOT EXISTS lines (
    id TEXT PRIMARY KEY, revision INTEGER NOT NULL, status TEXT NOT NULL, comments INTEGER NOT NULL
);
CREATE TABLE IF NOT EXISTS events (
    number INTEGER PRIMARY KEY AUTOINCREMENT, line TEXT NOT NULL, revision INTEGER NOT NULL, at TEXT NOT NULL,
    who TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL,
    status_before TEXT NOT NULL, corrections_before TEXT, undone INTEGER NOT NULL DEFAULT 0
);
CREATE INDEX IF NOT EXISTS events_of_line ON events (line, number);
"""


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that a person did: kind is corrected, approved, rejected, reopened, comment or undo."""

    number: int
    line: str
    revision: int
    at: str
    who: str
    kind: str
    text: str
    undone: bool = False


@dataclass(frozen=True, slots=True)
class State:
    """Where a line stands: the number of its changes, its status, and the number of comments."""

    revision: int = 0
    status: str = ""
    comments: int = 0


@dataclass(frozen=True, slots=True)
class Change:
    """What a person does to a line whose revision they saw.

    `status` is the new one, None to keep it. `corrections` is the new content of the file of corrections, ""
    to remove it, None to keep it.
    """

    line: str
    revision: int
    who: str
    kind: str
    text: str = ""
    status: str | None = None
    corrections: str | None = None


Keep = Callable[[str, str | None], str]
"""Write the corrections of a line ("" removes them, None keeps them), and return the content before."""


class Decisions:
    """The decisions of one run, in its output folder. Calls open the file anew, so threads may share it."""

    def __init__(self, folder: Path, keep: Keep) -> None:
        self.path = folder / NAME
        self.keep = keep
        for name in FILES:
            _check_plain(folder / name)
        with self._open() as database:
            if _tables(database) == _own_tables():
                return
            with _transaction(database):  # of those that begin at once, one makes the tables
                found = _tables(database)
                if found and found != _own_tables():
                    raise DecodeError("its tables are not those of a review")
                for statement in () if found else SCHEMA.split(";"):
                    database.execute(statement)

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        """A connection; errors of the file are one line."""
        try:
            with closing(sqlite3.connect(self.path, timeout=PATIENCE, isolation_level=None)) as database:
                yield database
        except (sqlite3.Error, DecodeError) as error:
            raise OutputError(f"{self.path}: cannot be used: {error}; move it away to begin anew") from error

    def states(self) -> dict[str, State]:
        """Where each line stands that someone did something to."""
        with self._open() as database:
            rows = database.execute("SELECT id, revision, status, comments FROM lines")
            return {decode_text(id, "a line"): _decode_state(rest) for id, *rest in rows}

    def state(self, line: str) -> State:
        """Where a line stands."""
        with self._open() as database:
            return _state(database, line)

    def events(self, line: str) -> list[Event]:
        """What was done to a line, the newest first."""
        wanted = "SELECT * FROM events WHERE line = ? ORDER BY number DESC LIMIT ?"
        with self._open() as database:
            return [_event(row) for row in database.execute(wanted, (line, OLD))]

    def news(self, after: int) -> tuple[int, dict[str, State]]:
        """The number of the last event, and where the lines stand that have events after one."""
        with self._open() as database:
            last = database.execute("SELECT max(number) FROM events").fetchone()[0] or 0
            lines = database.execute("SELECT DISTINCT line FROM events WHERE number > ?", (after,))
            states = {decode_text(line, "a line"): _state(database, line) for (line,) in lines.fetchall()}
            return int(last), states

    def record(self, change: Change) -> State:
        """Do a change. Raises ConflictError when the line has changed since, and OptionError for a status."""
        if change.status is not None and change.status not in STATUSES:
            raise OptionError(f"the status {change.status!r:.40} is not one of approved and rejected")
        with self._open() as database, _transaction(database):
            known = _state(database, change.line)
            if known.revision != change.revision:
                raise ConflictError(_conflict(database, change.line, known))
            before = self.keep(change.line, change.corrections)
            comments = known.comments + (change.kind == "comment")
            status = known.status if change.status is None else change.status
            return _store(database, change, State(known.revision + 1, status, comments), known.status, before)

    def undo(self, line: str, revision: int, who: str) -> State:
        """Take back the last correction or decision of a line. Raises ConflictError, OptionError."""
        wanted = (
            "SELECT number, kind, text, status_before, corrections_before FROM events WHERE line = ? "
            "AND undone = 0 AND kind NOT IN ('comment', 'undo') ORDER BY number DESC LIMIT 1"
        )
        with self._open() as database, _transaction(database):
            known = _state(database, line)
            if known.revision != revision:
                raise ConflictError(_conflict(database, line, known))
            last = database.execute(wanted, (line,)).fetchone()
            if last is None:
                raise OptionError(f"{line}: there is nothing to undo")
            number, *texts = last
            kind, text, status = (decode_text(part, "an event") for part in texts[:3])
            corrections = None if texts[3] is None else decode_text(texts[3], "the corrections of an event")
            before = self.keep(line, corrections if kind == "corrected" else None)
            database.execute("UPDATE events SET undone = 1 WHERE number = ?", (number,))
            change = Change(line, revision, who, "undo", f"{kind}: {text}" if text else kind)
            after = State(revision + 1, status, known.comments)
            return _store(database, change, after, known.status, before)


@contextmanager
def _transaction(database: sqlite3.Connection) -> Iterator[None]:
    """All or nothing; others that write wait."""
    database.execute("BEGIN IMMEDIATE")
    try:
        yield
    except BaseException:
        database.execute("ROLLBACK")
        raise
    database.execute("COMMIT")


def _state(database: sqlite3.Connection, line: str) -> State:
    row = database.execute("SELECT revision, status, comments FROM lines WHERE id = ?", (line,)).fetchone()
    return _decode_state(row) if row else State()


def _decode_state(row: Sequence[Any]) -> State:
    """A row of lines, whose columns take values of any type. Raises DecodeError."""
    revision, status, comments = row
    counts = (decode_whole(count, "a count", 0, MOST) for count in (revision, comments))
    return State(next(counts), decode_text(status, "the status"), next(counts))


def _store(database: sqlite3.Connection, change: Change, after: State, status: str, before: str) -> State:
    """Write the state of a line and the event; `status` and the corrections `before` are those to undo to."""
    database.execute(
        "INSERT OR REPLACE INTO lines VALUES (?, ?, ?, ?)",
        (change.line, after.revision, after.status, after.comments),
    )
    now = datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    database.execute(
        "INSERT INTO events (line, revision, at, who, kind, text, status_before, corrections_before) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
        (change.line, after.revision, now, change.who, change.kind, change.text, status, before),
    )
    return after


def _conflict(database: sqlite3.Connection, line: str, known: State) -> str:
    wanted = "SELECT who, at, kind, text FROM events WHERE line = ? ORDER BY number DESC LIMIT 1"
    who, at, kind, text = database.execute(wanted, (line,)).fetchone() or (
        "someone",
        "meanwhile",
        "changed",
        "",
    )
    what = f"{kind}: {text}" if text else kind
    return (
        f"{line}: {who} was faster at {at} ({what}; revision {known.revision}); your change was not kept, "
        "look at the line again"
    )


def _event(row: tuple[Any, ...]) -> Event:
    """A row of events. Raises DecodeError."""
    number, line, revision, *texts, _, _, undone = row
    at, who, kind, text = (decode_text(part, "an event") for part in texts)
    counts = (decode_whole(count, "an event", 0, MOST) for count in (number, revision))
    return Event(next(counts), decode_text(line, "an event"), next(counts), at, who, kind, text, bool(undone))


def _check_plain(path: Path) -> None:
    """Raise OutputError for a link or a pipe: SQLite writes into its files as they are."""
    try:
        found = path.lstat()
    except FileNotFoundError:
        return
    if not stat.S_ISREG(found.st_mode) or found.st_nlink > 1:
        raise OutputError(f"{path}: cannot be used: it is a link or a pipe; move it away")


def _tables(database: sqlite3.Connection) -> set[tuple[str, str]]:
    """The tables, indices and whatever else a file defines, with the text that defines each."""
    return set(database.execute("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL"))


@cache
def _own_tables() -> set[tuple[str, str]]:
    with closing(sqlite3.connect(":memory:")) as database:
        database.executescript(SCHEMA)
        return _tables(database)
