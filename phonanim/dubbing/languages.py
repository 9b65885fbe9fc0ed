"""The languages of a batch: what the lines around a line are in decides where it cannot tell by itself."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from phonanim.dubbing.line import Line
from phonanim.dubbing.outcome import Outcome
from phonanim.speech.language_choice import SURE
from phonanim.speech.language_names import AUTO, is_auto

MOST = 0.75
"""Share of lines above which their language is expected of the others."""

MOST_EXPECTED = 12
"""Languages of a batch above which they tell nothing about a line."""

ROUNDS = 5
"""Rounds of estimating how many lines are in each language (expectation maximization)."""


def keep_expected(line: Line, known: Outcome | None) -> Line:
    """A line as it was made before, if another run decided on its language by all lines."""
    before = _read_as(known) if known else AUTO
    if line.options.language == AUTO and before != AUTO and is_auto(before):
        return replace(line, options=replace(line.options, language=before))
    return line


def is_open(outcome: Outcome) -> bool:
    """Whether the labels of a line do not tell its language, or did not when it was made before."""
    if not outcome.done:
        return False
    if _read_as(outcome) == AUTO:
        facts = _language(outcome)
        return not facts.get("sure", float(facts.get("certainty", 1.0)) >= SURE)
    return is_auto(_read_as(outcome))


def undecided_lines(lines: Iterable[Line], found: Mapping[str, Outcome]) -> Iterator[Line]:
    """Those of the open lines that must be made again, with the languages that are expected of them.

    The lines around a line decide: those of its folder, then those whose names begin or end alike, then all.
    Where these are in several languages, the line is in one of them, unless its labels tell otherwise.
    """
    lines = list(lines)
    if not lines:
        return
    groups: dict[str, list[Outcome]] = {}
    for outcome in found.values():
        for key in _groups_of(outcome.id):
            groups.setdefault(key, []).append(outcome)
    common = {key: _decided(group) for key, group in groups.items()}
    whole = common_language(found.values()) or "+".join(_sure_languages(found.values()))
    for line in lines:
        name = next(filter(None, (common[key] for key in _groups_of(line.id))), whole)
        wanted = f"{AUTO}:{name}" if name else AUTO
        if line.options.language == AUTO and _read_as(found[line.id]) != wanted:
            yield replace(line, options=replace(line.options, language=wanted))


def _groups_of(id: str) -> list[str]:
    """What a line shares with others: its folder, and the last and the first part of its name.

    A part ends at a dot, a hyphen or an underscore; numbers do not count, nor does a name of one part.
    """
    folder, _, name = id.rpartition("/")
    parts = re.split(r"[._\s-]+", name.lower())
    ends = [f"*{parts[-1]}", f"{parts[0]}*"] if len(parts) > 1 else []
    return [f"{folder}/"] * bool(folder) + [end for end in ends if not end.strip("*").isdigit()]


def _decided(outcomes: Sequence[Outcome]) -> str:
    """The common language of a group, if some line of it is sure of it."""
    name = common_language(outcomes)
    return name if name in _sure_languages(outcomes) else ""


def _sure_languages(outcomes: Iterable[Outcome]) -> list[str]:
    """The languages that some line is surely in, sorted; [] where they are too many to tell anything."""
    facts = [_language(outcome) for outcome in outcomes]
    sure = {
        str(one["name"]).partition(":")[0]
        for one in facts
        if max(one.get("candidates", {}).values(), default=0.0) >= SURE
    }
    return sorted(sure) if len(sure) <= MOST_EXPECTED else []


def common_language(outcomes: Iterable[Outcome]) -> str:
    """The language that most lines are in, by their labels; "" when there is none, or only one line."""
    told = [facts["candidates"] for facts in map(_language, outcomes) if facts.get("candidates")]
    if len(told) < 2:
        return ""
    weights = {name: 1.0 for shares in told for name in sorted(shares)}
    for _ in range(ROUNDS):
        weights = _reweighed(told, weights)
    best = max(sorted(weights), key=lambda name: weights[name])
    return best if weights[best] >= MOST else ""


def _reweighed(told: list[dict[str, float]], weights: dict[str, float]) -> dict[str, float]:
    """The share of each language in lines with these probabilities, weighed by the shares so far."""
    found = dict.fromkeys(weights, 0.0)
    for shares in told:
        weighed = {name: share * weights[name] for name, share in shares.items()}
        total = sum(weighed.values()) or 1.0
        for name, weight in weighed.items():
            found[name] += weight / total / len(told)
    return found


def _read_as(outcome: Outcome) -> str:
    """The option `language` that a line was made with."""
    return str(outcome.origin.get("options", {}).get("language", ""))


def _language(outcome: Outcome) -> Mapping[str, Any]:
    return outcome.facts.get("language") or {}
