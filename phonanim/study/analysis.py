"""Analyse judgements: wins and losses by majority, preferences, ratings, and their confidence."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from phonanim.evaluation.statistics import bootstrap_interval, holm, mean_rows, sign_test
from phonanim.study.results import Participant
from phonanim.study.tally import Tally, chosen_system, order_systems, test_answers

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Comparison:
    """One pair. A line is won when most of its judgements are for `ours` (Taylor 2017, section 8.3).

    `preference` is the share of decided judgements that are for `ours`; its interval comes from resampling
    lines. `p_lines` and `p_judgements` are two-sided exact sign tests; `p_holm` is `p_lines` corrected for
    the number of pairs in the group. Judgements of one line or one person are not independent, so use
    `p_lines`.
    """

    group: str
    ours: str
    other: str
    lines: int
    won: int
    lost: int
    drawn: int
    judgements: int
    neither: int
    preference: float
    interval: Interval
    p_lines: float
    p_judgements: float
    p_holm: float


@dataclass(frozen=True, slots=True)
class Rating:
    """Mean stars of a system in one pair when it was chosen; the interval is by resampling participants."""

    ours: str
    other: str
    system: str
    ratings: int
    mean: float
    interval: Interval


def compare_systems(tallies: Sequence[Tally], rng: np.random.Generator) -> tuple[Comparison, ...]:
    """One comparison for each group and pair, in the order of the tallies."""
    pairs: dict[tuple[str, str, str], list[Tally]] = defaultdict(list)
    for tally in tallies:
        pairs[tally.group, tally.ours, tally.other].append(tally)
    found = [_comparison(key, lines, rng) for key, lines in pairs.items()]
    corrected: dict[tuple[str, str, str], float] = {}
    for group in {one.group for one in found}:
        members = [one for one in found if one.group == group]
        adjusted = holm([one.p_lines for one in members])
        corrected |= {(group, one.ours, one.other): p for one, p in zip(members, adjusted, strict=True)}
    return tuple(replace(one, p_holm=corrected[one.group, one.ours, one.other]) for one in found)


def _comparison(key: tuple[str, str, str], lines: Sequence[Tally], rng: np.random.Generator) -> Comparison:
    wins = np.array([line.wins for line in lines])
    losses = np.array([line.losses for line in lines])
    won, lost = int((wins > losses).sum()), int((wins < losses).sum())
    decided = int(wins.sum() + losses.sum())
    rows = np.column_stack([wins, wins + losses]).astype(float)
    unknown = (float("nan"), float("nan"))
    return Comparison(
        *key,
        lines=len(lines),
        won=won,
        lost=lost,
        drawn=len(lines) - won - lost,
        judgements=decided,
        neither=sum(line.neither for line in lines),
        preference=float(wins.sum() / decided) if decided else float("nan"),
        interval=bootstrap_interval(rows, rng) if decided else unknown,
        p_lines=sign_test(won, lost),
        p_judgements=sign_test(int(wins.sum()), int(losses.sum())),
        p_holm=1.0,
    )


def rate_systems(
    participants: Sequence[Participant], rng: np.random.Generator, ours: str | None = None
) -> tuple[Rating, ...]:
    """The ratings of each system in each pair when it was chosen."""
    stars: dict[tuple[str, str, str], list[tuple[int, int]]] = defaultdict(list)
    for number, participant in enumerate(participants):
        for answer in test_answers([participant]):
            if chosen_system(answer) and answer.rating is not None:
                first, second = order_systems(answer, ours)
                stars[first, second, chosen_system(answer)].append((number, answer.rating))
    return tuple(_rating(key, np.array(given), rng) for key, given in sorted(stars.items()))


def _rating(key: tuple[str, str, str], given: NDArray[np.int64], rng: np.random.Generator) -> Rating:
    """`given` is (ratings, 2): participant and stars."""
    rows = mean_rows(given[:, 1].astype(float))
    sums = np.stack([np.bincount(given[:, 0], weights=column) for column in rows.T], axis=1).astype(float)
    sums = sums[sums[:, 1] > 0]
    return Rating(*key, len(given), float(given[:, 1].mean()), bootstrap_interval(sums, rng))
