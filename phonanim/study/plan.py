"""Plan the trials of a study: for practice, for control, and for the test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from phonanim.errors import StudyError
from phonanim.study.takes import Line, systems_of

CHOICES = ("forced", "none", "equal")
WRONG = "wrong"  # the system name of a take with the sound of another line


@dataclass(frozen=True, slots=True)
class Take:
    """A video to watch and one to listen to; they differ in takes that are obviously wrong."""

    system: str
    picture: Path
    sound: Path


@dataclass(frozen=True, slots=True)
class Trial:
    """Two takes of a line. `expected` is the answer of attentive people: take 0 or 1, "none", or anything."""

    item: str
    kind: str
    takes: tuple[Take, Take]
    expected: int | str | None = None


def plan_trials(
    lines: Sequence[Line],
    rng: np.random.Generator,
    choices: str = "forced",
    ours: str | None = None,
    practice: int = 3,
    controls: int = 3,
) -> tuple[Trial, ...]:
    """Every pair of systems on every test line, after the practice trials and before the controls.

    With `ours`, only pairs with that system. Practice lines are those that are marked as such, or `practice`
    lines drawn at random, which are then not in the test. A control shows one of these lines with the sound
    of another next to the correct take; if "none" is a possible answer, it shows two such takes (Medina 2023,
    section 4.8). Raises StudyError when there are too few lines.
    """
    systems = systems_of(lines)
    pairs = _pairs(systems, ours)
    trained, tested = _split(lines, practice, rng)
    spare = trained if len(trained) > 1 else tested
    if not tested or (controls and len(spare) < 2):
        raise StudyError(
            f"{len(lines)} lines are too few for {practice} practice trials and {controls} controls; "
            "give more lines, or fewer --practice and --controls"
        )
    drawn = [pairs[index] for index in rng.integers(len(pairs), size=len(trained))]
    return (
        *(_plain(line, pair, "practice") for line, pair in zip(trained, drawn, strict=True)),
        *(_plain(line, pair, "test") for line in tested for pair in pairs),
        *_controls(spare, systems, controls, choices),
    )


def _pairs(systems: Sequence[str], ours: str | None) -> list[tuple[str, str]]:
    if ours is None:
        return list(combinations(systems, 2))
    if ours not in systems:
        raise StudyError(f"there is no system {ours!r}; there are {', '.join(systems)}")
    return [(ours, other) for other in systems if other != ours]


def _split(lines: Sequence[Line], practice: int, rng: np.random.Generator) -> tuple[list[Line], list[Line]]:
    """Lines for practice, and lines for the test."""
    marked = [line for line in lines if line.kind == "practice"]
    if not marked:
        drawn = rng.permutation(len(lines))[:practice]
        marked = [lines[index] for index in sorted(drawn)]
    return marked, [line for line in lines if line not in marked]


def _plain(line: Line, pair: tuple[str, str], kind: str) -> Trial:
    first, second = (Take(system, line.films[system], line.films[system]) for system in pair)
    return Trial(line.item, kind, (first, second))


def _controls(lines: Sequence[Line], systems: Sequence[str], count: int, choices: str) -> Iterator[Trial]:
    for number in range(count):
        line, other = lines[number % len(lines)], lines[(number + 1) % len(lines)]
        system, next_system = systems[number % len(systems)], systems[(number + 1) % len(systems)]
        right = Take(system, line.films[system], line.films[system])
        wrong = Take(WRONG, line.films[system], other.films[system])
        also_wrong = Take(WRONG, line.films[next_system], other.films[next_system])
        if choices == "none":
            yield Trial(line.item, "control", (wrong, also_wrong), "none")
        else:
            yield Trial(line.item, "control", (right, wrong), 0)
