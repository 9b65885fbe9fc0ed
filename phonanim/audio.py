"""Recordings: samples, duration, resampling."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import AudioError, MissingExtraError

SUFFIXES = (".wav", ".flac", ".ogg", ".mp3")


def find_audio(alignment: Path) -> Path | None:
    """The recording that lies beside an alignment under the same stem, if there is one."""
    candidates = (alignment.with_suffix(suffix) for suffix in SUFFIXES)
    return next((path for path in candidates if path.is_file()), None)


def read_audio(path: Path) -> tuple[NDArray[np.float32], int]:
    """Mono samples in -1..1, (samples,), and their rate in hertz; channels are averaged.

    16-bit WAV needs nothing; every other format needs the `audio` extra. Raises AudioError.
    """
    samples, rate = _read_wav(path) or _read_other(path)
    if len(samples) == 0:
        raise AudioError(f"{path}: holds no sound; record it again")
    return samples, rate


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
    """Seconds of a recording, read from its header where the format has one. Raises AudioError."""
    try:
        with wave.open(str(path), "rb") as stream:
            return stream.getnframes() / stream.getframerate()
    except (wave.Error, EOFError):
        info = _soundfile(path).info(str(path))
        return float(info.frames / info.samplerate)


def _read_wav(path: Path) -> tuple[NDArray[np.float32], int] | None:
    """A 16-bit PCM WAV file; None when it is anything else."""
    try:
        with wave.open(str(path), "rb") as stream:
            if stream.getsampwidth() != 2:
                return None
            data = np.frombuffer(stream.readframes(stream.getnframes()), "<i2")
            mono = data.reshape(-1, stream.getnchannels()).mean(axis=1) / 32768
            return mono.astype(np.float32), stream.getframerate()
    except (wave.Error, EOFError, ValueError):
        return None
    except OSError as error:
        raise AudioError(f"{path}: cannot be read: {error.strerror}") from error


def _read_other(path: Path) -> tuple[NDArray[np.float32], int]:
    soundfile = _soundfile(path)
    try:
        data, rate = soundfile.read(str(path), dtype="float32", always_2d=True)
    except soundfile.LibsndfileError as error:
        raise AudioError(f"{path}: is no recording that can be read: {error.error_string}") from error
    return data.mean(axis=1), int(rate)


def _soundfile(path: Path):  # type: ignore[no-untyped-def]  # noqa: ANN202
    try:
        import soundfile
    except ImportError as error:
        message = (
            f"{path}: reading {path.suffix or 'this'} needs pip install 'phonanim[audio]', or a 16-bit WAV"
        )
        raise MissingExtraError(message) from error
    return soundfile
