"""What is unchanged by size and time is not read again, and what that trusts."""

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import PurePosixPath

import pytest

from phonanim.dubbing import stamps
from phonanim.dubbing.audit import audit
from phonanim.dubbing.ledger import read_ledger
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Lines
from phonanim.dubbing.make import make_line
from phonanim.dubbing.outcome import decode_outcomes, encode_outcome
from phonanim.dubbing.provenance import origin_of
from phonanim.dubbing.run import plan_run, run
from phonanim.options import DEFAULTS, Closure, Emotion, Options, Overlay
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

FORMATS = ("csv",)


def write_line(path, phones, age=60.0):
    intervals = [Interval(phone, 0.5 + n / 10, 0.6 + n / 10) for n, phone in enumerate(phones)]
    write_textgrid(path, {"phones": intervals}, 1.5)
    then = time.time() - age
    os.utime(path, (then, then))


@pytest.fixture
def lines(tmp_path):
    made = []
    for id in ("a", "b", "c"):
        path = tmp_path / f"{id}.TextGrid"
        write_line(path, ["AA", "B", "IY"])
        made.append(Line(id, "", path, None, DEFAULTS, PurePosixPath(id)))
    return Lines(tuple(made), ())


@pytest.fixture
def out(lines, tmp_path):
    folder = tmp_path / "out"
    make(lines, folder)
    return folder


def make(lines, folder, **settings):
    """The ids that the engine was asked for, in a run."""
    asked = []

    def engine(jobs):
        for job in jobs:
            asked.append(job.line.id)
            yield make_line(job)

    run(lines, folder, FORMATS, engine, **settings)
    return asked


def swap_bytes(path):
    """Other content of the same size and time."""
    before = path.stat()
    data = path.read_bytes()
    path.write_bytes(data.replace(b"0.1", b"0.2", 1))
    assert path.read_bytes() != data
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def test_unchanged_lines_reach_no_worker(lines, out):
    assert make(lines, out) == []
    assert dict(plan_run(lines, out, FORMATS)) == dict.fromkeys("abc", "keep")


def test_a_file_of_another_time_is_read(lines, out):
    os.utime(lines.lines[0].alignment)
    os.utime(out / "b.csv")
    before = read_ledger(out)
    assert make(lines, out) == ["a", "b"]  # read, and kept, because the content is the same
    assert {id: known.facts for id, known in read_ledger(out).items()} == {
        id: known.facts for id, known in before.items()
    }
    assert make(lines, out) == ["a"]  # it had changed just before, so its time says nothing yet


@pytest.mark.parametrize("change", ["size", "time", "gone"])
def test_a_changed_output_is_made_again(lines, out, change):
    whole = (out / "a.csv").read_bytes()
    if change == "gone":
        (out / "a.csv").unlink()
    elif change == "size":
        (out / "a.csv").write_bytes(whole[:-1])
    else:
        swap_bytes(out / "a.csv")
        os.utime(out / "a.csv")
    assert make(lines, out) == ["a"]
    assert (out / "a.csv").read_bytes() == whole


def test_verify_reads_what_size_and_time_hide(lines, out):
    swap_bytes(out / "a.csv")
    assert make(lines, out) == []
    assert [finding.id for finding in audit(lines, out)] == []
    assert [(found.id, found.problem) for found in audit(lines, out, verify=True)] == [("a", "stale")]
    assert make(lines, out, verify=True) == ["a", "b", "c"]
    assert audit(lines, out, verify=True) == []


def test_a_file_that_changed_just_now_has_no_stamp(lines):
    line = lines.lines[0]
    assert set(stamps.stamp_inputs(line)) == {"alignment"}
    os.utime(line.alignment)
    assert stamps.stamp_inputs(line) == {}


def test_other_options_make_the_lines_again(lines, out):
    assert dict(plan_run(lines, out, ("npz",))) == dict.fromkeys("abc", "make")


def test_a_killed_run_leaves_no_stamps_of_what_is_not_on_the_disk(lines, tmp_path):
    """Outcomes get their stamps after a sync, so that a power loss cannot leave a stamp without its file."""
    folder = tmp_path / "out"

    def engine(jobs):
        yield make_line(next(iter(jobs)))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(lines, folder, FORMATS, engine)
    assert [known.stamps for known in read_ledger(folder).values()] == [{}]
    assert make(lines, folder) == ["a", "b", "c"]
    assert make(lines, folder) == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"stamps": {"outputs": {"a.csv": [1]}}},
        {"stamps": {"alignment": "x"}},
        {"stamps": {"alignment": [1.5, 2]}},
        {"stamps": []},
        {"motion": {"still": 1, "end": 1.0, "seconds": 1.0}},
        {"motion": {"end": 1.0, "seconds": 1.0}},
        {"motion": {"still": False, "end": "1", "seconds": 1.0}},
    ],
)
def test_stamps_and_motions_of_wrong_types_are_left_out(out, wrong):
    entry = json.loads(encode_outcome(read_ledger(out)["a"]))
    assert decode_outcomes([json.dumps(entry)])
    assert not decode_outcomes([json.dumps(entry | wrong)])


def test_an_audit_goes_by_the_ledger(lines, out, monkeypatch):
    monkeypatch.setattr("phonanim.dubbing.audit.load", None)  # no file is read
    assert audit(lines, out) == []
    assert audit(lines, out, verify=True) == []


def test_an_audit_reads_what_the_ledger_does_not_know(lines, out):
    (out / "a.glb").write_bytes(b"damaged")
    found = audit(lines, out)
    assert [(finding.id, finding.problem) for finding in found] == [("a", "unreadable")]


@pytest.mark.slow
def test_an_audit_by_workers_finds_the_same(lines, out, monkeypatch):
    monkeypatch.setattr("phonanim.dubbing.audit.FEW", 1)
    (out / "ledger.jsonl").unlink()
    (out / "b.csv").write_bytes(b"damaged")
    found = [(finding.id, finding.problem) for finding in audit(lines, out, workers=2)]
    assert found == [("b", "unreadable")]


@pytest.mark.skipif(sys.platform != "linux", reason="kernels are chosen where OpenBLAS is loaded")
@pytest.mark.slow
def test_a_machine_of_another_kind_keeps_what_was_made(lines, out, tmp_path):
    """Its products are the same, and inputs and options decide."""
    made = {path.name: path.read_bytes() for path in out.glob("*.csv")}
    command = [sys.executable, "-m", "phonanim", "batch", str(tmp_path / "*.TextGrid"), "-o", str(out)]
    command += ["--verify", "--json", "--workers", "1"]
    for kernel in ("Prescott", "Haswell"):
        environment = {**os.environ, "OPENBLAS_CORETYPE": kernel}
        result = subprocess.run(
            [*command, "--verify", "--json", "--workers", "1"],
            env=environment,
            capture_output=True,
            text=True,
        )
        assert result.returncode == 0
        assert result.stdout.count('"status": "kept"') == 3
    assert made == {path.name: path.read_bytes() for path in out.glob("*.csv")}


def test_a_ledger_in_order_is_not_written_again(lines, out):
    ledger = out / "ledger.jsonl"
    before = ledger.stat().st_ino
    assert make(lines, out) == []
    assert ledger.stat().st_ino == before
    first, *others = ledger.read_text().splitlines()
    ledger.write_text("\n".join([*others, first, first]) + "\n")
    assert make(lines, out) == []
    assert ledger.read_text().splitlines() == [first, *others]


def test_an_origin_is_as_the_ledger_gives_it_back(lines, tmp_path):
    options = Options(
        overlays=(Overlay("smile", 0.5, (0.1, 0.2)),),
        emotions=(Emotion("joy", 0.3, (0.0, 1.0)),),
        closures=(Closure("hold", 0.1, 0.2),),
        life={"head": 0.5},
        look_at=(0.1, 0.0, 1.0),
        gains={"jawOpen": 0.5},
    )
    mesh = tmp_path / "hero.glb"
    mesh.write_bytes(b"glTF")
    line = replace(lines.lines[0], options=options, exports={"character": mesh, "timecode": "01:00:00:00"})
    origin = origin_of(line, ("csv", "glb"))
    assert json.loads(json.dumps(origin)) == origin
