"""Look over a delivery: which lines are missing, stale, still or mistimed, and which files belong to none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from phonanim.alignment import read_alignment
from phonanim.animate import model_hash
from phonanim.animation import Animation
from phonanim.audio import duration
from phonanim.dubbing.ledger import Outcome, read_ledger
from phonanim.dubbing.lines import Line, Lines
from phonanim.dubbing.origin import rig_hash
from phonanim.dubbing.spoken import aligned
from phonanim.errors import PhonanimError
from phonanim.exporters import find_exporter, load, suffixes
from phonanim.files import content_hash
from phonanim.labels import is_silent

OWN = ("report.json", "report.html", "summary.txt", "ledger.jsonl")
STILL = 0.01  # of a control's range: less motion is not seen
TOLERANCE = 0.15  # seconds between the end of a line and the end of its animation


@dataclass(frozen=True, slots=True)
class Finding:
    """Something wrong with a delivery: `problem` is missing, unreadable, stale, still, mistimed or orphan."""

    problem: str
    id: str
    language: str
    text: str


def audit(lines: Lines, folder: Path) -> list[Finding]:
    """Compare the lines with what lies in `folder`, in the order of the lines, orphans last."""
    ledger = read_ledger(folder)
    delivered = files_of(folder)
    findings = [Finding("missing", fault.id, "", f"{fault.place}: {fault.message}") for fault in lines.faults]
    for line in lines.lines:
        files = delivered.pop(str(line.output), [])
        findings += _findings(line, files, ledger.get(line.id), folder)
    orphans = sorted(path for files in delivered.values() for path in files)
    return findings + [
        Finding("orphan", str(path.relative_to(folder)), "", "no line has it") for path in orphans
    ]


def counts(findings: Iterable[Finding]) -> dict[str, dict[str, int]]:
    """How many problems of each kind each language has."""
    found: dict[str, Counter[str]] = {}
    for finding in findings:
        found.setdefault(finding.language, Counter())[finding.problem] += 1
    return {language: dict(sorted(problems.items())) for language, problems in sorted(found.items())}


def files_of(folder: Path) -> dict[str, list[Path]]:
    """The delivered files by their path without suffix, relative to the folder."""
    found: dict[str, list[Path]] = {}
    for path in sorted(folder.rglob("*")):
        suffix = max((end for end in suffixes() if path.name.lower().endswith(end)), key=len, default="")
        name = path.relative_to(folder).as_posix()
        if suffix and path.is_file() and not path.name.startswith(".") and name not in OWN:
            found.setdefault(name[: -len(suffix)], []).append(path)
    return found


def _findings(line: Line, files: list[Path], known: Outcome | None, folder: Path) -> Iterator[Finding]:
    language = line.options.language
    if not files:
        yield Finding("missing", line.id, language, f"{folder / line.output}.*: does not exist")
        return
    changed = _changes(line, files, known, folder)
    if changed:
        yield Finding("stale", line.id, language, "; ".join(changed))
    for path in files:
        if not hasattr(find_exporter(path), "read"):
            continue
        for problem, text in _faults(line, path, aligned(line, folder)):
            yield Finding(problem, line.id, language, text)


def _changes(line: Line, files: list[Path], known: Outcome | None, folder: Path) -> list[str]:
    """What is not as it was when the outputs were made; by times where no ledger tells."""
    if known is None or not known.done:
        made = min(path.stat().st_mtime for path in files)
        newer = [path for path in (line.alignment, line.audio) if path and path.stat().st_mtime > made]
        return [f"{path} is newer than what was made from it" for path in newer]
    changed = [
        f"{name} has changed" for name, value in _now(line, known).items() if known.origin.get(name) != value
    ]
    for name, digest in known.outputs.items():
        path = folder / name
        if not path.is_file():
            changed.append(f"{path} is gone")
        elif content_hash(path) != digest:
            changed.append(f"{path} was changed after it was made")
    return changed


def _now(line: Line, known: Outcome) -> Mapping[str, object]:
    """The origin of a line as it would be now, with the options that it was made with."""
    options = known.origin["options"]
    return {
        "alignment": [line.alignment.name, content_hash(line.alignment)],
        "text": line.text,
        "audio": [line.audio.name, content_hash(line.audio)] if line.audio else None,
        "model": model_hash(options["model"]),
        "rig": rig_hash(options["rig"]),
    }


def _faults(line: Line, path: Path, alignment_path: Path) -> Iterator[tuple[str, str]]:
    """What is wrong with one file: (problem, text)."""
    try:
        animation = load(path)
        alignment = read_alignment(
            alignment_path, line.options.tier, line.options.speaker, line.options.lexicon
        )
        seconds = duration(line.audio) if line.audio else alignment.duration
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
