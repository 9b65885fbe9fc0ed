"""What is wrong with the lines of a run, by cause: many lines of one cause are one entry with an example."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from phonanim.dubbing.outcome import Outcome

SEEN = {"silence": 1.0, "closures": 0.9, "length": 0.6, "speed": 0.5, "language": 0.4, "labels": 0.3}
"""How likely the worst flag of a check is seen by a viewer, 0 to 1; set by eye."""

SHOWN = 5  # lines that a cause names
FAILED = "failed"
WHEN = re.compile(r" at [\d.]+ s( and \d+ more)?(?=:)")
OWN_FILE = re.compile(r"^(?:[/\\]|[A-Za-z]:[/\\]|\w+://)[^\n]*?: ")


@dataclass(frozen=True, slots=True)
class Cause:
    """A cause: its check (or "failed"), what it is, and the lines that have it, the worst first.

    `example` is what is said of the first line; `weight` is the sum of how likely each is seen.
    """

    check: str
    what: str
    ids: tuple[str, ...]
    places: tuple[str, ...]
    example: str
    weight: float

    def __str__(self) -> str:
        if len(self.ids) == 1:
            return f"{self.ids[0]}: {self.check}: {self.example}"
        if self.check == FAILED:
            return f"{len(self.ids)} lines failed: {self.what} ({_listed(self.places)})"
        what = "" if self.what == self.check else f" {self.what}"
        return f"{len(self.ids)} lines: {self.check}{what}, such as {self.ids[0]}: {self.example}"


def chance_seen(flag: Mapping[str, Any]) -> float:
    """How likely a viewer sees what a flag is about, 0 to 1."""
    return float(flag["severity"]) * SEEN.get(flag["check"], 1.0)


def find_causes(outcomes: Iterable[Outcome]) -> list[Cause]:
    """The causes of failures, the most frequent first, then those of flags, the most visible first."""
    found: dict[tuple[str, str], list[tuple[float, Outcome, str]]] = {}
    for outcome in outcomes:
        for check, what, text, weight in _troubles(outcome):
            found.setdefault((check, what), []).append((weight, outcome, text))
    causes = [_cause(check, what, items) for (check, what), items in found.items()]
    return sorted(causes, key=lambda cause: (cause.check != FAILED, -cause.weight, cause.check, cause.what))


def failure_reason(outcome: Outcome) -> str:
    """Why a line failed, without its own place and file, so that equal reasons are equal texts."""
    return OWN_FILE.sub("", outcome.error.removeprefix(f"{outcome.place}: "))


def _troubles(outcome: Outcome) -> Iterator[tuple[str, str, str, float]]:
    """Check, cause, text and weight of everything that is wrong with a line."""
    if not outcome.done:
        reason = failure_reason(outcome)
        yield FAILED, reason, outcome.error, 1.0
        return
    for flag in outcome.facts["flags"]:
        check, text = flag["check"], flag["text"]
        if check != "labels":
            yield check, check, text, chance_seen(flag)
            continue
        notes = text.split("; ")
        for note in notes:
            yield check, WHEN.sub("", note), note, chance_seen(flag) / len(notes)


def _cause(check: str, what: str, items: Sequence[tuple[float, Outcome, str]]) -> Cause:
    ordered = sorted(items, key=lambda item: -item[0])
    outcomes = [outcome for _, outcome, _ in ordered]
    return Cause(
        check,
        what,
        tuple(outcome.id for outcome in outcomes),
        tuple(outcome.place for outcome in outcomes),
        ordered[0][2],
        round(sum(weight for weight, *_ in items), 6),
    )


def _listed(places: Sequence[str]) -> str:
    """The places of lines; rows of one table share its name."""
    rows = [re.fullmatch(r"(.*) row (\d+)", place) for place in places]
    tables = {row[1] for row in rows if row}
    if all(rows) and len(tables) == 1:
        return f"{tables.pop()} rows {_ranges([int(row[2]) for row in rows if row])}"
    more = f" and {len(places) - SHOWN} more" if len(places) > SHOWN else ""
    return ", ".join(places[:SHOWN]) + more


def _ranges(numbers: list[int]) -> str:
    """Whole numbers as ranges: 2-4, 7, 9-12; a long list is cut."""
    spans: list[list[int]] = []
    for number in sorted(numbers):
        if spans and number == spans[-1][1] + 1:
            spans[-1][1] = number
        else:
            spans.append([number, number])
    texts = [str(first) if first == last else f"{first}-{last}" for first, last in spans]
    return ", ".join(texts[: 2 * SHOWN]) + (" ..." if len(texts) > 2 * SHOWN else "")
