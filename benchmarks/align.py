"""Onset errors of `phonanim align` against other labels of the same recordings, and its speed.

    python benchmarks/align.py ../shared/data/textgrids

Takes every English WAV that has a TextGrid with words beside it (or the praatIO files, which are labelled
by hand). Each word of the reference is compared with the word of the same number in the alignment; each
phone onset of the reference with the nearest phone onset.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from phonanim.aligner import align
from phonanim.alignment import Alignment, Interval, read_alignment
from phonanim.audio import duration
from phonanim.errors import PhonanimError
from phonanim.labels import is_silent

NAMES = (
    "059_en_mary",
    "061_en_damon_set_test",
    "001_en_LJ001-0012",
    "002_en_LJ006-0114",
    "004_en_LJ030-0031",
)
HAND = ("059_en_mary", "061_en_damon_set_test")


def spoken(intervals: tuple[Interval, ...]) -> list[Interval]:
    return [interval for interval in intervals if not is_silent(interval.label)]


def word_errors(reference: Alignment, found: tuple[Interval, ...]) -> np.ndarray:
    """Milliseconds between the onsets of the same words; empty when the words are not the same."""
    words = spoken(reference.words)
    if len(words) != len(found):
        return np.zeros(0)
    return np.array([1000 * abs(a.start - b.start) for a, b in zip(words, found, strict=True)])


def phone_errors(reference: Alignment, found: tuple[Interval, ...]) -> np.ndarray:
    """Milliseconds from each phone onset of the reference to the nearest one found."""
    onsets = np.array([phone.start for phone in spoken(reference.intervals)])
    others = np.array([phone.start for phone in found])
    return 1000 * np.abs(np.subtract.outer(onsets, others)).min(axis=1)


def show(name: str, labels: str, words: np.ndarray, phones: np.ndarray, speed: float) -> None:
    told = [
        f"{np.median(e):6.0f} {np.percentile(e, 90):6.0f}" if len(e) else " " * 13 for e in (words, phones)
    ]
    print(f"{name:<24} {labels:<6} {told[0]}   {told[1]}   {speed:6.1f}")


def main(folder: Path) -> None:
    print("recording                labels   word onset ms   phone onset ms   x real time")
    print("                                  median  90 %    median  90 %")
    pooled: list[np.ndarray] = []
    for name in NAMES:
        reference = read_alignment(folder / f"{name}.TextGrid")
        text = " ".join(word.label for word in spoken(reference.words))
        started = time.perf_counter()
        try:
            found = align(folder / f"{name}.wav", text)
        except PhonanimError as error:
            print(f"{name:<24} {error}")
            continue
        speed = duration(folder / f"{name}.wav") / (time.perf_counter() - started)
        phones = phone_errors(reference, found.phones)
        pooled.append(phones)
        show(name, "hand" if name in HAND else "MFA", word_errors(reference, found.words), phones, speed)
    phones = np.concatenate(pooled)
    within = [100 * np.mean(phones <= limit) for limit in (20, 50)]
    print(f"phone onsets within 20 ms: {within[0]:.0f} %, within 50 ms: {within[1]:.0f} %")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
