"""One-hot phones (Medina 2023, section 3.2.1): from an alignment, or recognized by pocketsphinx."""

from __future__ import annotations

import tempfile
import wave
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.encoders import HOP, RATE, STEPS, Features
from phonanim.errors import AlignmentError
from phonanim.speech.alignment import Alignment
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack, silent_track


@dataclass(frozen=True)
class Posteriors:
    """Phones of English as pocketsphinx recognizes them without the text."""

    layers: int = 1
    dims: int = N_PHONES
    identity: str = "phones by pocketsphinx"
    start: float = HOP / RATE / 2
    window: int = 30
    margin: int = 2

    def run(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Features of (steps * HOP,) samples -> (steps, 1, phones)."""
        return one_hot_phones(recognize_phones(samples), self.start + np.arange(len(samples) // HOP) / STEPS)


def track_features(track: PhoneTrack) -> Features:
    """The features of an alignment."""
    start = Posteriors.start
    times = start + np.arange(max(1, int(np.ceil(track.duration * STEPS - 1e-6)))) / STEPS
    return Features(one_hot_phones(track, times).astype(np.float16), STEPS, start)


def one_hot_phones(track: PhoneTrack, times: NDArray[np.float64]) -> NDArray[np.float32]:
    """One phone at a time, (times,) seconds -> (times, 1, phones)."""
    return np.eye(N_PHONES, dtype=np.float32)[track.sample(times)][:, None]


def recognize_phones(samples: NDArray[np.float32]) -> PhoneTrack:
    """The phones of (samples,) at RATE; silence when no word is recognized. Raises MissingExtraError."""
    from phonanim.aligners.pocketsphinx import align

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sound.wav"
        _write(path, samples)
        try:
            found = align(path)
        except AlignmentError:  # nothing was recognized
            return silent_track(len(samples) / RATE)
    if not found.phones:
        return silent_track(len(samples) / RATE)
    return to_phones(Alignment(found.phones, found.duration, "phones", "sound"), "english")[0]


def _write(path: Path, samples: NDArray[np.float32]) -> None:
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(RATE)
        stream.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def load() -> Posteriors:
    """The encoder."""
    return Posteriors()
