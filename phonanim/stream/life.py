"""Life in a stream: add the layer to frames, from the phones or the audio received so far."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.overlay import limited
from phonanim.life import BACK, Life, life_offsets, mouth_freedom
from phonanim.media.voice import FRAMES, HALF, MEMORY, Voice, analyze_voice
from phonanim.options import Options
from phonanim.rig import Rig
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.speech.prosody import Prosody, measure_prosody, read_prosody

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

AT_ONCE = 256  # maximum number of frames that are made in advance
KEPT = BACK + MEMORY + 1.0  # seconds of level and pitch that are kept


@dataclass
class StreamedLife:
    """The layer of frames in their order. `known` gives the prosody and the phones before an instant.

    Frames that are decided are made together, because one costs as much as a hundred.
    """

    life: Life
    rig: Rig
    fps: float
    known: Callable[[float], tuple[Prosody, PhoneTrack]]
    first: int = 0
    made: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def add(self, values: Floats, first: int, ready: int) -> Floats:
        """Add the layer to frames from `first` on; frames before `ready` are decided."""
        last = first + len(values)
        if not self.first <= first <= last <= self.first + len(self.made):
            self.first, upto = first, max(last, min(ready, first + AT_ONCE))
            times = np.arange(first, upto) / self.fps
            prosody, track = self.known(float(times[0]))
            free = mouth_freedom(prosody, track, times)
            self.made = life_offsets(self.rig, self.life, prosody, times, free)
        return limited(values, self.made[first - self.first : last - self.first], self.rig)


@dataclass
class StreamedProsody:
    """Received phones, as far back as the life layer needs."""

    options: Options
    words: tuple[Interval, ...]
    ahead: float
    intervals: list[Interval] = field(default_factory=list)

    def prosody(self, time: float, until: float, ended: bool) -> tuple[Prosody, PhoneTrack]:
        """The prosody from 6 s before an instant until now, and the phones, on the clock of the line."""
        self.intervals = [interval for interval in self.intervals if interval.end > time - BACK]
        alignment = Alignment(tuple(self.intervals), until, "stream", "the stream")
        track, _ = to_phones(alignment, self.options.language, self.options.unknown)
        return read_prosody(track, self.words, self.ahead, ended), track


@dataclass
class StreamedVoice:
    """Level and pitch of the received audio, as far back as the life layer needs."""

    rate: int
    ahead: float
    samples: Floats = field(default_factory=lambda: np.zeros(0, np.float32))
    dropped: int = 0
    voice: Voice = field(default_factory=lambda: Voice(np.zeros(0), np.zeros(0)))

    def push(self, samples: Floats) -> None:
        """Add audio."""
        self.samples = np.concatenate([self.samples, samples])

    def prosody(self, time: float, ended: bool) -> tuple[Prosody, PhoneTrack]:
        """The prosody of the kept audio at an instant; there are no phones."""
        self.analyze(time, ended)
        until = max((self.dropped + len(self.samples)) / self.rate, 1 / FRAMES)
        return measure_prosody(self.voice, self.ahead, ended), silent_track(until)

    def analyze(self, time: float, ended: bool) -> Voice:
        """Level and pitch of what was received, from some seconds before an instant on."""
        begun = round(self.voice.start * FRAMES)
        first, came = begun + len(self.voice.level), self.dropped + len(self.samples)
        last = -(-came * FRAMES // self.rate) if ended else int((came / self.rate - HALF) * FRAMES)
        if last > first:
            self._extend(begun, first, last - first, time)
        return self.voice

    def _extend(self, begun: int, first: int, count: int, time: float) -> None:
        first -= first % 2  # pitch is found at every other frame
        added = analyze_voice(self.samples, self.rate, first, count + 1, self.dropped)
        size = count + begun + len(self.voice.level) - first
        own = first - begun
        old = max(0, int((time - KEPT) * FRAMES) - begun)
        old -= old % 2
        level = np.concatenate([self.voice.level[:own], added.level[:size]])[old:]
        pitch = np.concatenate([self.voice.pitch[:own], added.pitch[:size]])[old:]
        self.voice = Voice(level, pitch, (begun + old) / FRAMES)
        needed = int((first / FRAMES - 2 * HALF) * self.rate) - self.dropped
        if needed > 0:
            self.samples, self.dropped = self.samples[needed:], self.dropped + needed
