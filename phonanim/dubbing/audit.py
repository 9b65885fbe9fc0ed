"""Audit a delivery: find missing, outdated, motionless or mistimed lines, and files without a line."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.dubbing.align_lines import alignment_place
from phonanim.dubbing.ledger import read_ledger
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Lines, files_below, path_below
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.provenance import file_entry, output_hash, rig_hash
from phonanim.dubbing.reserve import OWN
from phonanim.dubbing.staging import Copies
from phonanim.dubbing.storage import Place
from phonanim.errors import OptionError, PhonanimError
from phonanim.exporters import find_exporter, load, suffixes
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import audio_duration
from phonanim.pipeline import model_hash
from phonanim.speech.labels import is_silent

STILL = 0.01  # of a control's range: less motion is not seen
TOLERANCE = 0.15  # seconds between the end of a line and the end of its animation


@dataclass(frozen=True, slots=True)
class Finding:
    """Something wrong with a delivery: `problem` is missing, unreadable, stale, still, mistimed or orphan."""

    problem: str
    id: str
    language: str
    text: str


def audit(lines: Lines, folder: Place) -> list[Finding]:
    """Compare the lines with the files in `folder`, in the order of the lines, orphans last.

    Raises OptionError when there is no such folder.
    """
    if not folder.is_dir():
        raise OptionError(f"{folder}: there is no such folder; name the one with the outputs")
    ledger = read_ledger(folder)
    delivered = delivered_files(folder)
    findings = [
        Finding("missing", fault.id, fault.language, f"{fault.place}: {fault.message}")
        for fault in lines.faults
    ]
    for line in lines.lines:
        files = delivered.pop(str(line.output), [])
        findings += _findings(line, files, ledger.get(line.id), folder)
    orphans = sorted(str(path_below(path, folder)) for files in delivered.values() for path in files)
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
        name = str(path_below(path, folder))
        if suffix and path.is_file() and not path.name.startswith(".") and name not in OWN:
            found.setdefault(name[: -len(suffix)], []).append(path)
    return found


def _findings(line: Line, files: list[Place], known: Outcome | None, folder: Place) -> Iterator[Finding]:
    language = line.options.language
    if not files:
        yield Finding("missing", line.id, language, f"{folder / line.output}.*: does not exist")
        return
    changed = _changes(line, files, known, folder)
    if changed:
        yield Finding("stale", line.id, language, "; ".join(changed))
    for path in files:
        if hasattr(find_exporter(Path(path.name)), "read"):
            for problem, text in _looked_at(line, path, alignment_place(line, folder)):
                yield Finding(problem, line.id, language, text)


def _changes(line: Line, files: list[Place], known: Outcome | None, folder: Place) -> list[str]:
    """Changes since the outputs were made; by modification times if there is no ledger."""
    if known is None or not known.done:
        return _newer(line, files)
    changed = [
        f"{name} has changed" for name, value in _now(line, known).items() if known.origin.get(name) != value
    ]
    for name, digest in known.outputs.items():
        found = output_hash(folder / name)
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


def _now(line: Line, known: Outcome) -> Mapping[str, object]:
    """The origin of a line as it would be now, with the options of the run that made it.

    Only edits that the line itself names are included: a folder of edits is an option of the run.
    """
    options = known.origin["options"]
    return {
        "alignment": file_entry(line.alignment),
        "text": line.text,
        "audio": file_entry(line.audio),
        "model": model_hash(options["model"]),
        "rig": rig_hash(options["rig"]),
        **({"edits": file_entry(line.edits)} if line.edits else {}),
    }


def _looked_at(line: Line, path: Place, alignment: Place) -> list[tuple[str, str]]:
    """Problems of one file, which may be on shared storage."""
    with tempfile.TemporaryDirectory(prefix="phonanim-") as scratch:
        near = Copies(Path(scratch))
        audio = near.fetch(line.audio) if line.audio else None
        faults = list(_faults(line, near.fetch(path), near.fetch(alignment), audio))
        return [(problem, near.restore_urls(text)) for problem, text in faults]


def _faults(line: Line, path: Path, alignment_path: Path, audio: Path | None) -> Iterator[tuple[str, str]]:
    """Problems of one local file: (problem, text)."""
    try:
        animation = load(path)
        alignment = read_alignment(
            alignment_path, line.options.tier, line.options.speaker, line.options.lexicon
        )
        seconds = audio_duration(audio) if audio else alignment.duration
    except PhonanimError as error:
        yield "unreadable", str(error)
        return
    if _still(animation) and not all(is_silent(interval.label) for interval in alignment.intervals):
        yield "still", f"{path}: nothing moves, but the line speaks"
    end = (len(animation.values) - 1) / animation.fps
    if abs(end - seconds) > TOLERANCE:
        yield "mistimed", f"{path}: ends at {end:.2f} s, the line at {seconds:.2f} s"


def _still(animation: Animation) -> bool:
    return bool(np.ptp(animation.values, axis=0).max(initial=0.0) < STILL)
