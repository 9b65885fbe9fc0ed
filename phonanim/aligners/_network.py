"""Networks of words: what a stretch of speech may say, and which of it was found.

A stretch is a series of slots, each with alternatives: runs of words, of which one is said. The empty run
means that a slot may be skipped.
"""

from __future__ import annotations

from collections.abc import Sequence

Run = tuple[str, ...]
Slot = tuple[Run, ...]
Transition = tuple[int, int, float, str]

SILENCE = "<sil>"
FIRST = 0.95  # probability of the first of two alternatives


def transitions_of(slots: Sequence[Slot]) -> tuple[int, list[Transition]]:
    """The last state of a finite-state grammar that begins at state 0, and (from, to, probability, word)."""
    found: list[Transition] = []
    sources, states = [0], 1
    for slot in slots:
        runs = [run for run in slot if run]
        inner = sum(len(run) - 1 for run in runs)
        end, free = states + inner, iter(range(states, states + inner))
        states = end + 1
        for run in runs:
            froms = sources
            chance = 1.0 if len(slot) == 1 else FIRST if run == slot[0] else 1.0 - FIRST
            for number, word in enumerate(run):
                to = end if number == len(run) - 1 else next(free)
                found += [(state, to, chance if number == 0 else 1.0, word) for state in froms]
                froms = [to]
        sources = [end, *sources] if () in slot else [end]
    if len(sources) == 1:
        return sources[0], found
    return states, found + [(state, states, 1.0, SILENCE) for state in sources]


def choices_of(slots: Sequence[Slot], words: Sequence[str]) -> list[Run] | None:
    """The run of each slot that words say, the first that fits; None where they are not of the slots."""
    fits = [[False] * (len(words) + 1) for _ in range(len(slots) + 1)]
    fits[-1][-1] = True
    for place in range(len(slots) - 1, -1, -1):
        for at in range(len(words) + 1):
            fits[place][at] = any(
                tuple(words[at : at + len(run)]) == run and fits[place + 1][at + len(run)]
                for run in slots[place]
                if at + len(run) <= len(words)
            )
    if not fits[0][0]:
        return None
    chosen: list[Run] = []
    at = 0
    for place, slot in enumerate(slots):
        run = next(
            run
            for run in slot
            if at + len(run) <= len(words)
            and tuple(words[at : at + len(run)]) == run
            and fits[place + 1][at + len(run)]
        )
        chosen.append(run)
        at += len(run)
    return chosen
