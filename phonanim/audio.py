"""Recordings: samples, duration, resampling."""

from __future__ import annotations

import wave
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import AudioError, MissingExtraError

SUFFIXES = (".wav", ".flac", ".ogg", ".mp3")


def find_audio(alignment: Path) -> Path | None:
    """The recording beside an alignment, under the same stem, if there is one; of a recording, itself."""
    if alignment.suffix.lower() in SUFFIXES:
        return alignment
    candidates = (alignment.with_suffix(suffix) for suffix in SUFFIXES)
    return next((path for path in candidates if path.is_file()), None)


@dataclass(frozen=True)
class Sound:
    """A recording in memory: `samples` (n,) float32 mono in -1..1, `rate` in hertz."""

    samples: NDArray[np.float32]
    rate: int

    @property
    def duration(self) -> float:
        """Seconds."""
        return len(self.samples) / self.rate


def read_sound(path: Path) -> Sound:
    """A recording with its rate. Raises AudioError."""
    return Sound(*read_audio(path))


def read_audio(path: Path) -> tuple[NDArray[np.float32], int]:
    """Mono samples in -1..1, (samples,), and their rate in hertz; channels are averaged.

    16-bit WAV needs nothing; every other format needs the `audio` extra. Raises AudioError.
    """
    samples, rate = _read_wav(path) or _read_other(path)
    if len(samples) == 0:
        raise AudioError(f"{path}: holds no sound; record it again")
    return samples, rate


def opened_audio(path: Path, seconds: float) -> tuple[int, Iterator[NDArray[np.float32]]]:
    """The rate of a recording in hertz, and its mono samples in blocks of about so many seconds, (n,) each.

    What can be read is as in `read_audio`, but memory does not grow with the length. Raises AudioError.
    """
    try:
        with _open(path) as file, wave.open(file, "rb") as stream:
            if stream.getsampwidth() == 2:
                return stream.getframerate(), _wav_blocks(path, round(seconds * stream.getframerate()))
    except (wave.Error, EOFError):
        pass
    with _soundfile(path) as soundfile:
        rate = int(soundfile.info(str(path)).samplerate)
    return rate, _other_blocks(path, round(seconds * rate))


def _wav_blocks(path: Path, size: int) -> Iterator[NDArray[np.float32]]:
    with _open(path) as file, wave.open(file, "rb") as stream:
        while data := stream.readframes(size):
            yield mono(data, stream.getnchannels())


def _other_blocks(path: Path, size: int) -> Iterator[NDArray[np.float32]]:
    with _soundfile(path) as soundfile:
        for block in soundfile.blocks(str(path), size, dtype="float32", always_2d=True):
            yield block.mean(axis=1)


def mono(data: bytes, channels: int) -> NDArray[np.float32]:
    """16-bit samples of several channels -> (samples,) in -1..1; what is left of a last one is left out."""
    whole = len(data) // (2 * channels) * (2 * channels)
    samples = np.frombuffer(data[:whole], "<i2").reshape(-1, channels)
    return (samples.mean(axis=1) / 32768).astype(np.float32)


def resample(samples: NDArray[np.float32], rate: int, target: int) -> NDArray[np.float32]:
    """Band-limited resampling by the Fourier transform, `rate` -> `target` hertz."""
    if rate == target:
        return samples
    count = round(len(samples) * target / rate)
    spectrum = np.fft.rfft(samples)
    kept = np.zeros(count // 2 + 1, complex)
    shared = min(len(kept), len(spectrum))
    kept[:shared] = spectrum[:shared]
    return (np.fft.irfft(kept, count) * (count / len(samples))).astype(np.float32)


def duration(path: Path) -> float:
    """Seconds of a recording, from its header. Raises AudioError.

    WAV and FLAC need nothing; every other format needs the `audio` extra.
    """
    with _open(path) as file:
        head = file.read(26)
    if head[:4] == b"fLaC":
        return _flac_duration(head)
    try:
        with wave.open(str(path), "rb") as stream:
            return stream.getnframes() / stream.getframerate()
    except (wave.Error, EOFError, ZeroDivisionError):
        with _soundfile(path) as soundfile:
            info = soundfile.info(str(path))
            return float(info.frames / info.samplerate)


def _flac_duration(head: bytes) -> float:
    """The STREAMINFO block (RFC 9639, section 8.2): 20 bits of rate, ..., 36 bits of sample count."""
    fields = int.from_bytes(head[18:26], "big")
    return (fields & (2**36 - 1)) / (fields >> 44)


def _read_wav(path: Path) -> tuple[NDArray[np.float32], int] | None:
    """A 16-bit PCM WAV file; None when it is anything else."""
    try:
        with _open(path) as file, wave.open(file, "rb") as stream:
            if stream.getsampwidth() != 2:
                return None
            data = np.frombuffer(stream.readframes(stream.getnframes()), "<i2")
            mono = data.reshape(-1, stream.getnchannels()).mean(axis=1) / 32768
            return mono.astype(np.float32), stream.getframerate()
    except (wave.Error, EOFError, ValueError):
        return None


def _read_other(path: Path) -> tuple[NDArray[np.float32], int]:
    with _soundfile(path) as soundfile:
        data, rate = soundfile.read(str(path), dtype="float32", always_2d=True)
        return data.mean(axis=1), int(rate)


def _open(path: Path) -> BinaryIO:
    try:
        return path.open("rb")
    except OSError as error:
        raise AudioError(f"{path}: cannot be read: {error.strerror}") from error


@contextmanager
def _soundfile(path: Path) -> Iterator[Any]:
    """The soundfile module, its errors told as AudioError."""
    try:
        import soundfile
    except ImportError as error:
        needed = "pip install 'phonanim[audio]', or a 16-bit WAV"
        raise MissingExtraError(f"{path}: reading {path.suffix or 'this'} needs {needed}") from error
    try:
        yield soundfile
    except soundfile.LibsndfileError as error:
        raise AudioError(f"{path}: is no recording that can be read: {error.error_string}") from error
