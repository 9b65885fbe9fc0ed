"""Recognize phones in sound, as it comes or whole: any voice, causal, in NumPy alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import AudioError
from phonanim.media.audio import Sound, level, read_sound, resample
from phonanim.recognition.decoding import LAG, Decoder
from phonanim.recognition.network import Network, NetworkStream, load_network
from phonanim.recognition.spectrum import RATE, STEP, WINDOW, MelSpectrum, VoiceMean, voice_mean
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY

Floats = NDArray[np.float32]

LANGUAGE = "ipa"  # of the labels
TIER = "recognized"
PIECE = 10 * RATE  # samples of a recording that are read at a time
SHORTEST = 0.2  # seconds of a recording


@dataclass
class PhoneRecognizer:
    """Samples at RATE in, phones out; silences are left out.

    `begun` is the phone that has not ended: its code (0 for silence), and its start in seconds. It lasts
    until `until` at least.
    """

    network: Network
    spectrum: MelSpectrum = field(default_factory=MelSpectrum)
    mean: VoiceMean = field(default_factory=VoiceMean)
    begun: tuple[int, float] = (0, 0.0)
    received: int = 0  # samples
    told: int = 0  # steps

    def __post_init__(self) -> None:
        self.stream, self.decoder = NetworkStream(self.network), Decoder(self.network)

    @property
    def until(self) -> float:
        """Seconds until which phones are known."""
        return max(self.told - 0.5, 0.0) * STEP

    def going_on(self, seconds: float) -> Interval | None:
        """The phone that has not ended, as if it went on for some seconds; None in silence."""
        code, start = self.begun
        return Interval(label_of(code), start, self.until + seconds) if code else None

    def push(self, samples: Floats) -> list[Interval]:
        """Add samples, (n,); the phones that have ended."""
        self.received += len(samples)
        return self._decode(samples, last=False)

    def end(self) -> list[Interval]:
        """The remaining phones; the last ends with the sound at the latest."""
        found = self._decode(np.zeros(WINDOW // 2, np.float32), last=True)
        return [*found, *self._finish(self.received / RATE)]

    def _decode(self, samples: Floats, last: bool) -> list[Interval]:
        steps = self.mean.subtract(self.spectrum.push(samples))
        found: list[Interval] = []
        for code in self.decoder.push(self.stream.push(steps, last), last):
            if code != self.begun[0]:
                found += self._finish(self.until)
                self.begun = code, self.until
            self.told += 1
        return found

    def _finish(self, end: float) -> list[Interval]:
        code, start = self.begun
        self.begun = 0, end
        return [Interval(label_of(code), start, end)] if code and end > start else []


def look_ahead(network: Network) -> float:
    """Seconds of sound after an instant that its phone needs."""
    return (network.ahead + LAG + 0.5) * STEP + WINDOW / 2 / RATE


def mean_of(path: Path) -> VoiceMean:
    """The mean of the voice of a recording at its start. Raises AudioError."""
    sound = read_sound(path)
    return voice_mean(level(resample(sound.samples, sound.rate, RATE)))


def label_of(code: int) -> str:
    """A phone of the inventory in IPA."""
    return INVENTORY.sounds[code].ipa


def recognize_phones(sound: Sound, model: Path, name: str) -> Alignment:
    """The phones of a recording, in IPA, as the network `model` recognizes them; `name` is for errors.

    Raises AudioError where nothing can be recognized: less than SHORTEST seconds, or nothing but silence.
    """
    if sound.duration < SHORTEST:
        raise AudioError(
            f"{name}: lasts {sound.duration:.2f} s, and phones are recognized in {SHORTEST:g} s at least; "
            "record more, or give an alignment"
        )
    samples = level(resample(sound.samples, sound.rate, RATE))
    recognizer, found = PhoneRecognizer(load_network(model), mean=voice_mean(samples)), []
    for begin in range(0, len(samples), PIECE):
        found += recognizer.push(samples[begin : begin + PIECE])
    found += recognizer.end()
    if not found:
        raise AudioError(f"{name}: no speech is recognized in it; check that it is the right recording")
    return Alignment(tuple(found), sound.duration, TIER, name)
