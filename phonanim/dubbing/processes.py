"""Worker processes on this machine: each gets a job, runs it, and sends the result back."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any

from phonanim.core.threads import use_one_thread
from phonanim.dubbing.job import Job, Result, Task
from phonanim.dubbing.outcome import Outcome
from phonanim.errors import OutputError

TRIES = 2  # a job whose worker dies is tried again, because the worker may have been killed from outside


@dataclass(slots=True)
class Worker:
    """A process, the pipe to it, and its current job."""

    process: Any
    pipe: Connection
    task: Task
    job: Job
    tries: int


def run_jobs(jobs: Iterable[Job], task: Task, workers: int) -> Iterator[Result]:
    """Run `task` for every job in `workers` processes, and yield the results as they arrive."""
    use_one_thread()  # in the workers, which inherit it
    waiting = iter(jobs)
    team: list[Worker] = []
    try:
        for job in islice(waiting, workers):
            team.append(_start(job, task))
        while team:
            for pipe in wait([worker.pipe for worker in team]):
                worker = next(worker for worker in team if worker.pipe is pipe)
                yield from _collect(worker, team, waiting)
    finally:
        for worker in team:
            worker.pipe.close()  # a worker ends when its pipe is closed
            worker.process.join()


def _collect(worker: Worker, team: list[Worker], waiting: Iterator[Job]) -> Iterator[Result]:
    """Receive a worker's result and give it the next job; a dead worker is replaced."""
    try:
        result = worker.pipe.recv()
    except (EOFError, OSError):
        yield from _bury(worker, team, waiting)
        return
    yield result
    job = next(waiting, None)
    if job is None:
        _dismiss(worker, team)
    else:
        worker.job, worker.tries = job, 1
        with suppress(OSError):  # it died between two jobs, which the next wait detects
            worker.pipe.send(job)


def _bury(worker: Worker, team: list[Worker], waiting: Iterator[Job]) -> Iterator[Result]:
    """Let another worker try the job of a dead one; when that dies too, the line has failed."""
    _dismiss(worker, team)
    if worker.tries < TRIES:
        team.append(_start(worker.job, worker.task, worker.tries + 1))
        return
    line = worker.job.line
    died = f"{TRIES} workers died on this line, the last with exit code {worker.process.exitcode}"
    mend = "free some memory, or check the line"
    yield Result(Outcome(line.id, line.place, error=f"{line.source}: {died}; {mend}"), made=True)
    job = next(waiting, None)
    if job is not None:
        team.append(_start(job, worker.task))


def _dismiss(worker: Worker, team: list[Worker]) -> None:
    team.remove(worker)
    worker.pipe.close()
    worker.process.join()


def _start(job: Job, task: Task, tries: int = 1) -> Worker:
    """Start a process for `job`; a fresh interpreter, which inherits no other worker's pipe."""
    context = multiprocessing.get_context("spawn")
    try:
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, task), daemon=True)
        with _without_interrupts():  # one that comes while a pipe is deleted would be ignored
            process.start()
            theirs.close()
            del theirs
    except OSError as error:
        raise OutputError(
            f"a worker cannot be started: {error.strerror}; use fewer --workers, or raise the limit (ulimit)"
        ) from error
    ours.send(job)
    return Worker(process, ours, task, job, tries)


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block Ctrl-C: here for a moment, and for good in a process that starts now; its parent handles it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # starting it would unblock the signal again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, task: Task) -> None:
    """The loop of a worker: runs jobs until the pipe is closed, also when the parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles it
    with suppress(EOFError, OSError):
        while True:
            pipe.send(task(pipe.recv()))
