"""Align a long recording in any language: a coarse path first, then each group of sentences by itself.

eSpeak NG speaks the text sentence by sentence. Dynamic time warping of cepstra in steps of 80 ms finds
where in the recording each sentence lies. The path keeps to a band around the line on which speech goes
on evenly in both, so that memory grows with the length, not with its square; between two sentences it may
wait, through music or noise. Then groups of sentences are warped as short recordings are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners._windows import quiet_windows
from phonanim.aligners.espeak import SpokenText, speak
from phonanim.aligners.pocketsphinx import SpeechAlignment
from phonanim.aligners.warping import DOUBTFUL, RATE, phones_along, warp, words_along
from phonanim.core.files import concatenate_pieces
from phonanim.errors import AlignmentError, PhonanimError
from phonanim.media.audio import Sound, level, resample
from phonanim.media.mel import mel_filters, power_spectra
from phonanim.speech.alignment import Interval

Floats = NDArray[np.float32]

HOP, WINDOW, BANDS, CEPSTRA = 160, 400, 26, 12  # samples: 10 ms and 25 ms
BLOCK = 8  # frames: 80 ms
CHUNK = 60 * RATE  # samples that are analysed at once
FLOOR = 1e-7
LOUDNESS = 1.0  # weight of the level beside the cepstra
STEPS = (0.35, 0.0, 0.2, 0.6)  # price of staying, and of going on by 1, 2, 3 blocks
WAITING, RESTING = 0.3, 1.2  # price of a block without speech, and of any other, between two words
MODULATED = 0.05  # deviation of the level over a second, of its range, below which a sound is no speech
BAND = 120.0  # seconds to either side of the even line
LONGEST_SENTENCE = 25  # words
GROUP = 12.0  # seconds of made speech from which sentences are aligned together
APART = 0.5  # seconds between sentences from which they are aligned apart
WAITED = 1.0  # seconds for which the path waits between two words, from which they are aligned apart
EDGE = 0.1  # seconds of silence around a part of a sentence
REACH = 1.0  # seconds around a cut within which the quietest place is looked for
SHORTEST = 0.3  # seconds of a piece


@dataclass(frozen=True)
class _Blocks:
    """Of each block of 80 ms: cepstra (blocks, 12) normalized in speech, level 0 to 1, and speech."""

    cepstra: Floats
    level: Floats
    speech: NDArray[np.bool_]


def align_in_parts(audio: Path, text: str, voice: str) -> SpeechAlignment:
    """Find the words and phones (IPA) of `text`, spoken in the language of `voice`, in a long recording.

    Notes tell the stretches that are doubtful. Raises AlignmentError when nothing is found, AudioError when
    the recording cannot be read or is silent, OptionError, MissingExtraError.
    """
    pieces = (resample(sound.samples, sound.rate, RATE) for _, sound in quiet_windows(audio))
    samples = level(concatenate_pieces(pieces))
    spoken = [speak(sentence, voice) for sentence in _sentences(text)]
    if not spoken:
        raise AlignmentError(f"{audio}: the text has no words; give the words of the recording")
    groups = _groups(*_places(samples, spoken))
    words: list[Interval] = []
    phones: list[Interval] = []
    doubtful: list[str] = []
    for group, (begin, end) in groups:
        shown = f"{begin / RATE:.1f} to {end / RATE:.1f} s"
        try:
            path, share = warp(Sound(samples[begin:end], RATE), group)
        except PhonanimError:
            doubtful.append(f"{shown} (left out)")
            continue
        words += _moved(words_along(group, path), begin)
        phones += _moved(phones_along(group, path), begin)
        if share > DOUBTFUL:
            doubtful.append(f"{shown} (in reverse order its words fit {1 / share:.0%} as well)")
    if not words:
        raise AlignmentError(f"{audio}: the text cannot be found in the audio; check that they match")
    notes = (f"doubtful: {', '.join(doubtful)}",) if doubtful else ()
    return SpeechAlignment(tuple(words), tuple(phones), len(samples) / RATE, notes)


def _sentences(text: str) -> Iterator[str]:
    """Parts of a text that end at a full stop or after some words."""
    for part in re.split(r"(?<=[.!?;:。！？])\s*|\n+", text):
        words = part.split()
        for n in range(0, len(words), LONGEST_SENTENCE):
            if any(c.isalnum() for c in "".join(words[n : n + LONGEST_SENTENCE])):
                yield " ".join(words[n : n + LONGEST_SENTENCE])


def _groups(
    spoken: Sequence[SpokenText], bounds: Sequence[tuple[int, int]]
) -> list[tuple[SpokenText, tuple[int, int]]]:
    """Sentences and where they lie, those joined that follow each other, until they are long enough."""
    groups: list[tuple[SpokenText, tuple[int, int]]] = []
    for one, (begin, end) in zip(spoken, bounds, strict=True):
        last, (first, until) = groups[-1] if groups else (one, (begin, -RATE))
        if begin - until < APART * RATE and last.duration < GROUP:
            groups[-1] = (_joined(last, one), (first, end))
        else:
            groups.append((one, (begin, end)))
    return groups


def _joined(first: SpokenText, second: SpokenText) -> SpokenText:
    by = first.duration
    return replace(
        first,
        samples=np.concatenate([first.samples, second.samples]),
        words=(*first.words, *_later(second.words, by)),
        phones=(*first.phones, *_later(second.phones, by)),
    )


def _later(intervals: Sequence[Interval], by: float) -> list[Interval]:
    return [replace(one, start=one.start + by, end=one.end + by) for one in intervals]


def _moved(intervals: Sequence[Interval], begin: int) -> list[Interval]:
    return _later(intervals, begin / RATE)


Places = tuple[list[SpokenText], list[tuple[int, int]]]


def _places(samples: Floats, spoken: Sequence[SpokenText]) -> Places:
    """Sentences, parted where the path waits within them, and the samples where each lies."""
    ours = _blocks([samples])
    theirs = _blocks([_sound(one) for one in spoken])
    ends = np.cumsum([_count(one.duration) for one in spoken])
    starts = [0, *ends[:-1].tolist()]
    between = np.zeros(len(theirs.level), bool)
    for end in [0, *ends]:
        between[max(0, end - 3) : end + 3] = True
    for one, start in zip(spoken, starts, strict=True):
        for word in one.words:
            between[_gap(word, start)] = True
    path = _path(ours, theirs, between)
    parts: list[SpokenText] = []
    cuts: list[tuple[int, int]] = []
    for one, start, end in zip(spoken, starts, ends.tolist(), strict=True):
        first = 0
        for number, word in enumerate(one.words[1:], 1):
            waits = np.flatnonzero(np.isin(path, np.arange(len(between))[_gap(word, start)]))
            if len(waits) * HOP * BLOCK >= WAITED * RATE:
                parts.append(_part(one, first, number))
                cuts.append((_quietest(samples, int(waits[0])), _quietest(samples, int(waits[-1]))))
                first = number
        parts.append(_part(one, first, len(one.words)) if first else one)
        inside = np.flatnonzero((path >= end - 3) & (path < end + 3))
        last = inside if len(inside) else np.array([min(int(np.searchsorted(path, end)), len(path) - 1)])
        cuts.append((_quietest(samples, int(last[0])), _quietest(samples, int(last[-1]))))
    begins = [0, *(begin for _, begin in cuts[:-1])]
    stops = [*(stop for stop, _ in cuts[:-1]), len(samples)]
    return parts, [(a, max(b, a + round(SHORTEST * RATE))) for a, b in zip(begins, stops, strict=True)]


def _sound(spoken: SpokenText) -> Floats:
    return resample((spoken.samples / 32768).astype(np.float32), spoken.rate, RATE)


def _gap(word: Interval, start: int) -> slice:
    """The blocks around the begin of a word, in a sentence that begins at a block."""
    block = start + round(word.start * RATE / HOP / BLOCK)
    return slice(max(0, block - 1), block + 1)


def _part(spoken: SpokenText, first: int, last: int) -> SpokenText:
    """The words of a sentence from one to before another, with a little silence around them."""
    words = spoken.words[first:last]
    begin = words[0].start
    end = spoken.words[last].start if last < len(spoken.words) else spoken.duration
    silence = np.zeros(round(EDGE * spoken.rate), np.int16)
    inner = spoken.samples[round(begin * spoken.rate) : round(end * spoken.rate)]
    phones = [phone for phone in spoken.phones if begin - 1e-6 <= phone.start < end - 1e-6]
    by = len(silence) / spoken.rate - begin
    return SpokenText(
        np.concatenate([silence, inner, silence]),
        spoken.rate,
        tuple(_later(words, by)),
        tuple(_later(phones, by)),
    )


def _count(seconds: float) -> int:
    return max(round(seconds * RATE) // (HOP * BLOCK), 1)


def _quietest(samples: Floats, block: int) -> int:
    """The sample in the middle of the quietest 100 ms near a block."""
    step, middle = RATE // 10, block * HOP * BLOCK
    begin = max(0, middle - round(REACH * RATE))
    piece = samples[begin : middle + round(REACH * RATE)]
    power = (piece[: len(piece) // step * step].reshape(-1, step) ** 2).mean(axis=1)
    return begin + int(power.argmin()) * step + step // 2 if len(power) else middle


def _blocks(pieces: Sequence[Floats]) -> _Blocks:
    """Features of pieces one after the other, analysed a minute at a time."""
    cepstra: list[Floats] = []
    levels: list[Floats] = []
    filters = mel_filters(RATE, WINDOW, BANDS)
    n = np.arange(BANDS)
    cosines = np.cos(np.pi * (n[:, None] + 0.5) * n[1 : CEPSTRA + 1] / BANDS)
    size = HOP * BLOCK
    for piece in pieces:
        for begin in range(0, max(len(piece) // size * size, 1), CHUNK // size * size):
            part = piece[begin : begin + CHUNK // size * size]
            part = part[: len(part) // size * size]
            if not len(part):
                continue
            mel = np.log(power_spectra(part, WINDOW, HOP) @ filters + FLOOR)
            count = len(part) // size
            mel = mel[: count * BLOCK]
            cepstra.append((mel.reshape(count, BLOCK, -1).mean(axis=1) @ cosines).astype(np.float32))
            levels.append(np.log((part.reshape(count, size) ** 2).mean(axis=1) + FLOOR).astype(np.float32))
    level, values = np.concatenate(levels), np.concatenate(cepstra)
    low, high = np.percentile(level, [5, 95])
    loud = level > low + 0.3 * (high - low)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(level, 6, mode="edge"), 13)
    speech = loud & (around.std(axis=1) > MODULATED * (high - low))
    speech = speech if speech.any() else loud
    normal = (values - values[speech].mean(axis=0)) / (values[speech].std(axis=0) + 1e-6)
    level = np.clip((level - high) / max(float(high - low), 1e-6), -1.2, 0.2)
    return _Blocks(normal.astype(np.float32), level.astype(np.float32), speech)


def _path(ours: _Blocks, theirs: _Blocks, between: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The block of the made speech for each block of the recording, (blocks,): the cheapest in the band."""
    frames, states = len(ours.level), len(theirs.level)
    width = min(states, 2 * round(BAND * RATE / HOP / BLOCK) + 1)
    lows = _band(ours, theirs, width)
    steps = np.zeros((frames, width), np.int8)
    price = np.full(width, np.inf, np.float32)
    price[0] = 0.0
    for frame in range(frames):
        low = lows[frame]
        moved = low - lows[frame - 1] if frame else 0
        options = np.full((len(STEPS), width), np.inf, np.float32)
        for step in range(len(STEPS)):  # from the state lower by `step`, at its place in the band before
            shift = moved - step
            source = price[max(shift, 0) : width + min(shift, 0)]
            options[step, max(-shift, 0) : max(-shift, 0) + len(source)] = source + STEPS[step]
        local = _distance(ours, theirs, frame, low, width)
        rest = between[low : low + width]
        waiting = WAITING if not ours.speech[frame] else RESTING
        local = np.where(rest, np.minimum(local, waiting), local)
        options[0, rest] -= STEPS[0]  # it costs nothing to stay between two sentences
        steps[frame] = options.argmin(axis=0)
        price = options.min(axis=0) + local if frame else np.where(np.arange(width) == 0, local, np.inf)
        price = price.astype(np.float32)
    path = np.empty(frames, np.int64)
    state = states - 1 if np.isfinite(price[states - 1 - lows[-1]]) else int(lows[-1] + price.argmin())
    for frame in range(frames - 1, -1, -1):
        path[frame] = state
        state -= int(steps[frame, state - lows[frame]]) if frame else 0
    return path


def _band(ours: _Blocks, theirs: _Blocks, width: int) -> NDArray[np.int64]:
    """The lowest state of the band at each block, around the state with as much speech behind it."""
    share = np.cumsum(ours.speech) / max(int(ours.speech.sum()), 1)
    spoken = np.cumsum(theirs.speech) / max(int(theirs.speech.sum()), 1)
    middle = np.searchsorted(spoken, share)
    lows = np.clip(middle - width // 2, 0, len(theirs.level) - width)
    return np.maximum.accumulate(lows)


def _distance(ours: _Blocks, theirs: _Blocks, frame: int, low: int, width: int) -> Floats:
    """Root mean square of the difference of cepstra, and that of the level, from one block to the band."""
    cepstra = theirs.cepstra[low : low + width] - ours.cepstra[frame]
    level = np.abs(theirs.level[low : low + width] - ours.level[frame])
    return np.asarray(np.sqrt((cepstra**2).mean(axis=1)) + LOUDNESS * level, np.float32)
