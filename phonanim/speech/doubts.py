"""How sure the words of an alignment are: a tier of numbers, and notes on stretches that are doubtful."""

from __future__ import annotations

import re
from collections.abc import Sequence

from phonanim.speech.intervals import Interval, Recording

TIER = "confidence"
DOUBTFUL = 0.6  # confidence below which a word is doubtful
TOGETHER = 0.35  # seconds between doubtful words that are told as one stretch
MOST_SHOWN = 5
_NUMBER = re.compile(r"[01](?:\.\d+)?")


def doubts(words: Sequence[Interval], confidence: Sequence[Interval]) -> tuple[str, ...]:
    """A note on the stretches of low confidence, whose labels are numbers from 0 to 1; () without any."""
    stretches: list[list[Interval]] = []
    for one in confidence:
        if float(one.label) >= DOUBTFUL:
            continue
        if stretches and one.start - stretches[-1][-1].end < TOGETHER:
            stretches[-1].append(one)
        else:
            stretches.append([one])
    if not stretches:
        return ()
    shown = ", ".join(_shown(stretch, words) for stretch in stretches[:MOST_SHOWN])
    more = f" and {len(stretches) - MOST_SHOWN} more" if len(stretches) > MOST_SHOWN else ""
    return (f"doubtful, check the text there: {shown}{more}",)


def doubtful_time(confidence: Sequence[Interval]) -> float:
    """Seconds of words and of sound that are doubtful."""
    return sum(one.end - one.start for one in confidence if float(one.label) < DOUBTFUL)


def recorded_doubts(recording: Recording) -> tuple[str, ...]:
    """The same of a file that has a tier of confidence; () where that has something else than numbers."""
    tiers = {tier.name: tier.intervals for tier in recording.tiers}
    numbers = [one for one in tiers.get(TIER, ()) if one.label.strip()]
    if not all(_NUMBER.fullmatch(one.label.strip()) for one in numbers):
        return ()
    return doubts(tiers.get("words", ()), numbers)


def _shown(stretch: Sequence[Interval], words: Sequence[Interval]) -> str:
    begin, end = stretch[0].start, stretch[-1].end
    said = [
        word.label for word in words if word.start < end - 1e-6 and word.end > begin + 1e-6 and word.label
    ]
    sure = sum(float(one.label) for one in stretch) / len(stretch)
    what = f"{' '.join(said)!r}, {sure:.0%} sure" if said else "sound without words of the text"
    return f"{begin:.1f} to {end:.1f} s ({what})"
