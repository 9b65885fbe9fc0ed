"""The dask engine against a real scheduler and two worker processes on this machine."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from ledgers import plain_ledger

from phonanim.__main__ import run
from phonanim.dubbing.cluster import run_jobs
from phonanim.errors import MissingExtraError, OptionError
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

LINES = 60


def start(module, root, *arguments):
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    return subprocess.Popen(
        command,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(root), *sys.path]),
            "OPENBLAS_NUM_THREADS": "1",
        },
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


@pytest.fixture
def cluster(root, tmp_path):
    """The scheduler's address and the processes: scheduler, worker, worker."""
    pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    at = ["--scheduler-file", str(file), "--no-dashboard"]
    processes = [start("dask_scheduler", root, *at, "--host", "127.0.0.1", "--port", "0")]
    alone = [
        "--nworkers",
        "1",
        "--nthreads",
        "1",
        "--no-nanny",
        "--local-directory",
        str(tmp_path / "scratch"),
    ]
    processes += [start("dask_worker", root, *at, *alone) for _ in range(2)]
    try:
        yield address(file), processes
    finally:
        for process in processes:
            process.kill()
            process.wait()


def address(file):
    for _ in range(300):
        if file.exists() and file.stat().st_size:
            return json.loads(file.read_text())["address"]
        time.sleep(0.1)
    raise TimeoutError(file)


@pytest.fixture
def lines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in range(LINES):
        phones = [Interval("AA", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2)]
        write_textgrid(
            make_folder(tmp_path / "lines") / f"{number}.TextGrid", {"phones": phones}, 1.5 + number / 10
        )
    return tmp_path / "lines"


def make_folder(path):
    path.mkdir(exist_ok=True)
    return path


def outputs(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.csv")}


def batch(out, *arguments):
    return run(["batch", "lines", "-o", out, "-q", *arguments])


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_nothing(cluster, lines, tmp_path):
    scheduler, processes = cluster
    command = [sys.executable, "-m", "phonanim", "batch", "lines", "-o", "out"]
    command += ["--engine", "dask", "--scheduler", scheduler, "--json"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        os.kill(processes[1].pid, signal.SIGKILL)
        rest = process.stdout.read().splitlines()
    assert process.returncode == 0
    assert json.loads(rest[-1])["done"] == LINES
    assert batch("calm", "--workers", "1") == 0
    assert outputs(tmp_path / "out") == outputs(tmp_path / "calm")
    ledgers = [(tmp_path / name / "ledger.jsonl").read_bytes() for name in ("out", "calm")]
    assert plain_ledger(ledgers[0]) == plain_ledger(ledgers[1])


@pytest.mark.slow
def test_lines_in_a_bucket_on_a_cluster(lines, bucket, cluster):
    bucket.put(str(lines), "show/lines", recursive=True)
    options = ["--engine", "dask", "--scheduler", cluster[0]]
    assert run(["batch", "s3://show/lines", "-o", "s3://show/out", "-q", *options]) == 0
    assert batch("out", "--workers", "1") == 0
    there = {path.rpartition("/")[2]: bucket.cat_file(path) for path in bucket.glob("show/out/*.csv")}
    assert there == outputs(lines.parent / "out")


@pytest.mark.slow
def test_a_scheduler_that_goes_away_fails_what_is_left(cluster, lines, tmp_path):
    scheduler, processes = cluster
    command = [sys.executable, "-m", "phonanim", "batch", "lines", "-o", "out"]
    command += ["--engine", "dask", "--scheduler", scheduler, "--json"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    for worker in processes[1:]:
        os.kill(worker.pid, signal.SIGSTOP)
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE) as process:
        time.sleep(8.0)  # for the client to find the scheduler, on a busy machine too
        processes[0].kill()
        events = [json.loads(line) for line in process.stdout.read().splitlines()]
    assert process.returncode == 1
    failed = [event["error"] for event in events if event.get("status") == "failed"]
    assert len(failed) == LINES
    assert all(error.endswith("the scheduler stopped; run again to continue") for error in failed)
    assert batch("out", "--workers", "1") == 0


def test_nobody_answers(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("phonanim.dubbing.cluster.PATIENCE", "1s")
    with pytest.raises(OptionError, match=r"no dask scheduler answers at tcp://127.0.0.1:9 .*; start one"):
        next(run_jobs([], print, "tcp://127.0.0.1:9"))
    with pytest.raises(OptionError, match=r"no dask scheduler answers at nonsense://x"):
        next(run_jobs([], print, "nonsense://x"))


def test_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"--engine dask needs pip install 'phonanim\[batch\]'"):
        next(run_jobs([], print, "tcp://127.0.0.1:9"))
