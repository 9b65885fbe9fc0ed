"""Make one line: the work of a worker."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from phonanim.animate import perform
from phonanim.dubbing.checks import facts_of
from phonanim.dubbing.job import Job, Result
from phonanim.dubbing.ledger import Outcome
from phonanim.dubbing.origin import is_current, origin_of
from phonanim.dubbing.spoken import align_line, aligned
from phonanim.errors import PhonanimError
from phonanim.exporters import save
from phonanim.files import content_hash


def make(job: Job) -> Result:
    """Animate a line and write its outputs, unless they are there already, made from the same things."""
    line = job.line
    try:
        origin = origin_of(line, job.formats)
        if job.known and is_current(job.known, origin, job.folder):
            return Result(replace(job.known, place=line.place), made=False)
        return Result(_made(job, origin), made=True)
    except PhonanimError as error:
        why = str(error)
    except OSError as error:
        why = f"{error.filename or line.alignment}: {error.strerror or error}"
    except Exception as error:  # a fault of phonanim costs its line, not the night's run
        why = f"{line.alignment}: a fault of phonanim, please report it: {type(error).__name__}: {error}"
    return Result(Outcome(line.id, line.place, error=why), made=True)


def _made(job: Job, origin: dict[str, Any]) -> Outcome:
    line = job.line
    outputs = {}
    alignment = aligned(line, job.folder)
    if line.text is not None:
        align_line(line, alignment)
        outputs[alignment.relative_to(job.folder).as_posix()] = content_hash(alignment)
    performance = perform(alignment, line.options, line.audio)
    for name in origin["outputs"]:
        path = job.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        save(performance.animation, path)
        outputs[name] = content_hash(path)
    return Outcome(line.id, line.place, origin, outputs, facts_of(performance, line.audio))
