"""`phonanim stream`: files, lines and samples; what is wrong with them; the end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import wave
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from streams import made_up_model, speech

from phonanim.__main__ import run
from phonanim.options import Options
from phonanim.pipeline import animate

GOOD = """{"phone": "HH", "start": 0.1, "end": 0.2}
{"phone": "AA1", "start": 0.2, "end": 0.4}
{"time": 0.5}
{"end": true}
"""


@pytest.fixture(scope="module")
def line(line_without_sound: Path) -> Path:
    return line_without_sound


@pytest.fixture(scope="module")
def ears(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(made_up_model(tmp_path_factory.mktemp("models") / "cnn", "cnn"))


def lines_of(text: str, tmp_path: Path) -> Path:
    path = tmp_path / "phones.jsonl"
    path.write_text(text)
    return path


def frames(out: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in out.splitlines()][1:]


def test_a_file_of_phones_gives_what_animate_gives(line: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["stream", str(line), "--look-ahead", "exact", "--fps", "30", "--jaw", "1.3"]) == 0
    out, err = capfd.readouterr()
    values = np.array([frame["values"] for frame in frames(out)])
    batch = animate(line, Options(fps=30, jaw=1.3)).values
    np.testing.assert_allclose(values, batch, atol=1e-5)
    assert f"sent {len(batch)} frames to stdout" in err


def test_lines_and_what_is_wrong_with_them(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    wrong = {
        '{"phone": "HH", "start": 0.1, "end": 0.2}': 'phone "HH" at 0.1 s was sent twice; the second is left',
        "garbage": "a line is ignored (it is not JSON: Expecting value: line 1 column 1 (char 0)): garbage",
        "[" * 5000: "a line is ignored (it is not JSON: it is nested deeper than 64 levels): [",
        '{"phone": "AA1", "start": 0.1}': "a phone needs a label, a start and an end, and is ignored",
        '{"phone": "AA1", "start": 0.3, "end": true}': "a phone needs a label, a start and an end",
        '{"phone": "AA1", "start": 0.3, "end": NaN}': "a phone needs a label, a start and an end",
        '{"hello": 1}': 'a line is none of {"phone": "AA1", "start": 0.1, "end": 0.2}, {"time": 0.3} or',
        '{"time": 1' + "0" * 400 + "}": "a line is none of",
        '{"phone": "XYZQ", "start": 0.3, "end": 0.4}': 'no phone "XYZQ" in language english (nearest: ',
        '{"time": 1e9}': "the time 1e+09 s is 1e+09 s ahead, and at most 600 s may pass at once",
        '{"phone": "AA1", "start": 1e6, "end": 1e7}': 'phone "AA1" at 1e+06 s is 1e+07 s ahead',
        '{"time": 0.15}': "",
        '{"time": 0.1}': "the time went back from 0.15 to 0.1 s and is ignored",
        "x" * 200_000: "a line is longer than 65536 bytes and is ignored",
    }
    first, rest = GOOD.split("\n", 1)
    path = lines_of("\n".join([first, *wrong, rest]), tmp_path)
    assert run(["stream", str(path)]) == 0
    out, err = capfd.readouterr()
    for text in wrong.values():
        assert text in err
    assert f"{len(wrong) - 1} problems in the input" in err
    assert "Traceback" not in err
    assert run(["stream", str(lines_of(GOOD, tmp_path)), "-q"]) == 0
    assert capfd.readouterr() == (out, "")


def test_problems_without_end_are_counted(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["stream", str(lines_of("no\n" * 500 + GOOD, tmp_path)), "--json"]) == 0
    told = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    problems = [line["text"] for line in told if line.get("event") == "problem"]
    assert len(problems) == 21
    assert problems[-1] == "further problems are counted, but not reported"
    assert told[-1]["problems"] == 500
    assert told[-1]["frames"] == 31


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "udp"], "there is no sink 'udp'"),
        (["--realtime", "--look-ahead", "exact"], "--look-ahead exact waits as long as it takes; with"),
        (["--delay", "0.1"], "--delay needs --realtime; add it"),
        (["--look-ahead", "soon"], "'soon' is not a number of seconds or exact"),
        (["--look-ahead", "nan"], "nan does not lie in 0 to 10 seconds"),
        (["--model", "nix"], "there is no model 'nix'"),
    ],
)
def test_options_that_make_no_sense(
    arguments: list[str], message: str, line: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["stream", str(line), *arguments]) == 2
    out, err = capfd.readouterr()
    assert message in err
    assert out == ""


def test_in_real_time(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Phones that are known ahead are used, even without delay, once they have been read."""
    path = lines_of(GOOD, tmp_path)
    assert run(["stream", str(path), "--look-ahead", "exact"]) == 0
    exact = frames(capfd.readouterr().out)
    began = time.monotonic()
    arguments = ["--realtime", "--delay", "0", "--look-ahead", "0.5", "--json"]
    assert run(["stream", str(path), *arguments]) == 0
    assert time.monotonic() - began > 0.5
    told = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert told[-1]["event"] == "end"
    late = [frame["values"] for frame in told[10:-1]]
    np.testing.assert_allclose(late, [frame["values"] for frame in exact[9:]], atol=3e-5)


@pytest.mark.parametrize("command", ["animate", "batch", "stream"])
def test_one_thread_is_settled_before_numpy_comes(command: str) -> None:
    code = f"import os, sys, phonanim.commands.{command}; "
    code += "sys.exit('numpy' in sys.modules or os.environ['OPENBLAS_NUM_THREADS'] != '1')"
    clean = {name: value for name, value in os.environ.items() if not name.endswith("NUM_THREADS")}
    assert subprocess.run([sys.executable, "-c", code], env=clean).returncode == 0


def started(*arguments: str, **more: Any) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "phonanim", "stream", *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        # What runs in the background has its interrupts ignored, and hands that on.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        **more,
    )


@pytest.mark.parametrize("arguments", [[], ["--realtime"]])
def test_it_is_interrupted_without_a_trace(arguments: list[str], root: Path) -> None:
    process = started(*arguments, cwd=root)
    assert process.stdin
    assert process.stdout
    process.stdin.write(GOOD.encode().split(b'{"end"')[0])
    process.stdin.flush()
    for _ in range(10):
        assert process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert b"sent " in err
    assert b"Traceback" not in err
    assert b"Fatal" not in err


def test_a_reader_that_hangs_up(line: Path, root: Path) -> None:
    process = started(str(line), cwd=root)
    assert process.stdout
    process.stdout.readline()
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=20)
    assert process.returncode == 1
    assert b"stdout: disconnected; the stream continues without it" in err
    assert b"Traceback" not in err
    assert b"BrokenPipe" not in err


def written(path: Path, samples: np.ndarray, rate: int = 16000, channels: int = 1) -> Path:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((np.repeat(samples, channels) * 32767).astype("<i2").tobytes())
    return path


@pytest.mark.parametrize("channels", [1, 2])
def test_a_recording(channels: int, ears: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path / "a.wav", speech(0.7), channels=channels)
    assert run(["stream", str(path), "--model", ears]) == 0
    assert len(frames(capfd.readouterr().out)) == 43


@pytest.mark.parametrize(
    ("rate", "subtype", "seconds"),
    [(44100, "PCM_24", 0.7), (48000, "FLOAT", 0.7), (8000, "PCM_16", 0.7), (16000, "PCM_24", 0.005)],
)
def test_recordings_of_other_kinds(
    rate: int, subtype: str, seconds: float, ears: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    soundfile = pytest.importorskip("soundfile")
    if rate != 16000:
        pytest.importorskip("soxr")
    samples = speech(seconds, rate)
    soundfile.write(tmp_path / "a.wav", np.stack([samples, samples], axis=1), rate, subtype=subtype)
    assert run(["stream", str(tmp_path / "a.wav"), "--model", ears]) == 0
    assert len(frames(capfd.readouterr().out)) == int(len(samples) / rate * 60 + 1e-6) + 1


def test_what_is_no_recording(ears: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("soundfile")
    (tmp_path / "a.wav").write_text("no sound at all")
    assert run(["stream", str(tmp_path / "a.wav"), "--model", ears]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert "a.wav: is not a readable recording" in err


def test_a_recording_of_nothing(ears: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path / "a.wav", np.zeros(0))
    assert run(["stream", str(path), "--model", ears]) == 2
    said = capfd.readouterr().err.splitlines()
    assert said[1:] == [f"phonanim: {path}: contains no samples; record it again"]


def test_a_recording_that_is_cut_short(ears: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path / "a.wav", speech(1.0))
    path.write_bytes(path.read_bytes()[: 44 + 16000])
    assert run(["stream", str(path), "--model", ears]) == 0
    out, err = capfd.readouterr()
    assert "the recording is truncated: it contains 0.50 s of 1.00 s; copy it again" in err
    assert len(frames(out)) == 31


def test_a_recording_for_a_model_that_reads(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path / "a.wav", speech(0.1))
    assert run(["stream", str(path), "--model", "default"]) == 2
    choose = "choose --model audio, or one of kind cnn or tcn"
    expected = f"{path}: is a recording, and default reads phones; {choose}"
    assert capfd.readouterr().err == f"phonanim: {expected}\n"


def test_a_microphone_for_a_model_that_reads(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(["stream", "--microphone", "--model", "default"]) == 2
    choose = "choose --model audio, or one of kind cnn or tcn"
    expected = f"--microphone: gives audio, and default reads phones; {choose}"
    assert capfd.readouterr().err == f"phonanim: {expected}\n"


def test_raw_samples(ears: str, root: Path) -> None:
    data = (speech(0.5) * 32767).astype("<i2").tobytes()
    process = started("--model", ears, "-q", cwd=root)
    out, err = process.communicate(data + b"x", timeout=30)
    assert err == b"the last 1 bytes are not a whole sample and are ignored\n"
    assert len(frames(out.decode())) == 31
