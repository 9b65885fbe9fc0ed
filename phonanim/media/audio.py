"""Recordings: samples, duration, resampling."""

from __future__ import annotations

import os
import wave
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import concatenate_pieces, open_plain
from phonanim.errors import AudioError, MissingExtraError
from phonanim.media.containers import COMPRESSED, CONTAINERS, FILMS, container_blocks, container_rate

SUFFIXES = (".wav", ".flac", ".ogg", ".mp3", ".opus", ".aif", ".aiff", *COMPRESSED)
"""Of recordings that are looked for beside an alignment."""

RECORDINGS = (*SUFFIXES, *FILMS)
"""Of files that are read as recordings."""

READ = 10.0  # seconds of a recording that are read at a time
BLOCK = 1 << 20  # samples that are processed at a time
PLAIN = (b"\x01\0", b"\x03\0", b"\xfe\xff")  # kinds of WAV with a constant number of bytes per second
FORMAT = 16  # bytes of the format that every WAV has
UNTOLD = 0x7FFFF000  # bytes; a header with this size or more was written before the length was known
SPARE = 0.01  # seconds that may be missing at the end of a file without a warning
LOWEST_RATE, HIGHEST_RATE = 1000, 768_000  # hertz
LONGEST = 4 * 3600  # seconds of a recording that is held whole
MOST_SAMPLES, MOST_VALUES = 150_000_000, 1_200_000_000  # of a small file: 52 minutes at 48 kHz; all channels
MOST_PER_BYTE = 25  # of a larger file: Opus at 16 kbit/s has 24
FULL_SCALE = 0.999
OFFSET = 0.3  # of the deviation of the samples, from which their mean is taken off
QUIET, LOUD = 0.05, 0.25  # peaks: quieter recordings are made as loud
CLIPPED = 1.0  # percent of samples at full scale above which a recording counts as clipped


def find_audio(alignment: Path) -> Path | None:
    """The recording next to an alignment, with the same stem, or None; for a recording, the file itself."""
    if alignment.suffix.lower() in RECORDINGS:
        return alignment
    suffixes = (*SUFFIXES, *map(str.upper, SUFFIXES))
    candidates = (alignment.with_suffix(suffix) for suffix in suffixes)
    return next((path for path in candidates if path.is_file()), None)


@dataclass(frozen=True)
class Sound:
    """A recording in memory: `samples` (n,) float32 mono in -1..1, `rate` in hertz.

    `features` is the file of features that were computed elsewhere, for models that read those.
    """

    samples: NDArray[np.float32]
    rate: int
    features: Path | None = None

    @property
    def duration(self) -> float:
        """Length in seconds."""
        return len(self.samples) / self.rate


def read_sound(path: Path) -> Sound:
    """A recording with its rate, and the place of precomputed features beside it. Raises AudioError."""
    return Sound(*read_audio(path), path.with_suffix(".features.npy"))


def read_audio(path: Path) -> tuple[NDArray[np.float32], int]:
    """Mono samples in -1..1, (samples,), and their rate in hertz; channels are averaged.

    16-bit WAV needs no extra; AAC and films need the extra `video`, other formats the extra `audio`. Long
    recordings are kept in a temporary file that is removed with the array, so that memory use does not grow.
    Raises AudioError.
    """
    rate, blocks = open_audio(path, READ)
    return concatenate_pieces(_numbers(path, rate, blocks)), rate


def open_audio(path: Path, seconds: float) -> tuple[int, Iterator[NDArray[np.float32]]]:
    """The rate of a recording in hertz, and its mono samples in blocks of about `seconds` s, (n,) each.

    The formats are those of `read_audio`, but memory use does not grow with length. Raises AudioError.
    """
    try:
        with _open(path) as file, wave.open(file, "rb") as stream:
            rate = stream.getframerate()
            if stream.getsampwidth() == 2 and rate > 0:
                _check_rate(path, rate)
                return rate, _some(path, _wav_blocks(path, round(seconds * rate)))
    except (wave.Error, EOFError):
        pass
    if path.suffix.lower() in CONTAINERS:
        rate = container_rate(path)
        _check_rate(path, rate)
        return rate, _some(path, _bounded(path, container_blocks(path, round(seconds * rate))))
    with _soundfile(path) as soundfile:
        rate = int(soundfile.info(str(path)).samplerate)
    _check_rate(path, rate)
    return rate, _some(path, _other_blocks(path, round(seconds * rate)))


def _check_rate(path: Path, rate: int) -> None:
    """Raise AudioError for a rate at which nobody records speech."""
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise AudioError(
            f"{path}: has {rate} samples per second; export it again with {LOWEST_RATE} to {HIGHEST_RATE}"
        )


def _wav_blocks(path: Path, size: int) -> Iterator[NDArray[np.float32]]:
    with _open(path) as file, wave.open(file, "rb") as stream:
        while data := stream.readframes(size):
            yield to_mono(data, stream.getnchannels())


def _other_blocks(path: Path, size: int) -> Iterator[NDArray[np.float32]]:
    count = 0
    with _soundfile(path) as soundfile:
        for block in soundfile.blocks(str(path), size, dtype="float32", always_2d=True):
            count += block.size
            if count > max(MOST_VALUES, MOST_PER_BYTE * path.stat().st_size):
                raise AudioError(f"{path}: unpacks to over {count:,} samples of all channels; cut it")
            yield block.mean(axis=1)


def _bounded(path: Path, blocks: Iterator[NDArray[np.float32]]) -> Iterator[NDArray[np.float32]]:
    """The same blocks. Raises AudioError when a small file unpacks to very many samples."""
    count = 0
    for block in blocks:
        count += len(block)
        if count > max(MOST_VALUES, MOST_PER_BYTE * path.stat().st_size):
            raise AudioError(f"{path}: unpacks to over {count:,} samples; cut it")
        yield block


def _some(path: Path, blocks: Iterator[NDArray[np.float32]]) -> Iterator[NDArray[np.float32]]:
    """The same blocks. Raises AudioError when there are no blocks."""
    empty = True
    for block in blocks:
        empty = empty and not len(block)
        yield block
    if empty:
        raise AudioError(f"{path}: contains no samples; record it again")


def _numbers(path: Path, rate: int, blocks: Iterator[NDArray[np.float32]]) -> Iterator[NDArray[np.float32]]:
    """The same blocks. Raises AudioError at samples that are not finite numbers."""
    count = 0
    for block in blocks:
        if not np.isfinite(block).all():
            place = f"after {count / rate:.1f} s"
            raise AudioError(f"{path}: has samples {place} that are not finite numbers; export it again")
        count += len(block)
        if count > max(MOST_SAMPLES, MOST_PER_BYTE * path.stat().st_size):
            raise AudioError(f"{path}: unpacks to over {count:,} samples; cut it in parts, or save it as WAV")
        if count > LONGEST * rate:
            raise AudioError(f"{path}: is longer than {LONGEST // 3600} hours; cut it in parts")
        yield block


def to_mono(data: bytes, channels: int) -> NDArray[np.float32]:
    """16-bit samples of several channels -> (samples,) in -1..1; an incomplete last frame is dropped."""
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


def level(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """Samples (n,) without an offset, and louder if they are very quiet; most recordings stay as they are."""
    if not len(samples):
        return samples
    mean = samples.mean()
    if abs(mean) > OFFSET * samples.std():
        samples = samples - mean
    peak = float(np.abs(samples).max(initial=0.0))
    return samples * np.float32(LOUD / peak) if 0 < peak < QUIET else samples


def audio_duration(path: Path) -> float:
    """Seconds of a recording by its header, but no more than the file contains. Raises AudioError.

    WAV and FLAC need no extra; AAC and films need the extra `video`, other formats the extra `audio`.
    """
    with _open(path) as file:
        head = file.read(26)
    if head[:4] == b"fLaC" and (seconds := _flac_duration(head)) is not None:
        return seconds
    if found := _wav_durations(path):
        return found[1]
    if path.suffix.lower() in CONTAINERS:
        rate, blocks = open_audio(path, READ)
        return sum(map(len, blocks)) / rate
    with _soundfile(path) as soundfile:
        info = soundfile.info(str(path))
        return float(info.frames / info.samplerate)


def _flac_duration(head: bytes) -> float | None:
    """The STREAMINFO block (RFC 9639, section 8.2): 20 bits of rate, ..., 36 bits of sample count."""
    fields = int.from_bytes(head[18:26], "big")
    rate = fields >> 44
    return (fields & (2**36 - 1)) / rate if rate else None


def _wav_durations(path: Path) -> tuple[float, float] | None:
    """Seconds of a WAV file by its header, and seconds that the file contains; None for any other file."""
    speed = 0  # bytes per second
    with _open(path) as file:
        size = os.fstat(file.fileno()).st_size
        riff = file.read(12)
        while riff[:4] + riff[8:] == b"RIFFWAVE" and len(head := file.read(8)) == 8:
            declared = int.from_bytes(head[4:], "little")
            if head[:4] == b"data":
                there = min(declared, size - file.tell())
                return ((there if declared >= UNTOLD else declared) / speed, there / speed) if speed else None
            body = file.read(FORMAT) if head[:4] == b"fmt " else b""
            if body[:2] in PLAIN:
                speed = int.from_bytes(body[8:12], "little")
            file.seek(declared + declared % 2 - len(body), os.SEEK_CUR)
    return None


def truncation_note(path: Path) -> tuple[str, ...]:
    """A warning when a WAV file contains less than its header says. Raises AudioError."""
    declared, there = _wav_durations(path) or (0.0, 0.0)
    line = f"the recording is truncated: it contains {there:.2f} s of {declared:.2f} s; copy it again"
    return (line,) * (declared - there > SPARE)


@dataclass
class Level:
    """Level statistics of audio that arrives in pieces: samples, the largest, and those at full scale."""

    count: int = 0
    peak: float = 0.0
    full: int = 0

    def add(self, samples: NDArray[np.float32]) -> None:
        """Add the next samples, (n,)."""
        loud = np.abs(samples)
        self.count += len(samples)
        self.peak = max(self.peak, float(loud.max(initial=0.0)))
        self.full += int((loud >= FULL_SCALE).sum())

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the audio, one line each."""
        if self.count == 0:
            return ("no audio was received",)
        if self.peak == 0:
            return ("the audio was silent; check that it is the right one",)
        share = 100 * self.full / self.count
        clipped = f"the audio is clipped: {share:.0f} % of its samples are at full scale; record it quieter"
        return (clipped,) * (share > CLIPPED)


def audio_notes(sound: Sound) -> tuple[str, ...]:
    """Warnings about a recording, one line each."""
    level = Level()
    for begin in range(0, len(sound.samples), BLOCK):
        level.add(sound.samples[begin : begin + BLOCK])
    return level.notes


def _open(path: Path) -> BinaryIO:
    try:
        return open_plain(path)
    except OSError as error:
        raise AudioError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise AudioError(f"{path}: cannot be read: {error}") from error


@contextmanager
def _soundfile(path: Path) -> Iterator[Any]:
    """The soundfile module; its errors are raised as AudioError."""
    try:
        import soundfile
    except ImportError as error:
        needed = "pip install 'phonanim[audio]', or a 16-bit WAV"
        raise MissingExtraError(f"{path}: reading {path.suffix or 'this'} needs {needed}") from error
    try:
        yield soundfile
    except soundfile.LibsndfileError as error:
        reason = error.error_string.rstrip(".")
        raise AudioError(f"{path}: is not a readable recording: {reason}; export it again") from error
