"""Align speech with its text in any language: speech made from the text is warped onto the recording.

eSpeak NG speaks the text and tells when each phone begins. Dynamic time warping (Sakoe and Chiba 1978) of
cepstra finds where in the recording each instant of the made speech lies; this is how the program aeneas
aligns sentences. The path takes each frame of the recording to a frame of the made speech, which stays or
goes on by up to three frames; in a silence between two words it may wait. After a first path, a linear map
from the made voice to the recorded one is fitted along it, and a second path is found with it. Beside the
cepstra counts how well the phone of the made speech fits the recording, by the shipped network that
recognizes phones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners.espeak import SpokenText, speak
from phonanim.aligners.pocketsphinx import SpeechAlignment
from phonanim.errors import AlignmentError, AudioError
from phonanim.media.audio import Sound, level, read_sound, resample
from phonanim.media.mel import mel_filters, power_spectra
from phonanim.recognition.scores import phone_misfits
from phonanim.recognition.spectrum import STEP
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.language import to_phones

Array = NDArray[np.float64]

RATE = 16000  # hertz
HOP, WINDOW = 80, 400  # samples: 5 ms and 25 ms
BANDS, CEPSTRA = 26, 12
FLOOR = 1e-7  # of the power in a band, because digital silence has no logarithm
SLOPE = 3  # frames on each side over which a slope is computed
LOUDNESS = 1.6  # weight of the level beside the cepstra
STEPS = (0.35, 0.0, 0.2, 0.6)  # price of staying, and of going on by 1, 2, 3 frames
ALIKE, MISFIT = 0.5, 0.4  # weights of what sounds alike, and of each nat by which a phone fits less
WORST = 5.0  # nats from which a phone does not fit at all
WAITING = 0.3  # price of a silent frame between two words
RIDGE = 30.0  # frames: how firmly the map between voices keeps to no change
STOPS = frozenset("pbtdkg\u0261")
CLOSED = 0.07, 0.12  # seconds that a stop after silence lasts at least and at most
ROWS = 256  # frames whose prices are in memory at once
EARLY = 0.008  # seconds: a window meets a sound before its centre does
LONGEST = 120.0  # seconds; the table of paths grows with the square
DOUBTFUL = 0.9  # share of the price of the same words in another order, above which the text is doubted


@dataclass(frozen=True)
class _Frames:
    """Of each frame: `features` (frames, n) normalized in speech, `level` from -1 (silent) to 0, `speech`."""

    features: Array
    level: Array
    speech: NDArray[np.bool_]


def align_by_speech(audio: Path, text: str, voice: str) -> SpeechAlignment:
    """Find the words and phones (IPA) of `text`, spoken in the language of `voice`, in a recording.

    A note says so where the recording hardly sounds like the text. Raises AlignmentError when the recording
    is too long, or too short for the text; AudioError when it cannot be read or is silent; OptionError for a
    voice that eSpeak NG does not have; MissingExtraError.
    """
    sound = read_sound(audio)
    if sound.duration > LONGEST:
        raise AlignmentError(
            f"{audio}: lasts {sound.duration:.0f} s; at most {LONGEST:.0f} s are aligned at once; split it"
        )
    spoken = speak(text, voice)
    path, share = warp(sound, spoken)
    words, phones = words_along(spoken, path), phones_along(spoken, path)
    return SpeechAlignment(words, phones, sound.duration, _doubts(share))


def words_along(spoken: SpokenText, path: NDArray[np.int64]) -> tuple[Interval, ...]:
    """The words of made speech in the recording onto which it was warped."""
    moved = zip(spoken.phones, phones_along(spoken, path), strict=True)
    begins = {phone.start: there.start for phone, there in moved}
    found = []
    for word in spoken.words:
        start, end = _moved(path, word.start, word.end)
        start = begins.get(word.start, start)
        found.append(Interval(word.label, start, max(end, start + HOP / RATE)))
    return tuple(found)


def phones_along(spoken: SpokenText, path: NDArray[np.int64]) -> tuple[Interval, ...]:
    """The phones of made speech in the recording onto which it was warped."""
    return _in_order(spoken.phones, path)


def _doubts(share: float) -> tuple[str, ...]:
    if share <= DOUBTFUL:
        return ()
    also = f"its words in reverse order fit {1 / share:.0%} as well"
    return (f"the recording hardly matches the text in this voice: {also}",)


def warp(sound: Sound, spoken: SpokenText) -> tuple[NDArray[np.int64], float]:
    """The frame of the made speech for each frame of a recording, (frames,), and how doubtful the text is.

    The doubt is the price of the path divided by that for the same words in reverse order: about 0.6 for the
    right text, 1 for another one.

    Raises AudioError when the recording is silent or too short.
    """
    made = resample((spoken.samples / 32768).astype(np.float32), spoken.rate, RATE)
    recorded = level(resample(sound.samples, sound.rate, RATE))
    ours, theirs = _frames(recorded), _frames(made)
    between = np.zeros(len(theirs.features), bool)
    for word in spoken.words:
        for instant in (word.start, word.end):
            frame = round(instant * RATE / HOP)
            between[max(0, frame - 1) : frame + 1] = True
    misfits = _misfits(recorded, len(ours.level))
    codes = _codes(spoken, len(between))
    path, price = _voiced_path(ours, theirs, between, misfits, codes)
    order = _other_order(len(between), spoken)
    turned = _Frames(theirs.features[order], theirs.level[order], theirs.speech[order])
    return path, price / _voiced_path(ours, turned, between[order], misfits, codes[order])[1]


def _misfits(samples: NDArray[np.float32], frames: int) -> NDArray[np.float32]:
    """The price of each phone at each frame, (frames, phones)."""
    steps = MISFIT * np.minimum(phone_misfits(samples), WORST)
    at = np.round(np.arange(frames) * HOP / RATE / STEP).astype(int)
    return np.asarray(steps[np.minimum(at, len(steps) - 1)], np.float32)


def _codes(spoken: SpokenText, frames: int) -> NDArray[np.int64]:
    """The phone of the inventory at each frame of made speech, (frames,)."""
    track, _ = to_phones(Alignment(spoken.phones, spoken.duration, "", ""), "ipa", unknown="nearest")
    middles = (np.arange(frames) + 0.5) * HOP / RATE
    at = np.searchsorted(track.bounds, middles, side="right") - 1
    return np.asarray(track.codes, np.int64)[np.clip(at, 0, len(track.codes) - 1)]


def _voiced_path(
    ours: _Frames,
    theirs: _Frames,
    between: NDArray[np.bool_],
    misfits: NDArray[np.float32],
    codes: NDArray[np.int64],
) -> tuple[NDArray[np.int64], float]:
    """The path of two passes, the second in the recorded voice; and its price."""

    def prices(features: Array) -> Iterator[NDArray[np.float32]]:
        """The price of each frame of the made speech, frame by frame of the recording."""
        for begin in range(0, len(misfits), ROWS):
            rows = slice(begin, begin + ROWS)
            yield from misfits[rows][:, codes] + ALIKE * _distances(ours, rows, theirs, features)

    path, _ = _cheapest(prices(theirs.features), ours.speech, between)
    return _cheapest(prices(_other_voice(ours, theirs, path)), ours.speech, between)


def _other_order(count: int, spoken: SpokenText) -> NDArray[np.int64]:
    """The frames of the made speech with its words in reverse order, (frames,); the margins stay."""
    starts = [round(word.start * RATE / HOP) for word in spoken.words]
    if len(starts) == 1:  # of one word the two halves change places
        starts.append((starts[0] + count) // 2)
    ends = [*starts[1:], min(round(spoken.words[-1].end * RATE / HOP), count)]
    parts = [np.arange(a, b) for a, b in zip(starts, ends, strict=True)]
    return np.concatenate([np.arange(starts[0]), *reversed(parts), np.arange(ends[-1], count)])


def _frames(samples: NDArray[np.float32]) -> _Frames:
    if len(samples) < 4 * WINDOW or not np.abs(samples).max() > 0:
        raise AudioError("there is no speech in the recording; check the file")
    mel = np.log(power_spectra(samples, WINDOW, HOP) @ mel_filters(RATE, WINDOW, BANDS) + FLOOR)
    n = np.arange(BANDS)
    cepstra = mel @ np.cos(np.pi * (n[:, None] + 0.5) * n[1 : CEPSTRA + 1] / BANDS)
    power = (samples[: len(mel) * HOP].reshape(-1, HOP) ** 2).mean(axis=1)
    level = np.log(np.convolve(power, np.ones(5) / 5, "same") + FLOOR)
    low, high = np.percentile(level, [5, 95])
    speech = level > low + 0.3 * (high - low)
    level = np.clip((level - high) / max(high - low, 1e-6), -1.2, 0.2)
    features = np.hstack([_normalized(cepstra, speech), _normalized(_slopes(cepstra), speech)])
    return _Frames(features, level, speech)


def _normalized(values: Array, speech: NDArray[np.bool_]) -> Array:
    return np.asarray((values - values[speech].mean(axis=0)) / (values[speech].std(axis=0) + 1e-6))


def _slopes(values: Array) -> Array:
    padded = np.pad(values, ((SLOPE, SLOPE), (0, 0)), mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * SLOPE + 1, axis=0)
    weights = np.arange(-SLOPE, SLOPE + 1)
    return np.asarray(around @ (weights / (weights**2).sum()))


def _distances(ours: _Frames, rows: slice, theirs: _Frames, features: Array) -> NDArray[np.float32]:
    """Root mean square of the difference of features, and that of the level, (rows of ours, theirs)."""
    a, b = ours.features[rows].astype(np.float32), features.astype(np.float32)
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
    distances = np.sqrt(np.maximum(squares, 0) / a.shape[1])
    distances += LOUDNESS * np.abs(ours.level[rows, None] - theirs.level).astype(np.float32)
    return np.asarray(distances, np.float32)


def _other_voice(ours: _Frames, theirs: _Frames, path: NDArray[np.int64]) -> Array:
    """The made speech's features in the recorded voice, by least squares along a path."""
    ones = np.ones((len(theirs.features), 1))
    known = np.hstack([theirs.features, ones])
    x, y = known[path][ours.speech], ours.features[ours.speech]
    firm = RIDGE * np.diag([1.0] * theirs.features.shape[1] + [0.0])
    return np.asarray(known @ np.linalg.solve(x.T @ x + firm, x.T @ y + firm[:, : y.shape[1]]))


def _cheapest(
    prices: Iterator[NDArray[np.float32]], speech: NDArray[np.bool_], between: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], float]:
    """The cheapest path from the first to the last frame of both, and its price."""
    frames, states = len(speech), len(between)
    if len(STEPS[1:]) * (frames - 1) < states - 1:
        raise AlignmentError("the recording is much too short for the text; correct the text")
    steps = np.zeros((frames, states), np.int8)
    price = np.full(states, np.inf, np.float32)
    price[0] = next(prices)[0]
    options = np.full((len(STEPS), states), np.inf, np.float32)
    for frame, local in enumerate(prices, 1):
        options[0] = price + (STEPS[0] if speech[frame] else 0.0)
        for step in range(1, len(STEPS)):
            options[step, step:] = price[:-step] + STEPS[step]
        steps[frame] = options.argmin(axis=0)
        if not speech[frame]:
            local = np.where(between, np.minimum(local, WAITING), local)
        price = options.min(axis=0) + local
    path = np.empty(frames, np.int64)
    state = states - 1
    for frame in range(frames - 1, -1, -1):
        path[frame] = state
        state -= int(steps[frame, state])
    return path, float(price[-1])


def _moved(path: NDArray[np.int64], start: float, end: float) -> tuple[float, float]:
    """Two instants of the made speech, in seconds of the recording."""
    frames = np.searchsorted(path, np.array([start, end]) * RATE / HOP - 1e-6)
    first, last = np.maximum(np.minimum(frames, len(path) - 1) * HOP / RATE - EARLY, 0.0)
    return float(first), float(max(last, first + HOP / RATE))


def _in_order(phones: tuple[Interval, ...], path: NDArray[np.int64]) -> tuple[Interval, ...]:
    """The phones in the recording, each at least one frame long, none before the one before it ends.

    A stop after silence makes no sound until it is released, and lasts as long before as stops do.
    """
    moved: list[Interval] = []
    end = 0.0
    for number, phone in enumerate(phones):
        start, stop = _moved(path, phone.start, phone.end)
        start = max(start, end)
        end = max(stop, start + HOP / RATE)
        if number + 1 < len(phones) and phones[number + 1].start - phone.end < 1e-6:
            end = max(_moved(path, phones[number + 1].start, phone.end)[0], start + HOP / RATE)
        if phone.label[:1] in STOPS and (number == 0 or phone.start - phones[number - 1].end > 1e-6):
            before = moved[-1].end if moved else 0.0
            start = max(before, min(max(start, end - CLOSED[1]), end - CLOSED[0]))
        moved.append(Interval(phone.label, start, end))
    return tuple(moved)
