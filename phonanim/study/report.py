"""The analysis of a study as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from phonanim.study.analysis import Comparison, Interval, Rating
from phonanim.study.results import Exclusion

PREFERENCES = (
    "pair", "lines", "W / L", "drawn", "judgements", "neither", "preference", "95 %",
    "p (lines)", "p (Holm)", "p (judgements)",
)  # fmt: skip
RATINGS = ("pair", "chosen", "ratings", "mean stars", "95 %")


def markdown(
    comparisons: Sequence[Comparison], ratings: Sequence[Rating], excluded: Sequence[Exclusion], kept: int
) -> str:
    """Tables of preferences by group, of ratings, and of excluded participants."""
    parts = []
    for group in dict.fromkeys(one.group for one in comparisons):
        members = [one for one in comparisons if one.group == group]
        parts += [f"**{group}**\n" if group else "", _table(PREFERENCES, map(_preference, members))]
    if ratings:
        parts.append(_table(RATINGS, map(_rating, ratings)))
    if kept or excluded:
        parts.append(f"{kept} participants; left out: {len(excluded)}")
        parts += [f"- {one.name}: {one.reason}" for one in excluded]
    return "\n".join(part for part in parts if part)


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---", *["---:"] * (len(header) - 1)], *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _preference(one: Comparison) -> tuple[str, ...]:
    return (
        f"{one.ours} vs {one.other}",
        str(one.lines),
        f"{one.won} / {one.lost}",
        str(one.drawn),
        str(one.judgements),
        str(one.neither),
        f"{100 * one.preference:.1f} %",
        _interval(one.interval, 100, 1),
        *(f"{p:.2g}" for p in (one.p_lines, one.p_holm, one.p_judgements)),
    )


def _rating(one: Rating) -> tuple[str, ...]:
    pair = f"{one.ours} vs {one.other}"
    return pair, one.system, str(one.ratings), f"{one.mean:.2f}", _interval(one.interval, 1, 2)


def _interval(interval: Interval, scale: float, digits: int) -> str:
    low, high = interval
    return f"{scale * low:.{digits}f} to {scale * high:.{digits}f}"
