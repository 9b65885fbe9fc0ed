"""The 2379 linguistic indicator features of Taylor 2017, supplement section 1.

Columns, in this order, for an input window of 11 frames with the centre frame c = 5:

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

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.inventory import INVENTORY, N_ATTRIBUTES, N_PHONES

WIDTH = 11  # Kx
SPANS = 4
CV_CLUSTERS, VC_CLUSTERS, CC_CLUSTERS = 2, 3, 3
STARTS = tuple(f"Vowel starting with /{letter}/" for letter in "aeiou")
ENDS = tuple(f"Vowel ending with /{letter}/" for letter in "hwy")

GROUPS = {
    "span": N_PHONES * sum(WIDTH - k for k in range(SPANS)),
    "attribute": N_ATTRIBUTES * WIDTH,
    "consonant": 1,
    "cv": (WIDTH - 1) * CV_CLUSTERS,
    "vc": (WIDTH - 1) * VC_CLUSTERS,
    "cc": (WIDTH - 1) * CC_CLUSTERS,
    "starts": (WIDTH - 1) * len(STARTS),
    "ends": (WIDTH - 1) * len(ENDS),
}
N_FEATURES = sum(GROUPS.values())
OFFSETS = dict(zip(GROUPS, np.cumsum([0, *GROUPS.values()])[:-1].tolist(), strict=True))

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


def windows_of_codes(codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Check windows of phone codes, (frames, 11), and return them. Raises ValueError for another width."""
    if codes.ndim != 2 or codes.shape[1] != WIDTH:
        raise ValueError(f"expected windows (frames, {WIDTH}) of phone codes, got {codes.shape}")
    return codes


def raw_indicators(codes: NDArray[np.uint8]) -> SparseRows:
    """One-hot phones per frame, (frames, Kx) codes -> 41 x Kx columns: raw features (section 5.2)."""
    width = codes.shape[1]
    columns = codes + np.arange(width, dtype=np.int32) * N_PHONES
    return SparseRows(columns.ravel().astype(np.int32), np.arange(len(codes) + 1) * width, N_PHONES * width)


def indicators(codes: NDArray[np.uint8], clusters: NDArray[np.int8]) -> SparseRows:
    """All 2379 indicators of windows of phone codes, (frames, 11) -> 2379 columns.

    `clusters` (41, 41) int8 is the data-driven cluster of each pair of phones, -1 for a pair that is not in
    the training data (see `phonanim.transitions`). The phones give the kind of the pair (cv, vc or cc).
    """
    found = [
        _spans(windows_of_codes(codes)),
        _attributes(codes),
        _consonants(codes),
        _pairs(codes, clusters),
    ]
    rows = np.concatenate([rows for rows, _ in found])
    columns = np.concatenate([columns for _, columns in found])
    order = np.lexsort((columns, rows))
    starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=len(codes)))])
    return SparseRows(columns[order].astype(np.int32), starts, N_FEATURES)


Found = tuple[NDArray[np.int64], NDArray[np.int64]]


def _spans(codes: NDArray[np.uint8]) -> Found:
    rows, columns, base = [], [], OFFSETS["span"]
    same = np.ones_like(codes, dtype=bool)
    for k in range(SPANS):
        places = WIDTH - k
        if k:
            same = same[:, :places] & (codes[:, :places] == codes[:, k:])
        row, place = np.nonzero(same[:, :places])
        rows.append(row)
        columns.append(base + place * N_PHONES + codes[row, place])
        base += places * N_PHONES
    return np.concatenate(rows), np.concatenate(columns)


def _attributes(codes: NDArray[np.uint8]) -> Found:
    row, place, kind = np.nonzero(INVENTORY.attributes[codes])
    return row, OFFSETS["attribute"] + place * N_ATTRIBUTES + kind


def _consonants(codes: NDArray[np.uint8]) -> Found:
    is_consonant = CONSONANT[codes]
    row = np.flatnonzero(is_consonant[:, :4].any(axis=1) | is_consonant[:, 7:].any(axis=1))
    return row, np.full(len(row), OFFSETS["consonant"])


def _pairs(codes: NDArray[np.uint8], clusters: NDArray[np.int8]) -> Found:
    first, second = codes[:, :-1], codes[:, 1:]
    cluster = clusters[first, second].astype(np.int64)
    kinds = (
        ("cv", CONSONANT, VOWEL, CV_CLUSTERS),
        ("vc", VOWEL, CONSONANT, VC_CLUSTERS),
        ("cc", CONSONANT, CONSONANT, CC_CLUSTERS),
    )
    found = []
    for name, before, after, size in kinds:
        row, place = np.nonzero(before[first] & after[second] & (cluster >= 0))
        found.append((row, OFFSETS[name] + place * size + cluster[row, place]))
    for name, classes in (("starts", STARTS), ("ends", ENDS)):
        members = np.stack([INVENTORY.attribute(kind) for kind in classes], axis=1)
        row, place, kind = np.nonzero(CONSONANT[first][:, :, None] & members[second])
        found.append((row, OFFSETS[name] + place * len(classes) + kind))
    return np.concatenate([row for row, _ in found]), np.concatenate([column for _, column in found])
