"""A run: make every line of a source once, record it, and report."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import PurePosixPath

from phonanim.core.files import is_leftover
from phonanim.dubbing.job import Job, Result
from phonanim.dubbing.languages import is_open, keep_expected, undecided_lines
from phonanim.dubbing.ledger import NAME, ledger_writer, lock_folder, read_ledger, settle_ledger
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Lines
from phonanim.dubbing.make import reset_caches
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.provenance import is_current, is_unchanged, origin_of
from phonanim.dubbing.report import write_reports
from phonanim.dubbing.storage import Place, Remote
from phonanim.errors import OutputError, PhonanimError

Engine = Callable[[Iterable[Job]], Iterator[Result]]


def run(
    lines: Lines,
    folder: Place,
    formats: tuple[str, ...],
    engine: Engine,
    tell: Callable[[Result], None] = lambda result: None,
    verify: bool = False,
) -> list[Outcome]:
    """Make every line in `folder`, and return the outcomes in the order of the lines, faults last.

    A line whose files have the sizes and times that the ledger says is kept; `verify` reads them all.
    `tell` is called with the result of each line as it ends. The folder gets the outputs, ledger.jsonl,
    report.json, report.html and summary.txt. Raises OutputError when the folder cannot be written.
    """
    make_folder(folder)
    with lock_folder(folder):
        known = read_ledger(folder)
        remove_unfinished(folder, output_folders(lines, known.values()))
        found: dict[str, Outcome] = {}
        with ledger_writer(folder) as record:
            make = partial(chain_results, engine=engine, verify=verify)
            for result in _made(lines, folder, formats, make, known):
                found[result.outcome.id] = result.outcome
                if result.made:
                    record(result.outcome)
                tell(result)
        outcomes = [found[line.id] for line in lines.lines] + fault_outcomes(lines)
        settle_ledger(folder, known, found)
        write_reports(folder, outcomes, lines.notes)
    return outcomes


def _made(
    lines: Lines, folder: Place, formats: tuple[str, ...], make: Engine, known: dict[str, Outcome]
) -> Iterator[Result]:
    """The result of every line; lines whose language all of them decide come last."""
    held: dict[str, Result] = {}
    found: dict[str, Outcome] = {}
    for result in make(make_jobs(lines, folder, formats, known)):
        found[result.outcome.id] = result.outcome
        if is_open(result.outcome):
            held[result.outcome.id] = result
        else:
            yield result
    again = tuple(undecided_lines((line for line in lines.lines if line.id in held), found))
    if again:
        now = known | {line.id: found[line.id] for line in again}
        yield from make(make_jobs(replace(lines, lines=again), folder, formats, now))
    decided = {line.id for line in again}
    yield from (result for id, result in held.items() if id not in decided)


def make_jobs(
    lines: Lines, folder: Place, formats: tuple[str, ...], known: dict[str, Outcome]
) -> Iterator[Job]:
    """A job for each line, with its entry in the ledger."""
    run = secrets.token_hex(4)
    for line in lines.lines:
        before = known.get(line.id)
        yield Job(keep_expected(line, before), folder.absolute(), formats, before, run)


def chain_results(jobs: Iterable[Job], engine: Engine, verify: bool) -> Iterator[Result]:
    """The lines that are kept by their stamps, then those that the engine makes or keeps by content."""
    left = []
    for job in jobs:
        reset_caches(job.run)
        if not verify and job.known and is_unchanged(job.known, job.line, job.formats, job.folder):
            yield Result(placed(job.known, job.line), made=False)
        else:
            left.append(job)
    if left:
        yield from engine(iter(left))


def placed(known: Outcome, line: Line) -> Outcome:
    """The outcome of a line whose row or file may have moved."""
    return known if known.place == line.place else replace(known, place=line.place)


def fault_outcomes(lines: Lines) -> list[Outcome]:
    """The invalid rows, as outcomes."""
    return [Outcome(fault.id, fault.place, error=f"{fault.place}: {fault.message}") for fault in lines.faults]


def plan_run(lines: Lines, folder: Place, formats: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """What a run would do with each line: (id, "make" | "keep" | reason of a failure); writes nothing."""
    for job in make_jobs(lines, folder, formats, read_ledger(folder)):
        try:
            kept = is_unchanged(job.known, job.line, formats, folder) or (
                job.known and is_current(job.known, origin_of(job.line, formats), folder)
            )
            yield job.line.id, "keep" if kept else "make"
        except (PhonanimError, OSError) as error:
            yield job.line.id, str(error)


def make_folder(folder: Place) -> None:
    """Create the output folder and its parents; not needed on shared storage. Raises OutputError."""
    if isinstance(folder, Remote):
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be created: {error.strerror}") from error


def output_folders(lines: Lines, known: Iterable[Outcome]) -> set[PurePosixPath]:
    """The folders of the outputs of this run and of earlier ones, relative to the output folder."""
    below = {line.output.parent for line in lines.lines}
    below |= {PurePosixPath(text) for text in {name.rpartition("/")[0] for name in _output_names(known)}}
    return below | {above for folder in below for above in folder.parents}


def _output_names(known: Iterable[Outcome]) -> Iterator[str]:
    return (name for outcome in known for name in outcome.outputs)


def remove_unfinished(folder: Place, below: Iterable[PurePosixPath]) -> None:
    """Remove the unfinished files that a killed run left in its own folders.

    A subfolder with its own ledger belongs to another run. Shared storage has no such files, because objects
    are written whole.
    """
    if isinstance(folder, Remote):
        return
    for relative in sorted(below):
        places = [folder / above for above in (*reversed(relative.parents), relative)]
        if any(place.is_symlink() or (place / NAME).exists() for place in places[1:] if place != folder):
            continue
        if places[-1].is_dir():
            for path in filter(is_leftover, places[-1].iterdir()):
                path.unlink(missing_ok=True)
