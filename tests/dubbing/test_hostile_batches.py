"""Sources and folders that somebody prepared: nothing is lost, overwritten or passed over without a word."""

import json
import os
from pathlib import Path, PurePosixPath

import pytest

from phonanim.dubbing import make as make_module
from phonanim.dubbing.job import Job
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.make import make_line
from phonanim.dubbing.processes import run_jobs
from phonanim.dubbing.reserve import reserve_outputs
from phonanim.dubbing.row import Common
from phonanim.dubbing.run import output_folders, remove_unfinished
from phonanim.errors import OutputError
from phonanim.options import DEFAULTS

GRID = "x"  # the content is not read here
PARTIAL = ".ffffff0123ab.partial.csv"


def table(folder, *rows):
    (folder / "a.TextGrid").write_text(GRID)
    (folder / "t.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    return read_lines(str(folder / "t.jsonl"), Common())


def reserved(folder, ids, formats):
    lines = table(folder, *({"alignment": "a.TextGrid", "id": id} for id in ids))
    found = reserve_outputs(lines, folder / "out", formats)
    return [line.id for line in found.lines], [fault.message for fault in found.faults]


@pytest.mark.parametrize(
    ("ids", "formats", "kept", "message"),
    [
        (["b", "report"], ["json"], ["b"], r"'report.json' is already used by the run itself; give the line"),
        (["Report"], ["json", "csv"], [], r"is already used by the run itself"),
        (["summary"], ["txt"], [], r"is already used by the run itself"),
        (["ledger"], ["jsonl"], [], r"is already used by the run itself"),
        (["a", "a.track"], ["track.json", "json"], ["a"], r"'a.track.json' is already used by t.jsonl row 1"),
        (["a.csv/b", "a"], ["csv"], ["a.csv/b"], r"'a.csv' is already used by t.jsonl row 1"),
        (["a", "a.csv/b"], ["csv"], ["a"], r"'a.csv/b.csv' is already used by t.jsonl row 1"),
        (["report"], ["csv"], ["report"], None),
    ],
)
def test_outputs_that_collide(tmp_path, ids, formats, kept, message):
    found, faults = reserved(tmp_path, ids, formats)
    assert found == kept
    assert len(faults) == len(ids) - len(kept)
    assert message is None or message in faults[0]


def test_an_output_that_would_overwrite_an_input(tmp_path):
    (tmp_path / "b.json").write_text(GRID)
    lines = table(tmp_path, {"alignment": "b.json", "id": "b"})
    assert not reserve_outputs(lines, tmp_path / "out", ["json"]).faults
    (fault,) = reserve_outputs(lines, tmp_path, ["json"]).faults
    assert fault.message.startswith("the output 'b.json' would overwrite an input; give the line another id")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the superuser reads every folder")
def test_a_folder_that_cannot_be_read_is_told(tmp_path):
    (tmp_path / "a.TextGrid").write_text(GRID)
    (tmp_path / "shut").mkdir(mode=0o000)
    for source in (tmp_path, tmp_path / "**/*.TextGrid"):
        lines = read_lines(str(source), Common())
        assert [line.id for line in lines.lines] == ["a"]
        assert "the folder cannot be read: Permission denied" in lines.faults[0].message


def test_a_folder_whose_listing_fails_is_told(tmp_path, monkeypatch):
    (tmp_path / "a.TextGrid").write_text(GRID)
    (tmp_path / "shut").mkdir()
    listed = os.scandir

    def refuse(folder):
        if Path(folder).name == "shut":
            raise PermissionError(13, "Permission denied")
        return listed(folder)

    monkeypatch.setattr("phonanim.dubbing.walk.os.scandir", refuse)
    for source in (tmp_path, tmp_path / "**/*.TextGrid"):
        lines = read_lines(str(source), Common())
        assert [line.id for line in lines.lines] == ["a"]
        assert [fault.message for fault in lines.faults] == [
            "the folder cannot be read: Permission denied; change its permissions, or leave it out"
        ]


def test_links_to_folders_are_not_followed_and_told(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/a.TextGrid").write_text(GRID)
    (tmp_path / "sub/loop").symlink_to("..")
    (tmp_path / "other").symlink_to("sub")
    for source in (tmp_path, tmp_path / "**/*.TextGrid", tmp_path / "**"):
        lines = read_lines(str(source), Common())
        assert [line.id for line in lines.lines] == ["sub/a"]
        assert any("loop: is a link to a folder, and is not followed" in note for note in lines.notes)
    lines = read_lines(str(tmp_path / "*/*.TextGrid"), Common())
    assert [line.id for line in lines.lines] == ["other/a", "sub/a"]


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ({"alignment": "x" * 300}, "File name too long"),
        ({"alignment": "a\0b"}, "does not exist"),
        ({"id": "\ud800"}, "it holds half a character, \\ud800; write one object per line"),
        ({"id": "a", "fps": "nan"}, "'nan' is not a frame rate"),
        ({"id": "a", "fps": "inf"}, "'inf' is not a frame rate"),
        ({"id": "a", "fps": "1e300"}, "the rate must lie from 1 to 1000"),
        ({"id": "a", "fps": "-1"}, "the rate must lie from 1 to 1000"),
    ],
)
def test_a_bad_row_does_not_stop_the_run(tmp_path, cells, message):
    lines = table(tmp_path, {"alignment": "a.TextGrid", **cells}, {"alignment": "a.TextGrid", "id": "good"})
    assert [line.id for line in lines.lines] == ["good"]
    assert message in lines.faults[0].message
    for text in (lines.faults[0].id, lines.faults[0].message, lines.faults[0].place):
        text.encode()


@pytest.mark.skipif(os.name != "posix", reason="needs names that are bytes")
def test_a_name_that_is_not_utf8_is_told(tmp_path):
    (tmp_path / "a.TextGrid").write_text(GRID)
    try:
        Path(os.fsdecode(bytes(tmp_path) + b"/b\xff.TextGrid")).write_text(GRID)
    except OSError:
        pytest.skip("the file system takes UTF-8 alone")
    lines = read_lines(str(tmp_path), Common())
    assert [line.id for line in lines.lines] == ["a"]
    assert lines.faults[0].id == "b\\udcff"


def test_the_sweep_takes_our_own_files_in_our_own_folders(tmp_path):
    kept = [".notes.partial.txt", "mine/.ffffff0123ab.partial.csv", "run2/.ffffff0123ab.partial.csv"]
    swept = [PARTIAL, f"sub/{PARTIAL}", f"old/{PARTIAL}"]
    for name in (*kept, *swept, "run2/ledger.jsonl", "ledger.jsonl"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    (tmp_path / "link").symlink_to("mine")
    lines = [Line(n, "", tmp_path, None, DEFAULTS, PurePosixPath(n)) for n in ("sub/a", "run2/a", "link/a")]
    from phonanim.dubbing.lines import Lines
    from phonanim.dubbing.outcome import Outcome

    known = [Outcome("b", "", outputs={"old/b.csv": ""})]
    remove_unfinished(tmp_path, output_folders(Lines(tuple(lines), ()), known))
    assert [name for name in (*kept, *swept) if (tmp_path / name).exists()] == kept


@pytest.fixture
def job(root, tmp_path):
    line = Line("x", "row 2", root / "examples/line.TextGrid", None, DEFAULTS, PurePosixPath("sub/x"))
    return Job(line, tmp_path / "out", ("csv",), None)


def test_a_link_does_not_lead_out_of_the_output_folder(job, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out/sub").symlink_to(tmp_path / "elsewhere")
    assert "a link points outside the output folder; remove the link" in make_line(job).outcome.error
    assert not list((tmp_path / "elsewhere").iterdir())


def test_a_worker_out_of_memory_says_so(job, monkeypatch):
    def full(*given):
        raise MemoryError

    monkeypatch.setattr(make_module, "animate_corrected", full)
    assert make_line(job).outcome.error == (
        f"{job.line.alignment}: there is not enough memory for it; use fewer --workers, or cut the line"
    )


def test_a_worker_that_cannot_start_is_told(job, monkeypatch):
    def refuse(*given, **named):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr("multiprocessing.context.SpawnContext.Pipe", refuse)
    with pytest.raises(OutputError, match=r"a worker cannot be started: Too many open files; use fewer"):
        list(run_jobs([job], make_line, 2))
