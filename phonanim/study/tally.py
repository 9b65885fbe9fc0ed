"""Count judgements: for each line, how many prefer the one system and how many the other."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from phonanim.core.decode import DecodeError, read_utf8
from phonanim.core.tables import MAX_TABLE, parse_rows, to_records
from phonanim.errors import StudyError
from phonanim.study.results import SIDES, Answer, Participant

COLUMNS = ("group", "ours", "other", "item", "for", "against")


@dataclass(frozen=True, slots=True)
class Tally:
    """The judgements of one line and pair: for `ours`, against it, and for neither."""

    group: str
    ours: str
    other: str
    item: str
    wins: int
    losses: int
    neither: int = 0


def count_answers(participants: Sequence[Participant], ours: str | None = None) -> tuple[Tally, ...]:
    """The test answers, counted by pair and line. `ours`, else the first by name, is the first of each pair.

    If several questions were asked about a pair, the answers to each are a group of their own.

    Raises StudyError when `ours` was in no test.
    """
    questions = (participants[0].questions if participants else ()) or ("",)
    votes: dict[tuple[int, str, str, str], Counter[str]] = defaultdict(Counter)
    for answer in test_answers(participants):
        first, second = order_systems(answer, ours)
        for number, choice in enumerate(answer.choices or (answer.choice,)):
            votes[number, first, second, answer.item][chosen_system(answer, choice)] += 1
    if ours and not any(ours in pair for pair in votes):
        raise StudyError(f"there is no system {ours!r}; there are {', '.join(_systems(votes))}")
    return tuple(
        Tally(questions[number], first, second, item, found[first], found[second], found[""])
        for (number, first, second, item), found in sorted(votes.items())
    )


def test_answers(participants: Iterable[Participant]) -> list[Answer]:
    """The answers to test trials, without practice and controls."""
    return [answer for one in participants for answer in one.answers if answer.kind == "test"]


def chosen_system(answer: Answer, choice: str = "") -> str:
    """The system of a choice, or of the answer to the first question; empty for neither."""
    choice = choice or answer.choice
    return {"left": answer.left, "right": answer.right}[choice] if choice in SIDES else ""


def order_systems(answer: Answer, ours: str | None) -> tuple[str, str]:
    """The two systems, `ours` first, else by name."""
    first, second = sorted((answer.left, answer.right), key=lambda name: (name != ours, name))
    return first, second


def read_counts(path: Path) -> tuple[Tally, ...]:
    """Published counts: a CSV with the columns group, ours, other, item, for and against.

    Lines that begin with # are comments. Raises StudyError, which names the damaged row.
    """
    try:
        lines = read_utf8(path, MAX_TABLE).removeprefix("\ufeff").splitlines()
        kept = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
        rows = [parse_rows(line)[0] for _, line in kept]
        numbers = [number for number, _ in kept]
        records = [(numbers[place - 1], row) for place, row in to_records(rows, COLUMNS)]
    except (OSError, DecodeError) as error:
        raise StudyError(f"{path}: cannot be read: {error}") from error
    tallies = tuple(_tally(path, number, row) for number, row in records)
    if not tallies:
        raise StudyError(f"{path}: has no counts; give it one row per line and pair")
    return tallies


def _tally(path: Path, number: int, row: Mapping[str, str]) -> Tally:
    counts = row["for"].strip(), row["against"].strip()
    if not all(re.fullmatch("[0-9]{1,9}", count) for count in counts):
        raise StudyError(f"{path} row {number}: 'for' and 'against' must be whole numbers from 0")
    return Tally(row["group"], row["ours"], row["other"], row["item"], *map(int, counts))


def _systems(pairs: Iterable[tuple[int, str, str, str]]) -> list[str]:
    return sorted({system for _, first, second, _ in pairs for system in (first, second)})
