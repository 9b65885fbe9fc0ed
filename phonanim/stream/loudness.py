"""Loudness in a stream: the slow level of a voice, by the audio and the phones received so far."""

from __future__ import annotations

from bisect import insort
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.media.voice import FLOOR, FRAMES, Voice
from phonanim.speech.loudness import (
    ABOVE,
    AWAY,
    LEAST,
    LIMIT,
    RUN,
    SIGMA,
    SURE,
    VOICELESS,
    Loudness,
    lasting,
)
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.prosody import SILENT, VOWELS

Array = NDArray[np.float64]

LATE = 10  # frames before the end of the audio whose level and voicing are certain
PRIOR = 100  # voiced frames that the usual level of speech counts for
PAUSES = 1000  # last frames of pauses that tell what is there without speech
HALF = round(3 * SIGMA * FRAMES)


@dataclass
class StreamedLoudness:
    """Decibels louder than usual, a hundred times a second, each from what came before it.

    As `measure_loudness`, but about the mean of the speech so far, and over what is known: the second and a
    half before an instant and `ahead` seconds after it. `reference` is the usual level of speech, if given,
    in dB of full scale.
    """

    reference: float | None = None
    ahead: float = 0.0
    known: int = field(init=False)
    made: int = field(init=False)  # number of the next frame
    decibels: Array = field(default_factory=lambda: np.zeros(0))  # the last of them
    total: float = 0.0
    count: int = 0
    recent: Array = field(init=False)  # level, counted, vowels and voiced vowels of frames, (4, frames)
    weights: Array = field(init=False)
    order: deque[float] = field(default_factory=deque)
    pauses: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        known = round(self.ahead * FRAMES) - LATE  # frames after an instant that are certain
        offsets = np.arange(-HALF, max(known, 0) + 1)
        self.known, self.made = known, -max(known, 0)
        self.weights = np.exp(-0.5 * (offsets / (SIGMA * FRAMES)) ** 2)
        self.recent = np.zeros((4, len(offsets)))

    def until(self, time: float, voice: Voice, track: PhoneTrack, origin: float) -> Loudness:
        """The loudness until an instant, on the clock of a track that begins at `origin` seconds."""
        last = int(np.ceil(time * FRAMES)) + 1
        if last > self.made:
            self._extend(np.arange(self.made, last), voice, track, origin)
        first = self.made - len(self.decibels)
        return Loudness(self.decibels, np.nan, False, first / FRAMES - origin)

    def _extend(self, numbers: NDArray[np.int64], voice: Voice, track: PhoneTrack, origin: float) -> None:
        """Frames by the level, the phones and the pitch of those that are certain when they are due."""
        rows = numbers + self.known - round(voice.start * FRAMES)
        inside = (rows >= 0) & (rows < len(voice.level))
        rows = np.clip(rows, 0, max(len(voice.level) - 1, 0))
        times = np.maximum((numbers + self.known) / FRAMES - origin, 0.0)
        codes = track.sample(times)
        voiced = lasting(np.isfinite(voice.pitch), RUN)
        pause = inside & (track.distance_to(track.codes != SILENT, times) >= AWAY)
        found = [
            self._next(
                float(voice.level[row]) if known else FLOOR,
                bool(known and voiced[row]),
                bool(known and codes[i] != SILENT),
                bool(known and VOWELS[codes[i]]),
                bool(pause[i]),
            )
            for i, (row, known) in enumerate(zip(rows.tolist(), inside.tolist(), strict=True))
        ]
        self.decibels = np.concatenate([self.decibels, found])[-2 * FRAMES - len(found) :]
        self.made = int(numbers[-1]) + 1

    def _next(self, level: float, voiced: bool, spoken: bool, vowel: bool, pause: bool) -> float:
        """The decibels of one frame."""
        if pause:
            self._note_pause(level)
        self.recent = np.roll(self.recent, -1, axis=1)
        self.recent[:, -1] = level, 0.0, vowel, vowel and voiced
        vowels, sung = self.recent[2:] @ self.weights
        loud = level > max(self._background() + ABOVE, FLOOR)
        if voiced and spoken and loud and sung > VOICELESS * (vowels + SURE * FRAMES):
            self.recent[1, -1] = 1.0
            self.total, self.count = self.total + level, self.count + 1
        if self.count < LEAST:
            return 0.0
        prior = 0 if self.reference is None else PRIOR
        mean = (self.total + prior * (self.reference or 0.0)) / (self.count + prior)
        weights = self.recent[1] * self.weights
        apart = (weights @ (self.recent[0] - mean)) / (weights.sum() + SURE * FRAMES)
        usual = 0.0 if self.reference is None else np.clip(mean - self.reference, -LIMIT, LIMIT)
        return float(np.clip(apart, -LIMIT, LIMIT) + usual)

    def _note_pause(self, level: float) -> None:
        self.order.append(level)
        insort(self.pauses, level)
        if len(self.order) > PAUSES:
            self.pauses.remove(self.order.popleft())

    def _background(self) -> float:
        """The level that most of the last pauses do not exceed."""
        return self.pauses[int(0.75 * (len(self.pauses) - 1))] if len(self.pauses) >= LEAST else FLOOR
