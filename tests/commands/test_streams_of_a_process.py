"""What a command does when its input, output or messages have nowhere to go: it ends, without a traceback."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a shell")


def shell(root, tmp_path, line):
    command = f"{sys.executable} -m phonanim"
    return subprocess.run(
        ["bash", "-c", line.replace("phonanim", command, 1)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.mark.parametrize(
    ("line", "codes", "said"),
    [
        ("phonanim models --json > /dev/full", (2,), "phonanim: No space left on device"),
        ("phonanim models --json | head -c 1; exit ${PIPESTATUS[0]}", (0, 141), ""),
        ("phonanim rig check missing.toml 2>&-", (2,), ""),
        ("phonanim stream --realtime <&-", (0, 1, 2), ""),
        ("phonanim animate $'b\\xff.TextGrid' --json", (2,), ""),
    ],
)
def test_streams_that_lead_nowhere(root, tmp_path, line, codes, said):
    done = shell(root, tmp_path, line)
    assert done.returncode in codes
    assert "Traceback" not in done.stderr
    assert "Exception" not in done.stderr
    assert said in done.stderr


def test_closed_streams_do_not_take_the_number_of_a_file(root, tmp_path):
    (tmp_path / "line.TextGrid").write_bytes((root / "examples/line.TextGrid").read_bytes())
    assert shell(root, tmp_path, "phonanim animate line.TextGrid -o a.csv").returncode == 0
    assert shell(root, tmp_path, "phonanim animate line.TextGrid -o b.csv >&- 2>&- <&-").returncode == 0
    assert Path(tmp_path / "a.csv").read_bytes() == Path(tmp_path / "b.csv").read_bytes()


@pytest.mark.parametrize(
    "option",
    [
        "--fps=-1",
        "--fps=nan",
        "--fps=inf",
        "--fps=1e300",
        "--keys=-1",
        "--keys=nan",
        "--keys=inf",
        "--keys=1e300",
    ],
)
def test_numbers_that_nobody_means(root, tmp_path, capsys, option):
    from phonanim.__main__ import run

    code = run(["animate", str(root / "examples/line.TextGrid"), "-o", str(tmp_path / "a.anim"), option])
    told = capsys.readouterr().err
    assert code == 2
    assert len(told.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("start", ["nan", "inf", "-inf", "1e300"])
def test_starts_that_nobody_means(root, tmp_path, capsys, start):
    from phonanim.__main__ import run

    assert run(["convert", "a.npz", "-o", str(tmp_path / "a.csv"), f"--start={start}"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
