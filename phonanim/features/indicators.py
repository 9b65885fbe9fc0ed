"""The 2379 linguistic indicator features of Taylor 2017, supplement section 1.

Columns, in this order, for the published input window of 11 frames (Kx) with the centre frame c = 5; other
windows have the same groups of other sizes:

| group     | columns | set where                                                        |
|-----------|---------|------------------------------------------------------------------|
| span      | 1558    | phone p fills frames i..i+k: k = 0, 1, 2, 3; then i; then p      |
| attribute | 660     | the phone at frame i is of class j: i; then j                    |
| consonant | 1       | a consonant in frames c-5..c-2 or c+2..c+5                       |
| cv        | 20      | frames i, i+1 are in cluster j of the consonant-vowel pairs      |
| vc        | 30      | the same for vowel-consonant pairs                               |
| cc        | 30      | the same for consonant-consonant pairs                           |
| starts    | 50      | a consonant at i, a vowel that starts with a, e, i, o, u at i+1  |
| ends      | 30      | a consonant at i, a vowel that ends with h, w, y at i+1          |
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.inventory import INVENTORY, N_ATTRIBUTES, N_PHONES

WIDTH = 11  # Kx
SPANS = 4
NEAREST, FARTHEST = 2, 5  # frames from the centre, where a consonant is looked for
CV_CLUSTERS, VC_CLUSTERS, CC_CLUSTERS = 2, 3, 3
STARTS = tuple(f"Vowel starting with /{letter}/" for letter in "aeiou")
ENDS = tuple(f"Vowel ending with /{letter}/" for letter in "hwy")

VOWEL = INVENTORY.where(kind="vowel")
CONSONANT = INVENTORY.where(kind="consonant")


@dataclass(frozen=True)
class SparseRows:
    """Indicator rows as the columns that are 1: row r has `columns[starts[r]:starts[r + 1]]`."""

    columns: NDArray[np.int32]
    starts: NDArray[np.int64]
    n_features: int

    def __len__(self) -> int:
        return len(self.starts) - 1

    def dense(self) -> NDArray[np.float32]:
        """(frames, features) of zeros and ones."""
        full = np.zeros((len(self), self.n_features), np.float32)
        full[np.repeat(np.arange(len(self)), np.diff(self.starts)), self.columns] = 1
        return full


@cache
def groups(width: int = WIDTH) -> dict[str, range]:
    """The columns of each group for windows of `width` frames (Kx)."""
    pairs = width - 1
    sizes = {
        "span": N_PHONES * sum(max(width - k, 0) for k in range(SPANS)),
        "attribute": N_ATTRIBUTES * width,
        "consonant": 1,
        "cv": pairs * CV_CLUSTERS,
        "vc": pairs * VC_CLUSTERS,
        "cc": pairs * CC_CLUSTERS,
        "starts": pairs * len(STARTS),
        "ends": pairs * len(ENDS),
    }
    ends = np.cumsum([0, *sizes.values()]).tolist()
    return {name: range(*between) for name, between in zip(sizes, pairwise(ends), strict=True)}


def n_indicators(width: int = WIDTH) -> int:
    """The number of columns of `indicators` for windows of `width` frames (Kx): 2379 for 11."""
    return sum(len(columns) for columns in groups(width).values())


def raw_indicators(codes: NDArray[np.uint8]) -> SparseRows:
    """One-hot phones per frame, (frames, Kx) codes -> 41 x Kx columns: raw features (section 5.2)."""
    width = codes.shape[1]
    columns = codes + np.arange(width, dtype=np.int32) * N_PHONES
    return SparseRows(columns.ravel().astype(np.int32), np.arange(len(codes) + 1) * width, N_PHONES * width)


def indicators(codes: NDArray[np.uint8], clusters: NDArray[np.int8]) -> SparseRows:
    """All indicators of windows of phone codes, (frames, Kx) -> 2379 columns for a Kx of 11.

    `clusters` (41, 41) int8 is the data-driven cluster of each pair of phones, -1 for a pair that is not in
    the training data. The phones give the kind of the pair (cv, vc or cc). Raises ValueError for codes that
    are not windows.
    """
    if codes.ndim != 2 or not codes.shape[1]:
        raise ValueError(f"expected windows (frames, Kx) of phone codes, got {codes.shape}")
    found = [
        _spans(codes),
        _attributes(codes),
        _consonants(codes),
        _pairs(codes, clusters),
    ]
    rows = np.concatenate([rows for rows, _ in found])
    columns = np.concatenate([columns for _, columns in found])
    order = np.lexsort((columns, rows))
    starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=len(codes)))])
    return SparseRows(columns[order].astype(np.int32), starts, n_indicators(codes.shape[1]))


Found = tuple[NDArray[np.int64], NDArray[np.int64]]


def _spans(codes: NDArray[np.uint8]) -> Found:
    width = codes.shape[1]
    rows, columns, base = [], [], groups(width)["span"].start
    same = np.ones_like(codes, dtype=bool)
    for k in range(min(SPANS, width)):
        places = width - k
        if k:
            same = same[:, :places] & (codes[:, :places] == codes[:, k:])
        row, place = np.nonzero(same[:, :places])
        rows.append(row)
        columns.append(base + place * N_PHONES + codes[row, place])
        base += places * N_PHONES
    return np.concatenate(rows), np.concatenate(columns)


def _attributes(codes: NDArray[np.uint8]) -> Found:
    row, place, kind = np.nonzero(INVENTORY.attributes[codes])
    return row, groups(codes.shape[1])["attribute"].start + place * N_ATTRIBUTES + kind


def _consonants(codes: NDArray[np.uint8]) -> Found:
    is_consonant = CONSONANT[codes]
    apart = np.abs(np.arange(codes.shape[1]) - codes.shape[1] // 2)  # frames from the centre
    row = np.flatnonzero(is_consonant[:, (apart >= NEAREST) & (apart <= FARTHEST)].any(axis=1))
    return row, np.full(len(row), groups(codes.shape[1])["consonant"].start)


def _pairs(codes: NDArray[np.uint8], clusters: NDArray[np.int8]) -> Found:
    first, second = codes[:, :-1], codes[:, 1:]
    cluster = clusters[first, second].astype(np.int64)
    kinds = (
        ("cv", CONSONANT, VOWEL, CV_CLUSTERS),
        ("vc", VOWEL, CONSONANT, VC_CLUSTERS),
        ("cc", CONSONANT, CONSONANT, CC_CLUSTERS),
    )
    found, columns = [], groups(codes.shape[1])
    for name, before, after, size in kinds:
        row, place = np.nonzero(before[first] & after[second] & (cluster >= 0))
        found.append((row, columns[name].start + place * size + cluster[row, place]))
    for name, classes in (("starts", STARTS), ("ends", ENDS)):
        members = np.stack([INVENTORY.attribute(kind) for kind in classes], axis=1)
        row, place, kind = np.nonzero(CONSONANT[first][:, :, None] & members[second])
        found.append((row, columns[name].start + place * len(classes) + kind))
    return np.concatenate([row for row, _ in found]), np.concatenate([column for _, column in found])
