import errno
import json
import os
import subprocess
import sys
from dataclasses import asdict, replace

import pytest

from phonanim.dubbing.ledger import NAME, ledger_writer, lock_folder, read_ledger, write_ledger
from phonanim.dubbing.outcome import Outcome, encode_outcome
from phonanim.errors import OutputError

DONE = Outcome(
    "a", "row 2", {"version": "1"}, {"a.csv": "hash"}, {"frames": 3, "seconds": 0.1, "phones": 1, "flags": []}
)
FAILED = Outcome("b", "row 3", error="b.TextGrid: is empty")


def test_there_and_back(tmp_path):
    write_ledger(tmp_path, [DONE, FAILED])
    assert read_ledger(tmp_path) == {"a": DONE, "b": FAILED}
    assert [outcome.done for outcome in (DONE, FAILED)] == [True, False]


def test_no_ledger_is_an_empty_one(tmp_path):
    assert read_ledger(tmp_path) == {}


def test_the_last_outcome_of_an_id_counts(tmp_path):
    with ledger_writer(tmp_path) as record:
        record(Outcome("a", "row 2", error="no"))
        record(DONE)
    assert read_ledger(tmp_path) == {"a": DONE}


@pytest.mark.parametrize("cut", range(1, 60, 7))
def test_a_line_that_a_kill_cut_short_costs_that_line_only(tmp_path, cut):
    write_ledger(tmp_path, [DONE, FAILED])
    path = tmp_path / NAME
    path.write_bytes(path.read_bytes()[:-cut])
    assert read_ledger(tmp_path) in ({"a": DONE}, {"a": DONE, "b": FAILED})
    with ledger_writer(tmp_path) as record:
        record(FAILED)
    assert read_ledger(tmp_path) == {"a": DONE, "b": FAILED}


@pytest.mark.parametrize("line", ["[]", "3", "{}", '{"id": "x", "place": "", "colour": "red"}', "\x00\xff"])
def test_lines_that_are_no_outcome_are_left_out(tmp_path, line):
    write_ledger(tmp_path, [DONE])
    with (tmp_path / NAME).open("a") as stream:
        stream.write(line + "\n")
    assert read_ledger(tmp_path) == {"a": DONE}


def test_a_ledger_that_cannot_be_written(tmp_path):
    (tmp_path / NAME).mkdir()
    with (
        pytest.raises(OutputError, match=r"ledger.jsonl: cannot be written: Is a directory"),
        ledger_writer(tmp_path),
    ):
        pass


def test_a_full_disk(tmp_path, monkeypatch):
    def full(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("phonanim.dubbing.ledger.os.fsync", full)
    message = "ledger.jsonl: cannot be written: No space left"
    with pytest.raises(OutputError, match=message), ledger_writer(tmp_path) as record:
        record(DONE)


def test_a_planted_link_is_not_written_through(tmp_path):
    (tmp_path / "other").write_text("theirs\n")
    (tmp_path / NAME).symlink_to("other")
    message = "ledger.jsonl: cannot be written: it is a link; remove it"
    with pytest.raises(OutputError, match=message), ledger_writer(tmp_path):
        pass
    write_ledger(tmp_path, [DONE])
    assert not (tmp_path / NAME).is_symlink()
    assert (tmp_path / "other").read_text() == "theirs\n"


def test_a_ledger_of_two_names_is_written_under_one(tmp_path):
    (tmp_path / "backup").write_text(encode_outcome(DONE))
    os.link(tmp_path / "backup", tmp_path / NAME)
    with ledger_writer(tmp_path) as record:
        record(replace(DONE, id="other"))
    assert (tmp_path / "backup").read_text() == encode_outcome(DONE)
    assert set(read_ledger(tmp_path)) == {DONE.id, "other"}


def test_what_fails_elsewhere_is_not_blamed_on_the_ledger(tmp_path):
    with pytest.raises(OSError, match=r"Too many open files") as caught, ledger_writer(tmp_path):
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))
    assert not isinstance(caught.value, OutputError)
    with pytest.raises(BlockingIOError), lock_folder(tmp_path):
        raise BlockingIOError


@pytest.mark.parametrize(
    "changes",
    [
        {"id": 3},
        {"place": None},
        {"error": []},
        {"origin": []},
        {"origin": {"options": 3}},
        {"outputs": ["a.csv"]},
        {"outputs": {"a.csv": 3}},
        {"outputs": {"../a.csv": "hash"}},
        {"outputs": {"/etc/passwd": "hash"}},
        {"facts": {}},
        {"facts": {"frames": "3", "seconds": 0.1, "phones": 1, "flags": []}},
        {"facts": {"frames": 3, "seconds": 1e300, "phones": 1, "flags": []}},
        {"facts": {"frames": 3, "seconds": 0.1, "phones": 1, "flags": [3]}},
        {"facts": {"frames": 3, "seconds": 0.1, "phones": 1, "flags": [{"check": "a"}]}},
    ],
)
def test_outcomes_of_wrong_types_are_left_out(tmp_path, changes):
    write_ledger(tmp_path, [DONE])
    with (tmp_path / NAME).open("a") as stream:
        stream.write(json.dumps({**asdict(DONE), "id": "x", **changes}) + "\n")
        stream.write("[" * 100_000 + "\n")
    assert read_ledger(tmp_path) == {"a": DONE}


def test_a_ledger_that_cannot_be_read(tmp_path):
    (tmp_path / NAME).mkdir()
    with pytest.raises(OutputError, match=r"ledger.jsonl: cannot be read: .*; move it away"):
        read_ledger(tmp_path)
    (tmp_path / NAME).rmdir()
    (tmp_path / NAME).symlink_to("/dev/zero")
    with pytest.raises(OutputError, match=r"ledger.jsonl: cannot be read: it is a pipe or a device"):
        read_ledger(tmp_path)


def test_outputs_are_on_the_disk_before_the_ledger_tells_of_them(tmp_path, monkeypatch):
    (tmp_path / "a.csv").write_text("made")
    stored = []
    monkeypatch.setattr("phonanim.dubbing.ledger.PERIOD", 0.0)
    monkeypatch.setattr("phonanim.dubbing.ledger.os.fsync", lambda n: stored.append(os.fstat(n).st_ino))
    with ledger_writer(tmp_path) as record:
        record(DONE)
        record(FAILED)
    places = [tmp_path / "a.csv", tmp_path, tmp_path / NAME]
    assert stored[:3] == [place.stat().st_ino for place in places]
    assert set(stored[3:]) == {places[2].stat().st_ino}


def test_one_run_at_a_time(tmp_path):
    code = (
        "import sys; from pathlib import Path; from phonanim.dubbing.ledger import lock_folder\n"
        "with lock_folder(Path(sys.argv[1])): print('in', flush=True); sys.stdin.read()"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert other.stdout.readline() == b"in\n"
        message = "another run is writing there; wait for it or choose another"
        with pytest.raises(OutputError, match=message), lock_folder(tmp_path):
            pass
    finally:
        other.kill()
        other.communicate()
    with lock_folder(tmp_path):  # the kill released it
        pass


def test_the_file_is_one_json_object_a_line(tmp_path):
    write_ledger(tmp_path, [DONE, FAILED])
    lines = (tmp_path / NAME).read_text().splitlines()
    assert [json.loads(line)["id"] for line in lines] == ["a", "b"]
