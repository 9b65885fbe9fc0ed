"""Distances between sequences: letters of words, visemes, words of sentences."""

from __future__ import annotations

from collections.abc import Hashable, Sequence


def edit_distance(predicted: Sequence[Hashable], reference: Sequence[Hashable]) -> int:
    """The fewest insertions, deletions and substitutions that turn one sequence into the other.

    Divided by the length of the reference it is an error rate: of words WER, of characters CER. It exceeds 1
    where a long sequence is predicted for a short one. Source: Levenshtein 1966.
    """
    row = list(range(len(reference) + 1))
    for number, mine in enumerate(predicted, 1):
        corner, row[0] = row[0], number
        for place, other in enumerate(reference, 1):
            corner, row[place] = row[place], min(row[place] + 1, row[place - 1] + 1, corner + (mine != other))
    return row[-1]
