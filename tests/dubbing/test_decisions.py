"""Decisions on lines: who did what and when, undo, and two people who do not lose each other's work."""

import os
import sqlite3
import threading
from contextlib import closing

import pytest

from phonanim.dubbing.decisions import FILES, NAME, Change, Decisions
from phonanim.errors import ConflictError, OptionError, OutputError


class Shelf:
    """Corrections of lines, kept in memory."""

    def __init__(self):
        self.texts = {}

    def keep(self, line, text):
        before = self.texts.get(line, "")
        if text is not None:
            self.texts[line] = text
        return before


@pytest.fixture
def shelf():
    return Shelf()


@pytest.fixture
def decisions(tmp_path, shelf):
    return Decisions(tmp_path, shelf.keep)


def test_what_was_done_is_told_with_who_and_when(decisions, tmp_path, shelf):
    state = decisions.record(Change("a", 0, "Ann", "corrected", "B is P", "", "first"))
    state = decisions.record(Change("a", state.revision, "Bob", "approved", "", "approved"))
    state = decisions.record(Change("a", state.revision, "Bob", "comment", "fine"))
    assert (state.revision, state.status, state.comments) == (3, "approved", 1)
    again = Decisions(tmp_path, shelf.keep)
    assert again.states() == {"a": state}
    told = [(event.who, event.kind, event.text) for event in again.events("a")]
    assert told == [("Bob", "comment", "fine"), ("Bob", "approved", ""), ("Ann", "corrected", "B is P")]
    assert all(event.at.endswith("Z") and len(event.at) == 20 for event in again.events("a"))
    assert again.news(1) == (3, {"a": state})
    assert again.news(3) == (3, {})


def test_the_later_of_two_is_told_who_was_faster(decisions, shelf):
    decisions.record(Change("a", 0, "Ann", "corrected", "B is P", "", "of Ann"))
    with pytest.raises(ConflictError, match=r"a: Ann was faster .* \(corrected: B is P; revision 1\)"):
        decisions.record(Change("a", 0, "Bob", "corrected", "B is D", "", "of Bob"))
    assert shelf.texts == {"a": "of Ann"}
    with pytest.raises(ConflictError, match="Ann was faster"):
        decisions.undo("a", 0, "Bob")
    assert [event.who for event in decisions.events("a")] == ["Ann"]


def test_of_many_at_once_one_is_kept(tmp_path, shelf):
    faults = []

    def change(who):
        try:
            Decisions(tmp_path, shelf.keep).record(Change("a", 0, who, "corrected", "", "", who))
        except ConflictError as error:
            faults.append(error)

    threads = [threading.Thread(target=change, args=(f"P{number}",)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (event,) = Decisions(tmp_path, shelf.keep).events("a")
    assert len(faults) == 7
    assert shelf.texts == {"a": event.who}


def test_undo_goes_back_one_after_the_other_and_keeps_comments(decisions, shelf):
    for revision, change in enumerate((("corrected", "", "one"), ("corrected", "", "two"))):
        decisions.record(Change("a", revision, "Ann", change[0], change[2], change[1], change[2]))
    decisions.record(Change("a", 2, "Ann", "comment", "hm"))
    decisions.record(Change("a", 3, "Ann", "rejected", "", "rejected"))
    assert decisions.undo("a", 4, "Bob").status == ""
    assert shelf.texts == {"a": "two"}
    decisions.undo("a", 5, "Bob")
    assert shelf.texts == {"a": "one"}
    state = decisions.undo("a", 6, "Bob")
    assert shelf.texts == {"a": ""}
    assert (state.revision, state.comments) == (7, 1)
    with pytest.raises(OptionError, match="a: there is nothing to undo"):
        decisions.undo("a", 7, "Bob")
    assert [event.undone for event in decisions.events("a") if event.kind == "corrected"] == [True, True]


def test_nothing_is_kept_when_the_corrections_cannot_be_written(tmp_path):
    def full(line, text):
        raise OutputError("no room")

    decisions = Decisions(tmp_path, full)
    with pytest.raises(OutputError, match="no room"):
        decisions.record(Change("a", 0, "Ann", "corrected", "", "", "text"))
    assert decisions.states() == {}
    assert decisions.events("a") == []


def test_unknown_statuses_links_and_damaged_files_are_refused(decisions, tmp_path, shelf):
    with pytest.raises(OptionError, match="the status 'fine' is not one of approved and rejected"):
        decisions.record(Change("a", 0, "Ann", "fine", "", "fine"))
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / NAME).symlink_to(tmp_path / NAME)
    with pytest.raises(OutputError, match=f"{NAME}: cannot be used: it is a link or a pipe; move it away"):
        Decisions(tmp_path / "other", shelf.keep)
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / NAME).write_text("not a database, but long enough to be read as one" * 10)
    with pytest.raises(OutputError, match=r"review.sqlite: cannot be used: .*; move it away"):
        Decisions(tmp_path / "damaged", shelf.keep)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("plant", ["link", "symlink_to", "pipe"])
def test_sqlite_writes_into_no_file_of_another(tmp_path, shelf, name, plant):
    (tmp_path / "theirs").write_text("theirs")
    (tmp_path / "out").mkdir()
    path = tmp_path / "out" / name
    if plant == "pipe":
        os.mkfifo(path)
    else:
        {"link": os.link, "symlink_to": os.symlink}[plant](tmp_path / "theirs", path)
    with pytest.raises(OutputError, match=f"{name}: cannot be used: it is a link or a pipe; move it away"):
        Decisions(tmp_path / "out", shelf.keep)
    assert (tmp_path / "theirs").read_text() == "theirs"


ENDLESS = (
    "CREATE VIEW lines AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) "
    "SELECT x AS id, 1 AS revision, '' AS status, 0 AS comments FROM n"
)


@pytest.mark.parametrize("made", [ENDLESS, "CREATE TABLE lines (id)", "CREATE TABLE other (id)"])
def test_tables_of_others_are_not_read(tmp_path, shelf, made):
    with closing(sqlite3.connect(tmp_path / NAME)) as database:
        database.execute(made)
    with pytest.raises(
        OutputError, match="cannot be used: its tables are not those of a review; move it away"
    ):
        Decisions(tmp_path, shelf.keep)


@pytest.mark.parametrize("column", ["revision", "status", "comments"])
def test_states_of_other_types_are_refused(decisions, tmp_path, column):
    decisions.record(Change("a", 0, "Ann", "approved", "", "approved"))
    with closing(sqlite3.connect(tmp_path / NAME)) as database:
        database.execute(f"UPDATE lines SET {column} = x'ff'")
        database.commit()
    for read in (decisions.states, lambda: decisions.state("a"), lambda: decisions.news(0)):
        with pytest.raises(OutputError, match=r"review\.sqlite: cannot be used: .* is bytes; it is a"):
            read()


@pytest.mark.parametrize("column", ["revision", "at", "who", "kind", "text"])
def test_events_of_other_types_are_refused(decisions, tmp_path, column):
    decisions.record(Change("a", 0, "Ann", "approved", "", "approved"))
    with closing(sqlite3.connect(tmp_path / NAME)) as database:
        database.execute(f"UPDATE events SET {column} = x'ff'")
        database.commit()
    with pytest.raises(OutputError, match=r"review\.sqlite: cannot be used: an event is bytes; it is a"):
        decisions.events("a")
