"""`phonanim batch` and `phonanim audit` on real lines: kept, made again, killed, and looked over."""

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from ledgers import plain_ledger

from phonanim.__main__ import run
from phonanim.core.files import PARTIAL
from phonanim.dubbing.ledger import NAME, read_ledger
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

FAST = ["--fps", "25", "--workers", "1"]


def write_line(path, phones):
    """A line of half a second of silence, the phones, a tenth of a second each, and silence."""
    intervals = [Interval(phone, 0.5 + n / 10, 0.6 + n / 10) for n, phone in enumerate(phones)]
    write_textgrid(path, {"phones": intervals}, 1.0 + len(phones) / 10)


@pytest.fixture
def lines(tmp_path, monkeypatch, root):
    """Six short lines in lines/, one of them bad, in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(root))
    folder = tmp_path / "lines"
    (folder / "sub").mkdir(parents=True)
    for number, name in enumerate(("a", "b", "c", "sub/d", "sub/e")):
        write_line(folder / f"{name}.TextGrid", ["AA", "B", "IY", "M", "UW", "P"][: 3 + number])
    (folder / "bad.TextGrid").write_text("no alignment")
    return folder


def batch(*arguments):
    return run(["batch", *map(str, arguments)])


def contents(folder):
    """The bytes of every file, and the entries of the ledger."""
    found = {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }
    return found | {name: plain_ledger(data) for name, data in found.items() if name == NAME}


def events(capsys):
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def statuses(capsys):
    return {event["id"]: event["status"] for event in events(capsys) if event["event"] == "line"}


def test_a_folder_with_one_bad_line(lines, tmp_path, capsys):
    assert batch("lines", "-o", "out", *FAST) == 1
    err = capsys.readouterr().err
    assert "bad: lines/bad.TextGrid" in err.replace(f"{tmp_path}/", "")
    assert re.search(r"6 lines: 5 made, 0 kept \(.*\), 1 failed, 0 flagged", err)
    made = contents(tmp_path / "out")
    assert {name for name in made if name.endswith(".csv")} == {
        "a.csv",
        "b.csv",
        "c.csv",
        "sub/d.csv",
        "sub/e.csv",
    }
    assert {NAME, "report.html", "report.json", "summary.txt"} <= set(made)
    report = json.loads(made["report.json"])
    assert report["lines"][0]["id"] == "bad"
    assert report["totals"] | {"seconds": 0, "frames": 0, "flags": {}, "flagged": 0} == {
        **{"lines": 6, "done": 5, "failed": 1},
        **{"seconds": 0, "frames": 0, "flags": {}, "flagged": 0, "languages": {"english": 5}},
    }
    assert made["report.html"].index(b"bad.TextGrid") < made["report.html"].index(b"<td>a</td>")


def test_a_line_is_what_animate_makes_of_it(lines, tmp_path):
    batch("lines", "-o", "out", "--format", "npz", "--format", "csv", *FAST)
    assert run(["animate", "lines/sub/d.TextGrid", "-o", "d.npz", "-o", "d.csv", "--fps", "25", "-q"]) == 0
    for suffix in ("npz", "csv"):
        assert (tmp_path / f"out/sub/d.{suffix}").read_bytes() == (tmp_path / f"d.{suffix}").read_bytes()


def test_what_is_unchanged_is_kept_and_what_changed_is_made_again(lines, tmp_path, capsys):
    batch("lines", "-o", "out", *FAST, "--json")
    assert set(statuses(capsys).values()) == {"made", "failed"}
    first = contents(tmp_path / "out")

    assert batch("lines", "-o", "out", *FAST, "--json") == 1
    assert statuses(capsys) == dict.fromkeys(("a", "b", "c", "sub/d", "sub/e"), "kept") | {"bad": "failed"}
    assert contents(tmp_path / "out") == first

    write_line(lines / "a.TextGrid", ["AE", "P"])  # another input
    (tmp_path / "out/b.csv").write_text("edited")  # another output
    (tmp_path / "out/c.csv").unlink()
    write_line(lines / "bad.TextGrid", ["IY"])
    assert batch("lines", "-o", "out", *FAST, "--json") == 0
    again = dict.fromkeys(("a", "b", "c", "bad"), "made")
    assert statuses(capsys) == again | {"sub/d": "kept", "sub/e": "kept"}
    second = contents(tmp_path / "out")
    assert second["b.csv"] == first["b.csv"]
    assert second["c.csv"] == first["c.csv"]
    assert second["a.csv"] != first["a.csv"]

    batch("lines", "-o", "out", "--fps", "30", "--workers", "1", "--json")  # another option
    assert set(statuses(capsys).values()) == {"made"}


def test_a_gain_is_part_of_what_a_line_is_made_with(lines, capsys):
    for gain, status in (("1.2", "made"), ("1.2", "kept"), ("1.1", "made")):
        batch("lines", "-o", "out", *FAST, "--gain", f"jawOpen={gain}", "--json")
        assert statuses(capsys)["a"] == status


def test_dry_run_writes_nothing(lines, tmp_path, capsys):
    assert batch("lines", "-o", "out", "--dry-run", "--json") == 0
    assert {event["would"] for event in events(capsys)} == {"make"}
    assert not (tmp_path / "out").exists()
    batch("lines", "-o", "out", *FAST, "-q")
    before = contents(tmp_path / "out")
    write_line(lines / "a.TextGrid", ["AE", "P"])
    batch("lines", "-o", "out", "--dry-run", *FAST)
    err = capsys.readouterr().err
    assert err == "2 to make, 4 to keep, 0 invalid\n"
    batch("lines", "-o", "out", "--dry-run", "-v", *FAST)
    assert "make  a\nkeep  b\n" in capsys.readouterr().err
    assert contents(tmp_path / "out") == before


def test_a_table_with_a_bad_row(lines, tmp_path, capsys):
    rows = ["Line ID,TextGrid,FPS,Director", "x/1,lines/a.TextGrid,50,Ann", "x/1,lines/b.TextGrid,25,Ann"]
    (tmp_path / "script.csv").write_text("\n".join(rows), "utf-8")
    assert batch("script.csv", "-o", "out", "--format", "npz", "--workers", "1") == 1
    report = json.loads((tmp_path / "out/report.json").read_text())
    assert [(line["id"], bool(line["error"])) for line in report["lines"]] == [("x/1", True), ("x/1", False)]
    assert "script.csv row 3: the id 'x/1' is already used by script.csv row 2" in report["lines"][0]["error"]
    assert report["remarks"] == ["script.csv: the column 'Director' is not used"]
    assert np.load(tmp_path / "out/x/1.npz")["fps"] == 50


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing", "-o", "out"], "missing: does not exist"),
        (["lines", "-o", "out", "--format", "xyz"], "xyz"),
        (["lines", "-o", "out", "--model", "defualt"], "did you mean 'default'"),
        (["lines", "-o", "out", "--rig", "arkt"], "there is no rig 'arkt'"),
        (["lines", "-o", "lines/a.TextGrid"], "lines/a.TextGrid: cannot be created: File exists"),
        (["lines", "-o", "out", "--engine", "dask"], "needs the address of a running cluster"),
        (["lines"], "Missing option '-o' / '--output'"),
    ],
)
def test_what_is_of_no_use_is_one_line(arguments, said, lines, tmp_path, capsys):
    assert batch(*arguments) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_two_runs_at_once_are_refused(lines, capsys):
    from phonanim.dubbing.ledger import lock_folder
    from phonanim.dubbing.run import make_folder

    out = lines.parent / "out"
    make_folder(out)
    with lock_folder(out):
        assert batch("lines", "-o", "out", *FAST) == 2
    assert "another run is writing there" in capsys.readouterr().err


def test_outputs_under_a_file_are_named(lines, tmp_path, capsys):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "sub").write_text("in the way")
    assert batch("lines", "-o", "out", *FAST) == 1
    err = capsys.readouterr().err
    assert re.search(r"^2 lines failed: .*sub", err, re.MULTILINE)


def start_batch(lines, out):
    command = [sys.executable, "-m", "phonanim", "batch", "lines", "-o", out, "--workers", "2", "-q"]
    return subprocess.Popen(command, cwd=lines.parent, start_new_session=True)


@pytest.mark.slow
def test_kills_at_any_moment_leave_the_same_bytes(lines, tmp_path):
    for number in range(40):
        write_line(lines / f"k{number}.TextGrid", ["AA", "B", "IY", "M"] * (1 + number % 3))
    assert start_batch(lines, "calm").wait() == 1
    calm = contents(tmp_path / "calm")
    assert sum(name.endswith(".csv") for name in calm) == 45
    rng = random.Random(1)
    for _ in range(12):
        process = start_batch(lines, "out")
        time.sleep(rng.uniform(0.05, 1.5))
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    assert start_batch(lines, "out").wait() == 1
    assert contents(tmp_path / "out") == calm


def test_leftovers_of_a_kill_are_swept(lines, tmp_path):
    (tmp_path / "out/sub").mkdir(parents=True)
    for place in ("out", "out/sub"):
        (tmp_path / place / f".ffffff6789ab{PARTIAL}.csv").write_text("half")
    batch("lines", "-o", "out", *FAST, "-q")
    assert not [name for name in contents(tmp_path / "out") if PARTIAL in name]


def test_a_disk_that_fills_up_and_is_emptied(lines, tmp_path):
    code = (
        "import resource, sys\n"
        "from phonanim.__main__ import run\n"
        "if __name__ == '__main__':\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))\n"
        "    sys.exit(run(sys.argv[1:]))\n"
    )
    (tmp_path / "full.py").write_text(code)
    options = ["batch", "lines", "-o", "out", *FAST, "-q"]
    done = subprocess.run([sys.executable, "full.py", *options], capture_output=True, text=True)
    assert done.returncode in (1, 2)
    assert "Traceback" not in done.stderr
    assert not [name for name in contents(tmp_path / "out") if name.endswith(".csv")]
    assert run(options) == 1
    batch("lines", "-o", "calm", *FAST, "-q")
    assert contents(tmp_path / "out") == contents(tmp_path / "calm")


def test_flags(lines, tmp_path, root):
    write_textgrid(
        lines / "fast.TextGrid", {"phones": [Interval("AA", n / 40, (n + 1) / 40) for n in range(60)]}, 1.5
    )
    shutil.copy(root / "examples/line.wav", lines / "a.wav")
    write_line(lines / "odd.TextGrid", ["AA", "XYZZY", "AA"])
    write_line(lines / "breath.TextGrid", ["AA", "br", "AA"])
    long = [Interval("AA", 0.5, 0.6), Interval("spn", 0.6, 1.4), Interval("AA", 1.4, 1.5)]
    write_textgrid(lines / "long.TextGrid", {"phones": long}, 2.0)
    rows = ["id,alignment,unknown"] + [
        f"{name},lines/{name}.TextGrid,silence" for name in ("a", "fast", "odd", "breath", "long", "c")
    ]
    (tmp_path / "script.csv").write_text("\n".join(rows))
    assert batch("script.csv", "-o", "out", "--language", "english", "-q") == 0
    report = json.loads((tmp_path / "out/report.json").read_text())
    flags = {line["id"]: {flag["check"] for flag in line["facts"]["flags"]} for line in report["lines"]}
    assert "length" in flags["a"]
    assert "silence" in flags["a"]
    assert flags["fast"] == {"speed"}
    assert flags["odd"] == {"labels"}
    assert flags["breath"] == flags["c"] == set()
    assert flags["long"] == {"labels"}
    assert report["lines"][-1]["id"] == "c"  # the worst first


def test_closures_are_missed_without_contacts(lines, tmp_path):
    # The b lies between two frames.
    short = [Interval("M", 0.5, 0.6), Interval("B", 0.6, 0.61), Interval("AA", 0.61, 1.0)]
    write_textgrid(lines / "short.TextGrid", {"phones": short}, 1.5)
    batch("lines", "-o", "with", "-q", *FAST)
    batch("lines", "-o", "without", "-q", "--no-contacts", "--intensity", "1", *FAST)
    counts = [
        json.loads((tmp_path / name / "report.json").read_text())["totals"]["flags"].get("closures", 0)
        for name in ("with", "without")
    ]
    assert counts[0] == 0
    assert counts[1] >= counts[0]


def freeze(path):
    """Give every row of a Live Link file the values of the first."""
    header, *rows = (row.split(",") for row in path.read_text().splitlines())
    path.write_text(
        "\n".join(",".join(row) for row in [header, *(row[:2] + rows[0][2:] for row in rows)]) + "\n"
    )


def audited(*arguments, capsys):
    capsys.readouterr()
    code = run(["audit", *map(str, arguments), "--json"])
    facts = json.loads(capsys.readouterr().out)
    return code, {(finding["problem"], finding["id"]) for finding in facts["findings"]}


def test_audit(lines, tmp_path, capsys):
    (lines / "bad.TextGrid").unlink()
    batch("lines", "-o", "out", "-q", *FAST)
    assert audited("lines", "--outputs", "out", capsys=capsys) == (0, set())

    out = tmp_path / "out"
    (out / "a.csv").unlink()
    (out / "stray.csv").write_text("x")
    write_line(lines / "b.TextGrid", ["AE", "P", "AE"])
    freeze(out / "c.csv")
    (out / "sub/d.csv").write_text("\n".join((out / "sub/d.csv").read_text().splitlines()[:-12]) + "\n")
    (out / "sub/e.csv").write_bytes(b"\x00\x01")
    code, found = audited("lines", "--outputs", "out", capsys=capsys)
    assert code == 1
    assert found == {
        ("missing", "a"),
        ("stale", "b"),
        ("stale", "c"),
        ("still", "c"),
        ("stale", "sub/d"),
        ("mistimed", "sub/d"),
        ("stale", "sub/e"),
        ("unreadable", "sub/e"),
        ("orphan", "stray.csv"),
    }


def test_audit_without_a_ledger_goes_by_times(lines, tmp_path, capsys):
    (lines / "bad.TextGrid").unlink()
    batch("lines", "-o", "out", "-q", *FAST)
    (tmp_path / "out" / NAME).unlink()
    assert audited("lines", "--outputs", "out", capsys=capsys) == (0, set())
    later = time.time() + 10
    os.utime(lines / "a.TextGrid", (later, later))
    assert audited("lines", "--outputs", "out", capsys=capsys) == (1, {("stale", "a")})


def test_the_ledger_remembers_the_lines_of_other_sources(lines, tmp_path):
    batch("lines/sub", "-o", "out", "-q", *FAST)
    batch("lines/*.TextGrid", "-o", "out", "-q", *FAST)
    assert set(read_ledger(tmp_path / "out")) == {"a", "b", "bad", "c", "d", "e"}
