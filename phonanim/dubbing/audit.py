"""Audit a delivery: find missing, outdated, motionless or mistimed lines, and files without a line."""

from __future__ import annotations

import multiprocessing
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from phonanim.animation.provenance import model_hash
from phonanim.core.threads import use_one_thread
from phonanim.dubbing.align_lines import alignment_place, sound_place
from phonanim.dubbing.ledger import read_ledger
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Lines, files_below, path_below
from phonanim.dubbing.motion import measure_motion, motion_problems
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.provenance import input_entry, keeps_stamps, output_hash, rig_hash, speaker_of
from phonanim.dubbing.reserve import OWN
from phonanim.dubbing.row import CORRECTIONS, EDITS
from phonanim.dubbing.staging import Copies
from phonanim.dubbing.storage import Place
from phonanim.errors import OptionError, PhonanimError
from phonanim.exporters import find_exporter, load, suffixes
from phonanim.inputs.speech_input import read_with_options
from phonanim.media.audio import audio_duration

FEW = 16  # lines that are not worth a process


@dataclass(frozen=True, slots=True)
class Finding:
    """Something wrong with a delivery: `problem` is missing, unreadable, stale, still, mistimed or orphan."""

    problem: str
    id: str
    language: str
    text: str


def audit(lines: Lines, folder: Place, workers: int = 1, verify: bool = False) -> list[Finding]:
    """Compare the lines with the files in `folder`, in the order of the lines, orphans last.

    Outputs that are as the ledger says are not read again, and files with the sizes and times of the ledger
    are as it says, unless `verify` is set. What has to be read is read by `workers` processes. Raises
    OptionError when there is no such folder.
    """
    if not folder.is_dir():
        raise OptionError(f"{folder}: there is no such folder; name the one with the outputs")
    ledger = read_ledger(folder)
    delivered = delivered_files(folder)
    findings = [
        Finding("missing", fault.id, fault.language, f"{fault.place}: {fault.message}")
        for fault in lines.faults
    ]
    questions = [
        Question(line, delivered.pop(str(line.output), []), ledger.get(line.id), folder, verify)
        for line in lines.lines
    ]
    findings += [finding for found in _answered(questions, workers) for finding in found]
    orphans = sorted(path_below(path, folder) for files in delivered.values() for path in files)
    return findings + [Finding("orphan", name, "", "no line has it") for name in orphans]


def count_problems(findings: Iterable[Finding]) -> dict[str, dict[str, int]]:
    """Number of problems of each kind for each language."""
    found: dict[str, Counter[str]] = {}
    for finding in findings:
        found.setdefault(finding.language, Counter())[finding.problem] += 1
    return {language: dict(sorted(problems.items())) for language, problems in sorted(found.items())}


def delivered_files(folder: Place) -> dict[str, list[Place]]:
    """The delivered files by their path without suffix, relative to the folder."""
    found: dict[str, list[Place]] = {}
    for path in files_below(folder):
        suffix = max((end for end in suffixes() if path.name.lower().endswith(end)), key=len, default="")
        name = path_below(path, folder)
        given = path.name.startswith(".") or name.endswith((EDITS, CORRECTIONS)) or name in OWN
        if suffix and path.is_file() and not given:
            found.setdefault(name[: -len(suffix)], []).append(path)
    return found


@dataclass(frozen=True, slots=True)
class Question:
    """A line to look over, its delivered files, its entry in the ledger, and whether to read all files."""

    line: Line
    files: list[Place]
    known: Outcome | None
    folder: Place
    verify: bool


def _answered(questions: list[Question], workers: int) -> Iterator[list[Finding]]:
    """The findings of each line, in order; workers answer where files have to be read."""
    slow = [question for question in questions if not _is_quick(question)]
    with ExitStack() as stack:
        read: Iterator[list[Finding]] = map(_findings, slow)
        if workers > 1 and len(slow) > FEW:
            use_one_thread()  # in the workers, which inherit it
            pool = stack.enter_context(ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")))
            read = pool.map(_findings, slow, chunksize=FEW)
        waiting = set(map(id, slow))
        for question in questions:
            yield next(read) if id(question) in waiting else _findings(question)


def _is_quick(question: Question) -> bool:
    """Whether the findings need no file."""
    known = question.known
    if not question.files:
        return True
    if known is None or not known.done or question.verify or not _remembers(known, question):
        return False
    return keeps_stamps(known, question.line, question.folder)


def _remembers(known: Outcome, question: Question) -> bool:
    """Whether the ledger has the motion of every delivered file."""
    return bool(known.motion) and set(question.files) <= {question.folder / name for name in known.outputs}


def _findings(question: Question) -> list[Finding]:
    """The findings of a line; the motion of files that did not change is in the ledger."""
    line, known, language = question.line, question.known, question.line.options.language
    if not question.files:
        return [Finding("missing", line.id, language, f"{question.folder / line.output}.*: does not exist")]
    changed = _changes(question)
    found = [Finding("stale", line.id, language, "; ".join(changed))] if changed else []
    for path in question.files:
        if not hasattr(find_exporter(Path(path.name)), "read"):
            continue
        if known is not None and known.done and not changed and _remembers(known, question):
            problems = [(problem, f"{path}: {text}") for problem, text in motion_problems(known.motion)]
        else:
            problems = _looked_at(line, path, *_places(line, question.folder))
        found += [Finding(problem, line.id, language, text) for problem, text in problems]
    return found


def _changes(question: Question) -> list[str]:
    """Changes since the outputs were made; by modification times if there is no ledger."""
    line, known, folder = question.line, question.known, question.folder
    if known is None or not known.done:
        return _newer(line, question.files)
    given = None if question.verify else known
    now = _now(line, known, given)
    changed = [f"{name} has changed" for name, value in now.items() if known.origin.get(name) != value]
    for name, digest in known.outputs.items():
        found = output_hash(name, folder, given)
        if found != digest:
            changed.append(f"{folder / name} {'was changed after it was made' if found else 'is gone'}")
    return changed


def _newer(line: Line, files: list[Place]) -> list[str]:
    """The sources that are newer than the outputs; shared storage gives no times."""
    made = [path.stat().st_mtime for path in files if isinstance(path, Path)]
    sources = [path for path in (line.alignment, line.audio) if isinstance(path, Path)]
    return [
        f"{path} is newer than what was made from it"
        for path in sources
        if made and path.stat().st_mtime > min(made)
    ]


def _now(line: Line, known: Outcome, given: Outcome | None) -> Mapping[str, object]:
    """The origin of a line as it would be now, with the options of the run that made it.

    Files with the stamps of `given` are not read.

    Only edits that the line itself names are included: a folder of edits is an option of the run. Corrections
    lie beside the outputs.
    """
    options = known.origin["options"]
    return {
        "alignment": input_entry(line, "alignment", given),
        "text": line.text,
        **speaker_of(line),
        "audio": input_entry(line, "audio", given),
        "model": model_hash(options["model"]),
        "rig": rig_hash(options["rig"]),
        **(
            {"rigs": {name: rig_hash(name) for name in known.origin["rigs"]}}
            if known.origin.get("rigs")
            else {}
        ),
        **{
            name: input_entry(line, name, given)
            for name in ("edits", "corrections")
            if getattr(line, name) or (name in known.origin and name == "corrections")
        },
    }


def _places(line: Line, folder: Place) -> tuple[Place, Place | None]:
    return alignment_place(line, folder), sound_place(line, folder)


def _looked_at(line: Line, path: Place, alignment: Place, sound: Place | None) -> list[tuple[str, str]]:
    """Problems of one file, which may be on shared storage."""
    with tempfile.TemporaryDirectory(prefix="phonanim-") as scratch:
        near = Copies(Path(scratch))
        audio = near.fetch(sound) if sound else None
        faults = list(_faults(line, near.fetch(path), near.fetch(alignment), audio))
        return [(problem, near.restore_urls(text)) for problem, text in faults]


def _faults(line: Line, path: Path, alignment_path: Path, audio: Path | None) -> Iterator[tuple[str, str]]:
    """Problems of one local file: (problem, text)."""
    try:
        animation = load(path)
        alignment = read_with_options(alignment_path, line.options, audio)
        seconds = audio_duration(audio) if audio else alignment.duration
    except PhonanimError as error:
        yield "unreadable", str(error)
        return
    for problem, text in motion_problems(measure_motion(animation, alignment.intervals, seconds)):
        yield problem, f"{path}: {text}"
