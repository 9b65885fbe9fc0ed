"""Workers of a dask.distributed cluster that is already running; they must share the file system."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from phonanim.dubbing.job import Job, Result, Task
from phonanim.dubbing.outcome import Outcome
from phonanim.errors import MissingExtraError, OptionError

RETRIES = 2
PATIENCE = "10s"  # time to find the scheduler


def run_jobs(jobs: Iterable[Job], task: Task, scheduler: str) -> Iterator[Result]:
    """Run `task` for every job on the cluster at `scheduler`, and yield the results as they arrive.

    A line whose worker dies is tried again on another one. When the scheduler stops, the remaining lines fail
    with that reason. Raises OptionError when there is no scheduler, MissingExtraError.
    """
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise MissingExtraError("--engine dask needs pip install 'phonanim[batch]'") from error
    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise OptionError(
            f"no dask scheduler answers at {scheduler} ({error}); start one, or correct the address"
        ) from error
    with client:
        left = {
            future: job for job in jobs for future in [client.submit(task, job, retries=RETRIES, pure=False)]
        }
        yield from _collect(as_completed(left, raise_errors=False), left)
        for job in left.values():
            yield _failed(job, "the scheduler stopped; run again to continue")


def _collect(finished: Iterable[Any], left: dict[Any, Job]) -> Iterator[Result]:
    for future in finished:
        if future.status == "cancelled":
            return
        job = left.pop(future)
        error = future.exception() if future.status == "error" else None
        yield _failed(job, f"the cluster stopped this job: {error}") if error else future.result()
        future.release()


def _failed(job: Job, why: str) -> Result:
    line = job.line
    return Result(Outcome(line.id, line.place, error=f"{line.source}: {why}"), made=True)
