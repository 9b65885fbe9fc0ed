"""How sure each word of an alignment is: how well its phones fit the sound, beside other phones.

The network that recognizes phones tells how well each phone fits each instant. A word is doubtful where its
phones fit less than those of the recording usually do, where random phones would fit as well, beside such
words, where a phone lasts very long, or beside sound that has no words. A logistic regression (Cox 1958),
learned from texts with words left out, added and exchanged (`benchmarks/align_confidence.py`), makes of
it the probability that the word is said there.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners._windows import quiet_windows
from phonanim.aligners.pocketsphinx import SpeechAlignment
from phonanim.core.lexicon import LEXICON
from phonanim.media.audio import level, resample
from phonanim.recognition.scores import phone_misfits, random_phones
from phonanim.recognition.spectrum import RATE, STEP
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.doubts import doubts
from phonanim.speech.language import to_phones

Array = NDArray[np.float64]

WORST = 5.0  # nats from which a phone does not fit at all
NEAR = 2  # steps by which a phone may be early or late
LONG, LONGER = 30.0, 60.0  # steps from which a phone is long, and from which it is not longer
SHORT = 3.0  # phones of a word whose fit counts half
OTHERS = 64  # random words beside which a word is judged
AROUND = 11  # steps over which sound is looked for
QUIETER = 30.0  # decibels below loud steps from which a step is quiet
HEARD = 1.0  # nats by which silence fits less than something else, where there is sound
SPEECH = 0.3  # seconds of sound between words that are speech without words
TABLE = LEXICON / "word_confidence.csv"
FEATURES = ("fit", "rank", "usual", "beside", "around", "speech", "long")


@dataclass(frozen=True, slots=True)
class Judged:
    """Features of words (words, FEATURES), and the longest sound before, between and after them.

    `sound` (words + 1, 2) is its begin and end in seconds.
    """

    features: Array
    sound: Array

    @property
    def gaps(self) -> Array:
        """Seconds of sound before, between and after words, (words + 1,)."""
        return np.asarray(self.sound[:, 1] - self.sound[:, 0])


def with_confidence(found: SpeechAlignment, audio: Path, language: str) -> SpeechAlignment:
    """An alignment with the confidence of each word, and a note on what is doubtful.

    `language` is that of the labels. Raises AudioError.
    """
    weights = read_weights("english" if language == "english" else "other")
    told: list[Interval] = []
    for begin, sound in quiet_windows(audio):
        end = begin + sound.duration
        words = [word for word in found.words if begin <= (word.start + word.end) / 2 < end]
        if not words:
            continue
        phones = [one for one in found.phones if words[0].start - 1e-6 <= one.start < words[-1].end - 1e-6]
        samples = level(resample(sound.samples, sound.rate, RATE))
        judged = judge(samples, _earlier(words, begin), _earlier(phones, begin), language)
        sure = 1 / (1 + np.exp(weights[0] + judged.features @ weights[1:]))
        told += _told(words, sure, judged.sound + begin)
    told = list(_apart(told, found.words))
    return replace(found, confidence=tuple(told), notes=(*found.notes, *doubts(found.words, told)))


def _apart(told: Sequence[Interval], words: Sequence[Interval]) -> Iterator[Interval]:
    """The same, with sound only where no word of another window is."""
    spoken = {(word.start, word.end) for word in words}
    ordered = sorted(told, key=lambda one: one.start)
    for place, one in enumerate(ordered):
        if (one.start, one.end) not in spoken:
            begin = max(one.start, max((before.end for before in ordered[:place][-2:]), default=0.0))
            after = ordered[place + 1].start if place + 1 < len(ordered) else one.end
            one = replace(one, start=begin, end=min(one.end, after))
            if one.end - one.start < SPEECH:
                continue
        yield one


def _earlier(intervals: Sequence[Interval], by: float) -> list[Interval]:
    return [replace(one, start=max(one.start - by, 0.0), end=one.end - by) for one in intervals]


def _told(words: Sequence[Interval], sure: Array, sound: Array) -> Iterator[Interval]:
    """The confidence of words, and 0 for long sound between them, (words + 1, 2)."""
    for number, (begin, end) in enumerate(sound.tolist()):
        if end - begin >= SPEECH:
            yield Interval("0.00", begin, end)
        if number < len(words):
            yield Interval(f"{sure[number]:.2f}", words[number].start, words[number].end)


def judge(
    samples: NDArray[np.float32], words: Sequence[Interval], phones: Sequence[Interval], language: str
) -> Judged:
    """What the confidence of the words of samples (n,) at RATE is made of."""
    prices = np.minimum(phone_misfits(samples), WORST).astype(np.float64)
    duration = len(prices) * STEP
    track, _ = to_phones(Alignment(tuple(phones), duration, "", ""), language, unknown="nearest")
    codes = track.sample(np.arange(len(prices), dtype=np.float64) * STEP)
    around = np.stack([np.roll(prices, by, axis=0) for by in range(-NEAR, NEAR + 1)]).min(axis=0)
    near = around[np.arange(len(prices)), codes]
    rows, counts = [], []
    for word in words:
        first = min(round(word.start / STEP), len(prices) - 1)
        last = min(max(round(word.end / STEP), first + 1), len(prices))
        inside = (track.bounds[:-1] < word.end - 1e-6) & (track.bounds[1:] > word.start + 1e-6)
        inside &= track.codes > 0
        said = np.asarray(track.codes[inside], np.int64) if inside.any() else np.array([1])
        lengths = (track.bounds[1:] - track.bounds[:-1])[inside]
        rank = _rank(prices[max(first - NEAR, 0) : last + NEAR], said)
        rows.append((near[first:last].mean(), np.log(rank + 0.02), lengths.max(initial=0.0) / STEP))
        counts.append(len(said))
    fit, rank, longest = np.array(rows).T
    sound = _sound((prices[:, 0] > HEARD) & _loud(samples, len(prices)), words)
    sound = np.minimum(sound, len(samples) // round(STEP * RATE) * STEP)
    return Judged(_features(fit, rank, longest, np.array(counts), sound[:, 1] - sound[:, 0]), sound)


def _features(fit: Array, rank: Array, longest: Array, counts: NDArray[np.int64], gaps: Array) -> Array:
    """One row for each word, one column for each of FEATURES."""
    usual = float(np.median(np.repeat(fit, counts)))
    weight = counts / (counts + SHORT)
    beside = np.minimum(np.maximum(gaps[:-1], gaps[1:]), 1.0)
    long = np.clip((longest - LONG) / LONG, 0, (LONGER + LONG) / LONG - 1)
    own = fit - usual
    columns = (own * weight, rank * weight, np.full(len(fit), usual), _around(own, counts, 1))
    return np.stack([*columns, _around(own, counts, 2), beside, long], axis=1)


def _around(values: Array, counts: NDArray[np.int64], reach: int) -> Array:
    """The mean of the neighbours of each word, by their phones."""
    found = np.zeros(len(values))
    for place in range(len(values)):
        near = [n for n in range(place - reach, place + reach + 1) if n != place and 0 <= n < len(values)]
        if near:
            found[place] = np.average(values[near], weights=counts[near])
    return found


def _loud(samples: NDArray[np.float32], steps: int) -> NDArray[np.bool_]:
    """Whether each step is not much quieter than the loud ones, (steps,)."""
    hop = round(STEP * RATE)
    padded = np.pad(samples, (0, max(0, steps * hop - len(samples))))[: steps * hop]
    power = (padded.reshape(steps, hop) ** 2).mean(axis=1)
    return np.asarray(power > np.percentile(power, 95) * 10 ** (-QUIETER / 10))


def _sound(heard: NDArray[np.bool_], words: Sequence[Interval]) -> Array:
    """Begin and end in seconds of the longest sound before, between and after words, (words + 1, 2)."""
    heard = np.convolve(heard, np.ones(AROUND) / AROUND, "same") > 0.5
    begins = [0, *(math.ceil(word.end / STEP) for word in words)]  # so that no sound overlaps a word
    ends = [*(math.floor(word.start / STEP) for word in words), len(heard)]
    return STEP * np.array([_longest(heard, a, max(a, b)) for a, b in zip(begins, ends, strict=True)])


def _longest(heard: NDArray[np.bool_], first: int, last: int) -> tuple[int, int]:
    """The longest run of steps that are heard between two steps."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], heard[first:last].astype(np.int8), [0]])))
    runs = [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
    begin, end = max(runs, key=lambda run: run[1] - run[0], default=(0, 0))
    return first + begin, first + end


def _rank(prices: Array, said: NDArray[np.int64]) -> float:
    """The share of random words of as many phones that fit steps (steps, phones) at least as well."""
    words = np.vstack([said, random_phones(len(said), OTHERS)])
    if len(prices) < len(said):
        return 1.0
    best = np.full(words.shape, np.inf)
    best[:, 0] = prices[0][words[:, 0]]
    for row in prices[1:]:
        before = np.concatenate([np.full((len(words), 1), np.inf), best[:, :-1]], axis=1)
        best = np.minimum(best, before) + row[words]
    return float((best[1:, -1] <= best[0, -1]).mean())


@cache
def read_weights(column: str) -> Array:
    """The constant and the weight of each of FEATURES, for labels of pocketsphinx (english) or others."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = {row["feature"]: float(row[column]) for row in csv.DictReader(file)}
    return np.array([rows[name] for name in ("constant", *FEATURES)])
