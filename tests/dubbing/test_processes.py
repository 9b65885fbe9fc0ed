"""The team of worker processes, at work on something simpler than animation."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path, PurePosixPath

import pytest

from phonanim.core.threads import count_cores
from phonanim.dubbing.job import Job, Result
from phonanim.dubbing.line import Line
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.processes import run_jobs
from phonanim.options import Options


def job(name: str, folder: Path) -> Job:
    line = Line(name, "row 1", Path(f"{name}.TextGrid"), None, Options(), PurePosixPath(name))
    return Job(line, folder, ("csv",), None)


def work(job: Job) -> Result:
    """Die on "die", die once on "die once", note which process did the rest."""
    name, marker = job.line.id, job.folder / "died"
    if name == "die" or (name == "die once" and not marker.exists()):
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.01)
    return Result(Outcome(name, "", facts={"process": os.getpid()}), made=True)


def outcomes(names, folder, workers):
    results = run_jobs((job(name, folder) for name in names), work, workers)
    return {result.outcome.id: result.outcome for result in results}


def test_every_job_is_done_once_by_as_many_processes(tmp_path):
    names = [f"line {number}" for number in range(40)]
    done = outcomes(names, tmp_path, 3)
    assert sorted(done) == sorted(names)
    assert len({outcome.facts["process"] for outcome in done.values()} - {os.getpid()}) in (2, 3)


def test_no_jobs_and_fewer_jobs_than_workers(tmp_path):
    assert outcomes([], tmp_path, 2) == {}
    assert set(outcomes(["a"], tmp_path, 4)) == {"a"}


def test_a_worker_that_dies_is_replaced_and_its_line_tried_again(tmp_path):
    done = outcomes(["a", "die once", "b", "c"], tmp_path, 2)
    assert sorted(done) == ["a", "b", "c", "die once"]
    assert all(outcome.done for outcome in done.values())


@pytest.mark.parametrize("workers", [1, 2])
def test_a_line_that_kills_every_worker_fails_and_the_rest_is_done(tmp_path, workers):
    done = outcomes(["a", "die", "b", "c"], tmp_path, workers)
    assert [name for name, outcome in done.items() if not outcome.done] == ["die"]
    assert done["die"].error == (
        "die.TextGrid: 2 workers died on this line, the last with exit code -9; "
        "free some memory, or check the line"
    )
    assert sorted(done) == ["a", "b", "c", "die"]


def test_workers_end_when_their_parent_is_killed(tmp_path, root):
    code = (
        "import sys, os; from pathlib import Path; sys.path[:0] = sys.argv[2:]\n"
        "from tests.dubbing import test_processes as t\n"
        "if __name__ == '__main__':\n"
        "    folder = Path(sys.argv[1])\n"
        "    for result in t.run_jobs((t.job(str(n), folder) for n in range(10**6)), t.work, 2):\n"
        "        print(result.outcome.facts['process'], flush=True)\n"
    )
    script = tmp_path / "run.py"
    script.write_text(code)
    command = [sys.executable, str(script), str(tmp_path), str(root)]
    parent = subprocess.Popen(command, stdout=subprocess.PIPE)
    workers = {int(parent.stdout.readline()) for _ in range(10)}
    parent.kill()
    parent.communicate()
    for _ in range(200):
        workers = {pid for pid in workers if alive(pid)}
        if not workers:
            break
        time.sleep(0.05)
    assert not workers


def test_an_interrupt_while_workers_start_leaves_no_trace(tmp_path, root):
    code = (
        "import sys, time; from pathlib import Path; sys.path[:0] = sys.argv[2:]\n"
        "from tests.dubbing import test_processes as t\n"
        "if __name__ != '__main__':\n"
        "    print('a worker starts', flush=True)\n"
        "    time.sleep(1)\n"
        "else:\n"
        "    try:\n"
        "        list(t.run_jobs((t.job(str(n), Path(sys.argv[1])) for n in range(10**6)), t.work, 2))\n"
        "    except KeyboardInterrupt:\n"
        "        sys.exit(130)\n"
    )
    script = tmp_path / "run.py"
    script.write_text(code)
    parent = subprocess.Popen(
        [sys.executable, str(script), str(tmp_path), str(root)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert parent.stdout.readline() == "a worker starts\n"
    os.killpg(parent.pid, signal.SIGINT)
    assert parent.communicate(timeout=60)[1] == ""
    assert parent.returncode == 130


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_cores():
    assert 1 <= count_cores() <= (os.cpu_count() or 1)


def test_jobs_are_taken_as_they_are_needed(tmp_path):
    taken = []

    def jobs():
        for number in range(30):
            taken.append(number)
            yield replace(job(str(number), tmp_path))

    results = run_jobs(jobs(), work, 2)
    next(results)
    assert len(taken) <= 4
    results.close()
