"""Match the words of a text with those that were recognized: anchors first, then what lies between them."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Sequence

import numpy as np

RUN = 3  # words in a row that make an anchor, if they occur once in both
LARGEST = 1_000_000  # cells of the table of what lies between two anchors; more stays unmatched

Pairs = list[tuple[int, int]]
"""Places in the text and among the recognized words that are the same word, both rising."""


def match_words(text: Sequence[str], recognized: Sequence[str]) -> Pairs:
    """The words of a text that were recognized, in order.

    Runs of words that occur once in both are anchors (the longest series in which both rise); between two
    anchors, the longest common subsequence. Time and memory grow with the length, not with its square.
    """
    found: Pairs = []
    before = (0, 0)
    for anchor in [*_anchors(text, recognized), (len(text), len(recognized))]:
        (a, b), (c, d) = before, anchor
        if c > a and d > b:
            found += [(a + i, b + j) for i, j in _common(text[a:c], recognized[b:d])]
        if anchor[0] < len(text) and anchor[1] < len(recognized):
            found.append(anchor)
        before = (c + 1, d + 1)
    return found


def _anchors(text: Sequence[str], recognized: Sequence[str]) -> Pairs:
    """The places of the first words of runs that occur once in both, as far as both rise."""
    places = _once(text), _once(recognized)
    pairs = sorted((place, places[1][run]) for run, place in places[0].items() if run in places[1])
    tails: list[int] = []  # of the series of each length, the last place among the recognized words
    last: list[int] = []
    before: list[int] = []
    for number, (_, place) in enumerate(pairs):
        length = bisect_left(tails, place)
        before.append(last[length - 1] if length else -1)
        tails[length : length + 1] = [place]
        last[length : length + 1] = [number]
    series: Pairs = []
    number = last[-1] if last else -1
    while number >= 0:
        series.append(pairs[number])
        number = before[number]
    return series[::-1]


def _once(words: Sequence[str]) -> dict[tuple[str, ...], int]:
    runs = [tuple(words[n : n + RUN]) for n in range(len(words) - RUN + 1)]
    counts = Counter(runs)
    return {run: place for place, run in enumerate(runs) if counts[run] == 1}


def _common(a: Sequence[str], b: Sequence[str]) -> Pairs:
    """The longest common subsequence of two short series of words."""
    if len(a) * len(b) > LARGEST:
        return []
    table = np.zeros((len(a) + 1, len(b) + 1), np.int32)
    for i in range(len(a) - 1, -1, -1):
        for j in range(len(b) - 1, -1, -1):
            same = a[i] == b[j]
            table[i, j] = 1 + table[i + 1, j + 1] if same else max(table[i + 1, j], table[i, j + 1])
    found: Pairs = []
    i = j = 0
    while i < len(a) and j < len(b):
        if a[i] == b[j]:
            found.append((i, j))
            i, j = i + 1, j + 1
        elif table[i + 1, j] >= table[i, j + 1]:
            i += 1
        else:
            j += 1
    return found
