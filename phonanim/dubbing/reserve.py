"""Assign output files to lines: no file twice, and none of the report, the ledger or the inputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import PurePosixPath

from phonanim.dubbing import decisions, ledger, ledger_parts
from phonanim.dubbing.align_lines import made_suffixes
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Fault, Lines
from phonanim.dubbing.output_names import collision_key
from phonanim.dubbing.report import FILES
from phonanim.dubbing.storage import Place

RUN = "run.json"  # how the run was called
OWN = (
    *FILES,
    RUN,
    ledger.NAME,
    ledger_parts.FOLDER,
    *decisions.FILES,
)
"""The files that a run writes besides those of the lines."""


def reserve_outputs(lines: Lines, folder: Place, formats: Sequence[str]) -> Lines:
    """The lines with unique outputs; every other line is a fault. The first line of an output is kept."""
    files = {collision_key(PurePosixPath(name)): "the run itself" for name in OWN}
    folders: dict[str, str] = {}
    target = folder.absolute()
    places = {
        str(place)
        for line in lines.lines
        for place in (line.alignment, line.audio, line.edits, line.corrections)
        if place
    }
    inputs = {place for place in places if place.startswith(str(target))}
    kept: list[Line] = []
    faults: list[Fault] = []
    for line in lines.lines:
        names = output_files(line, formats)
        problem = next(_problems(names, files, folders, inputs, target), "")
        if problem:
            faults.append(Fault(line.id, line.place, problem, line.options.language))
            continue
        kept.append(line)
        for name in names:
            files[collision_key(name)] = line.place
            folders |= dict.fromkeys(_folders(name.parent), line.place)
    return replace(lines, lines=tuple(kept), faults=(*lines.faults, *faults))


def output_files(line: Line, formats: Sequence[str]) -> list[PurePosixPath]:
    """The output files of a line, relative to the output folder."""
    suffixes = [f".{suffix}" for suffix in formats] + list(made_suffixes(line))
    return [PurePosixPath(f"{line.output}{suffix}") for suffix in suffixes]


@lru_cache(maxsize=1024)
def _folders(folder: PurePosixPath) -> list[str]:
    """The keys of a folder and of those above it, without that of the output folder."""
    return [collision_key(one) for one in (folder, *folder.parents) if one.name]


def _problems(
    names: Sequence[PurePosixPath],
    files: dict[str, str],
    folders: dict[str, str],
    inputs: set[str],
    folder: Place,
) -> Iterator[str]:
    mend = "give the line another id or output"
    for name in names:
        key = collision_key(name)
        taken = files.get(key) or folders.get(key)
        taken = taken or next((files[above] for above in _folders(name.parent) if above in files), None)
        if taken:
            yield f"the output {str(name)!r} is already used by {taken}; {mend}"
        if inputs and str(folder / name) in inputs:
            yield f"the output {str(name)!r} would overwrite an input; {mend}, or name another folder"
