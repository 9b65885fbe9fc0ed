"""What each stretch of a recording may say: words of the text, words that were recognized, or either.

Recognized words are matched with the text. Between two matched words either the text is right or the
recognizer is: both become alternatives, and the sound decides. Passages that only one of the two has are left
out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from phonanim.aligners._matching import match_words
from phonanim.aligners._network import Slot

DOUBTED = 3  # words of the text where nothing was recognized that may be said nevertheless
ASIDE = 8  # words in a row that the text lacks, from which they are left out
FASTEST = 6.0  # words a second
PAUSE = 2.0  # seconds without words from which stretches are aligned apart
EDGE = 0.6  # seconds around the words of a stretch


@dataclass(frozen=True, slots=True)
class Said:
    """A recognized word, in lower case: its window, begin and end in seconds, and its probability."""

    word: str
    window: int
    start: float
    end: float
    probability: float


@dataclass(frozen=True, slots=True)
class Choice:
    """Places of words in the text and among those recognized: either is said, or both where `sure`."""

    text: tuple[int, ...]
    recognized: tuple[int, ...]
    sure: bool = False


@dataclass
class Stretch:
    """A part of a window, from `start` to `end` seconds of the recording, and what it may say."""

    window: int
    start: float
    end: float
    choices: list[Choice] = field(default_factory=list)


@dataclass
class Plan:
    """Stretches in order, places of words of the text that are in none, and runs that the text lacks."""

    stretches: list[Stretch] = field(default_factory=list)
    lost: list[int] = field(default_factory=list)
    asides: list[tuple[int, ...]] = field(default_factory=list)
    share: float = 0.0


def plan_stretches(text: Sequence[str], said: Sequence[Said]) -> Plan:
    """Where the words of a text may be, by the recognized words. `share` is that of the text recognized."""
    pairs = match_words(text, [one.word for one in said])
    plan = Plan(share=len(pairs) / max(len(text), 1))
    before = (-1, -1)
    for i, j in [*pairs, (len(text), len(said))]:
        words, recognized = range(before[0] + 1, i), range(before[1] + 1, j)
        for choice in _between(words, recognized, said):
            _add(plan, choice, said)
        if i < len(text):
            _add(plan, Choice((i,), (j,), sure=True), said)
        before = (i, j)
    plan.stretches = [one for one in plan.stretches if any(choice.text for choice in one.choices)]
    return plan


def slot_of(choice: Choice, text: Sequence[str], said: Sequence[Said]) -> Slot:
    """The alternatives of a choice."""
    if choice.sure:
        return (tuple(text[i] for i in choice.text),)
    return tuple(
        dict.fromkeys((tuple(text[i] for i in choice.text), tuple(said[j].word for j in choice.recognized)))
    )


def _between(words: range, recognized: range, said: Sequence[Said]) -> Iterator[Choice]:
    """The choices between two words that match; those of words recognized apart from each other are apart."""
    groups: list[list[int]] = []
    for j in recognized:
        if groups and not _apart(said[j - 1], said[j]):
            groups[-1].append(j)
        else:
            groups.append([j])
    if not groups:
        yield from [Choice(tuple(words), ())] * bool(words)
        return
    done = 0
    for number, group in enumerate(groups, 1):
        last = (
            len(words)
            if number == len(groups)
            else len(words) * (group[-1] + 1 - recognized[0]) // len(recognized)
        )
        yield Choice(tuple(words[done:last]), tuple(group))
        done = last


def _apart(one: Said, two: Said) -> bool:
    return one.window != two.window or two.start - one.end > PAUSE


def _add(plan: Plan, choice: Choice, said: Sequence[Said]) -> None:
    """Put a choice into the last stretch, or a new one; or leave it out."""
    text, recognized = choice.text, choice.recognized
    if not recognized:
        if len(text) > DOUBTED or not plan.stretches:
            plan.lost += text
        else:
            plan.stretches[-1].choices.append(choice)
        return
    first, last = said[recognized[0]], said[recognized[-1]]
    if len(recognized) >= ASIDE and 2 * len(text) < len(recognized):
        plan.asides.append(recognized)
        plan.lost += text
        return
    if len(text) > DOUBTED and len(text) > FASTEST * (last.end - first.start + EDGE):
        plan.lost += text
        choice = Choice((), recognized)
    open_one = plan.stretches[-1] if plan.stretches else None
    before = said[recognized[0] - 1] if recognized[0] else None
    aside = bool(plan.asides) and plan.asides[-1][-1] == recognized[0] - 1
    if open_one is None or before is None or aside or _apart(before, first):
        start = max(first.start - EDGE, before.end if before and before.window == first.window else 0.0)
        open_one = Stretch(first.window, start, last.end)
        plan.stretches.append(open_one)
    open_one.choices.append(choice)
    after = said[recognized[-1] + 1] if recognized[-1] + 1 < len(said) else None
    follows = after is not None and after.window == last.window
    open_one.end = min(last.end + EDGE, after.start if follows and after else last.end + EDGE)
