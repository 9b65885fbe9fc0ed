"""The language of a batch: what most of its lines are in decides where a line by itself cannot tell."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from phonanim.dubbing.line import Line
from phonanim.dubbing.outcome import Outcome
from phonanim.speech.language_choice import SURE
from phonanim.speech.language_names import AUTO, is_auto

MOST = 0.75
"""Share of lines above which their language is expected of the others."""

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
        return float(_language(outcome).get("certainty", 1.0)) < SURE
    return is_auto(_read_as(outcome))


def undecided_lines(lines: Iterable[Line], found: Mapping[str, Outcome]) -> Iterator[Line]:
    """Those of the open lines that must be made again, with the language that is expected of them."""
    lines = list(lines)
    if not lines:
        return
    name = common_language(found.values())
    wanted = f"{AUTO}:{name}" if name else AUTO
    for line in lines:
        if line.options.language == AUTO and _read_as(found[line.id]) != wanted:
            yield replace(line, options=replace(line.options, language=wanted))


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
