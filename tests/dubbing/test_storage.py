"""Lines on shared storage: by URL, through fsspec."""

import http.server
import json
import os
import subprocess
import sys
import threading
from functools import partial
from pathlib import Path

import pytest
from ledgers import plain_ledger

from phonanim.__main__ import run as phonanim
from phonanim.dubbing import ledger_parts
from phonanim.dubbing.audit import audit
from phonanim.dubbing.ledger import NAME, ledger_writer, read_ledger
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.make import make_line
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.row import Common
from phonanim.dubbing.run import plan_run, run
from phonanim.dubbing.storage import Remote, parse_place, place_hash
from phonanim.errors import MissingExtraError, OptionError, OutputError
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.options import Options
from phonanim.rig.head import SHIPPED
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

COMMON = Common(Options(fps=25.0))
REPORTS = {NAME, "report.html", "report.json", "summary.txt"}


def inline(jobs):
    """An engine of this process, which alone sees memory://."""
    return map(make_line, jobs)


def write_line(path, vowel="AA"):
    phones = [Interval(vowel, 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2)]
    path.parent.mkdir(parents=True, exist_ok=True)
    write_textgrid(path, {"phones": phones}, 1.5)


@pytest.fixture
def lines(tmp_path, root):
    """Three lines on this machine, one with its recording, and a table of them."""
    for name in ("a", "b", "sub/c"):
        write_line(tmp_path / "lines" / f"{name}.TextGrid")
    (tmp_path / "lines" / "a.wav").write_bytes((root / "examples/line.wav").read_bytes())
    (tmp_path / "lines" / "script.csv").write_text(
        "id,alignment\na,a.TextGrid\nb,b.TextGrid\nsub/c,sub/c.TextGrid\n"
    )
    return tmp_path / "lines"


@pytest.fixture
def memory(lines):
    """The same on memory://show/lines."""
    fsspec = pytest.importorskip("fsspec")
    storage = fsspec.filesystem("memory")
    storage.put(str(lines), "/show/lines", recursive=True)
    yield storage
    storage.rm("/", recursive=True)


def contents(folder):
    found = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: content(name, path.read_bytes()) for name, path in found.items()}


def content(name, data):
    return plain_ledger(data) if name == NAME else data


def stored(storage, folder):
    found = {path.removeprefix(folder + "/"): path for path in storage.find(folder)}
    return {name: content(name, storage.cat_file(path)) for name, path in found.items()}


@pytest.mark.parametrize("source", ["", "/script.csv", "/**/*.TextGrid"])
def test_the_same_bytes_as_by_paths(memory, lines, tmp_path, source):
    if source:  # in a folder and under a pattern a.wav lies beside a line; the table has the same
        (lines / "other").mkdir()
    run(read_lines(f"{lines}{source}", COMMON), tmp_path / "out", ("csv", "npz"), inline)
    outcomes = run(
        read_lines(f"memory://show/lines{source}", COMMON),
        parse_place("memory://show/out"),
        ("csv", "npz"),
        inline,
    )
    assert [outcome.error for outcome in outcomes] == ["", "", ""]
    here, there = contents(tmp_path / "out"), stored(memory, "/show/out")
    assert (
        set(there)
        == set(here)
        == REPORTS | {f"{id}.{end}" for id in ("a", "b", "sub/c") for end in ("csv", "npz")}
    )
    made = [name for name in here if name not in REPORTS]
    assert {name: there[name] for name in made} == {name: here[name] for name in made}
    if source == "/script.csv":
        assert there[NAME] == here[NAME]


def test_what_is_unchanged_is_kept(memory, lines):
    target = parse_place("memory://show/out")
    told = []

    def again():
        told.clear()
        run(read_lines("memory://show/lines", COMMON), target, ("csv",), inline, told.append)
        return {result.outcome.id: result.made for result in told}

    assert again() == {"a": True, "b": True, "sub/c": True}
    first = stored(memory, "/show/out")
    assert again() == {"a": False, "b": False, "sub/c": False}
    assert stored(memory, "/show/out") == first
    write_line(lines / "b.TextGrid", "AE")
    memory.put_file(str(lines / "b.TextGrid"), "/show/lines/b.TextGrid")
    memory.pipe_file("/show/out/a.csv", b"edited")
    memory.rm_file("/show/out/sub/c.csv")
    assert dict(plan_run(read_lines("memory://show/lines", COMMON), target, ("csv",))) == dict.fromkeys(
        ("a", "b", "sub/c"), "make"
    )
    assert again() == {"a": True, "b": True, "sub/c": True}
    second = stored(memory, "/show/out")
    assert (second["a.csv"], second["sub/c.csv"]) == (first["a.csv"], first["sub/c.csv"])
    assert second["b.csv"] != first["b.csv"]


def test_a_character_and_an_overlay_that_change(memory, root):
    table = b"id,alignment,character,overlay\na,lines/a.TextGrid,hero.glb,brow.toml=0.5\n"
    memory.pipe_file("/show/t.csv", table)
    memory.pipe_file("/show/brow.toml", b"browInnerUp = 0.5\n")
    glb = read_glb(SHIPPED)
    made = []
    for author in ("one", "one", "two"):
        hero = glb_bytes({**glb.tree, "asset": {**glb.tree["asset"], "copyright": author}}, glb.binary)
        memory.pipe_file("/show/hero.glb", hero)
        run(
            read_lines("memory://show/t.csv", COMMON),
            parse_place("memory://show/out"),
            ("glb",),
            inline,
            made.append,
        )
        assert made[-1].outcome.error == ""
        spoken = read_glb_of(memory.cat_file("/show/out/a.glb"))
        assert spoken["asset"]["copyright"] == author
        assert (
            spoken["animations"][-1]["extras"]["provenance"]["options"]["overlays"][0]["source"]
            == "brow.toml"
        )
    assert [result.made for result in made] == [True, False, True]


def read_glb_of(content):
    """The JSON of a GLB."""
    return json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])


def test_a_run_that_was_killed_goes_on(memory, monkeypatch):
    lines, target = read_lines("memory://show/lines", COMMON), parse_place("memory://show/out")
    run(lines, parse_place("memory://show/calm"), ("csv",), inline)
    monkeypatch.setattr(ledger_parts, "PERIOD", 0.0)

    def killed(jobs):
        yield make_line(next(jobs))
        yield make_line(next(jobs))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(lines, target, ("csv",), killed)
    assert (
        len(memory.find("/show/out/ledger.parts")) == 3
    )  # the first one only tried whether it can be written
    assert set(read_ledger(target)) == {"a", "b"}
    told = []
    run(lines, target, ("csv",), inline, told.append)
    assert [result.made for result in told] == [False, False, True]
    assert stored(memory, "/show/out") == stored(memory, "/show/calm")


def test_parts_of_a_ledger_in_time_order(memory, monkeypatch):
    monkeypatch.setattr(ledger_parts, "PERIOD", 0.0)
    target = parse_place("memory://show/out")
    with ledger_writer(target) as record:
        record(Outcome("a", "row 2", error="no"))
        record(Outcome("a", "row 2", error="still no"))
    memory.pipe_file("/show/out/ledger.parts/0-cut.jsonl", b'{"id": "b", "pl')
    assert {id: outcome.error for id, outcome in read_ledger(target).items()} == {"a": "still no"}


def test_errors_name_the_url_and_the_rest_is_done(memory):
    memory.pipe_file("/show/lines/bad.TextGrid", b"no alignment")
    outcomes = run(
        read_lines("memory://show/lines", COMMON), parse_place("memory://show/out"), ("csv",), inline
    )
    errors = [outcome.error for outcome in outcomes if outcome.error]
    assert len(errors) == 1
    assert errors[0].startswith("memory:///show/lines/bad.TextGrid: is not an alignment in a known format")


def test_cells_may_be_urls_and_paths(memory, lines, root):
    table = f"id,alignment,audio,character,edits\nx,memory://show/lines/b.TextGrid,{lines}/a.wav,,\ny,../lines/a.TextGrid,,,\nz,gone.TextGrid,,,\n"
    memory.pipe_file("/show/tables/t.csv", table.encode())
    found = read_lines("memory://show/tables/t.csv", COMMON)
    assert [(str(line.alignment), str(line.audio)) for line in found.lines] == [
        ("memory:///show/lines/b.TextGrid", f"{lines}/a.wav"),
        ("memory:///show/lines/a.TextGrid", "memory:///show/lines/a.wav"),
    ]
    assert [fault.message for fault in found.faults] == [
        "memory:///show/tables/gone.TextGrid: does not exist; correct the path"
    ]


def test_audit(memory):
    lines, target = read_lines("memory://show/lines", COMMON), parse_place("memory://show/out")
    run(lines, target, ("csv",), inline)
    assert {finding.problem for finding in audit(lines, target)} == {
        "mistimed"
    }  # a.wav belongs to another line
    memory.pipe_file("/show/out/stray.csv", b"x")
    memory.pipe_file("/show/out/b.csv", b"x")
    memory.rm_file("/show/out/sub/c.csv")
    found = {(finding.problem, finding.id) for finding in audit(lines, target)}
    assert found == {
        ("mistimed", "a"),
        ("stale", "b"),
        ("unreadable", "b"),
        ("missing", "sub/c"),
        ("orphan", "stray.csv"),
    }
    with pytest.raises(
        OptionError, match="memory:///nowhere: there is no such folder; name the one with the outputs"
    ):
        audit(lines, parse_place("memory://nowhere"))


def test_file_urls_are_paths(monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    assert parse_place("file:///shows/the%20show/t.csv") == Path("/shows/the show/t.csv")
    assert parse_place("t.csv", Path("/shows")) == Path("/shows/t.csv")


@pytest.mark.parametrize(
    ("url", "kind", "message"),
    [
        ("nonsense://x", OptionError, "nonsense://x: cannot be opened: Protocol not known: nonsense"),
        ("hdfs://x/y", MissingExtraError, "hdfs://x/y: needs another package: .*pyarrow"),
    ],
)
def test_urls_of_no_use(url, kind, message):
    pytest.importorskip("fsspec")
    with pytest.raises(kind, match=message):
        parse_place(url)


def test_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    with pytest.raises(MissingExtraError, match=r"s3://x/t.csv: a URL needs pip install 'phonanim\[batch\]'"):
        parse_place("s3://x/t.csv")


def test_what_a_storage_says_is_one_line(memory, monkeypatch):
    for method in ("cat_file", "pipe_file", "rm_file"):
        monkeypatch.setattr(type(memory), method, refuse)
    with pytest.raises(OptionError, match="memory:///x/y: cannot be read: no, and again no$"):
        place_hash(parse_place("memory://x/y"))
    with pytest.raises(OutputError, match="memory:///x/y: cannot be written: no, and again no$"):
        parse_place("memory://x/y").write_bytes(b"")
    with pytest.raises(OutputError, match="memory:///x/y: cannot be removed: no, and again no$"):
        parse_place("memory://x/y").unlink()


def test_storage_that_cannot_be_written_shows_before_the_first_line(memory, monkeypatch):
    monkeypatch.setattr(type(memory), "pipe_file", refuse)
    lines = read_lines("memory://show/lines", COMMON)
    with pytest.raises(OutputError, match="ledger.parts/.*: cannot be written: no, and again no$"):
        run(lines, parse_place("memory://show/out"), ("csv",), refuse)


def refuse(*arguments, **options):
    raise RuntimeError("no,\n  and again no")


def test_what_is_not_there(memory):
    with pytest.raises(OptionError, match="memory:///x/y: does not exist; correct the URL"):
        parse_place("memory://x/y").read_bytes()
    with pytest.raises(
        OptionError, match="memory://x: does not exist; name a folder, a pattern in quotes, or a table"
    ):
        read_lines("memory://x", COMMON)


@pytest.mark.parametrize("other", ["b/c.csv", "../d"])
def test_joined(memory, other):
    assert parse_place("memory://show/a") / other == Remote(
        "memory://show/a", {"b/c.csv": "/show/a/b/c.csv", "../d": "/show/d"}[other]
    )


def test_a_path_does_not_import_fsspec(lines, tmp_path, root):
    code = (
        "import sys\nfrom phonanim.__main__ import run\n"
        "code = run(['batch', *sys.argv[1:], '--dry-run', '-q'])\n"
        "sys.exit(code or 'fsspec' in sys.modules)\n"
    )
    command = [sys.executable, "-c", code, str(lines), "-o", str(tmp_path / "out")]
    assert subprocess.run(command, env={**os.environ, "PYTHONPATH": str(root)}, check=False).returncode == 0


@pytest.fixture
def web(lines):
    """A web server of the lines."""
    pytest.importorskip("aiohttp")
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=str(lines))
    handler.log_message = lambda *arguments: None
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_lines_of_a_web_server(web, lines, tmp_path, monkeypatch, root):
    monkeypatch.setenv("PYTHONPATH", str(root))
    options = ["--fps", "25", "--workers", "1", "-q"]
    assert phonanim(["batch", f"{web}/script.csv", "-o", str(tmp_path / "web"), *options]) == 0
    assert phonanim(["batch", str(lines / "script.csv"), "-o", str(tmp_path / "out"), *options]) == 0
    web_made, made = contents(tmp_path / "web"), contents(tmp_path / "out")
    assert set(web_made) == set(made)
    assert web_made["sub/c.csv"] == made["sub/c.csv"]
    assert web_made[NAME] == made[NAME]


def test_lines_in_a_bucket(bucket, lines, tmp_path, monkeypatch, root, capsys):
    bucket.put(str(lines), "show/lines", recursive=True)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(root), *sys.path]))
    options = ["--fps", "25", "--workers", "2", "-q"]
    assert phonanim(["batch", "s3://show/lines", "-o", "s3://show/out", *options]) == 0
    assert phonanim(["batch", str(lines), "-o", str(tmp_path / "out"), *options]) == 0
    here, there = contents(tmp_path / "out"), stored(bucket, "show/out")
    del here["run.json"]  # how it was called is of use where it was
    assert set(here) == set(there)
    assert all(there[name] == here[name] for name in here if name not in REPORTS)
    assert phonanim(["batch", "s3://show/lines", "-o", "s3://show/out", *options, "--dry-run", "--json"]) == 0
    assert capsys.readouterr().out.count('"keep"') == 3
    assert phonanim(["batch", "s3://show/lines", "-o", "s3://shwo/out", *options]) == 2
    assert "s3://shwo/out/" in capsys.readouterr().err
