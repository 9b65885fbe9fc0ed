"""Make one line: the work of a worker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from phonanim import __version__
from phonanim.animate import model_hash, perform, rig_hash
from phonanim.dubbing.checks import facts_of
from phonanim.dubbing.job import Job, Result
from phonanim.dubbing.ledger import Outcome
from phonanim.dubbing.lines import Line
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
        return Result(Outcome(line.id, line.place, error=str(error)), made=True)
    except OSError as error:
        message = f"{error.filename or line.alignment}: {error.strerror or error}"
        return Result(Outcome(line.id, line.place, error=message), made=True)


def origin_of(line: Line, formats: tuple[str, ...]) -> dict[str, Any]:
    """Everything that the outputs depend on: contents, options, model, rig, version, names."""
    return {
        "alignment": [line.alignment.name, content_hash(line.alignment)],
        "audio": [str(line.audio), content_hash(line.audio)] if line.audio else None,
        "options": asdict(line.options),
        "model": model_hash(line.options.model),
        "rig": rig_hash(line.options.rig),
        "version": __version__,
        "outputs": [f"{line.output}.{suffix}" for suffix in formats],
    }


def is_current(known: Outcome, origin: Mapping[str, Any], folder: Path) -> bool:
    """Whether the outputs in the ledger were made from the same things and are there unchanged."""
    if not known.done or known.origin != origin:
        return False
    files = {folder / name: digest for name, digest in known.outputs.items()}
    return all(path.is_file() and content_hash(path) == digest for path, digest in files.items())


def _made(job: Job, origin: dict[str, Any]) -> Outcome:
    line = job.line
    performance = perform(line.alignment, line.options, line.audio)
    outputs = {}
    for name in origin["outputs"]:
        path = job.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        save(performance.animation, path)
        outputs[name] = content_hash(path)
    return Outcome(line.id, line.place, origin, outputs, facts_of(performance, line.audio))
