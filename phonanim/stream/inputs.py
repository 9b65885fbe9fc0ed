"""Sources of events: lines of JSON, an alignment file, a recording, raw samples, a microphone."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from phonanim.core.files import open_plain
from phonanim.errors import AlignmentError, AudioError, MissingExtraError, StreamError
from phonanim.inputs.speech_input import read_with_options
from phonanim.media.audio import open_audio, to_mono, truncation_note
from phonanim.options import Options
from phonanim.speech.alignment import Interval
from phonanim.speech.reading import find_reading_language
from phonanim.stream.events import End, Event, Phone, Problem, Samples, Tick, parse_event

BLOCK = 0.01  # seconds of microphone audio at a time
READ = 0.1  # seconds of a recording at a time
CHUNK = 1 << 14  # bytes at a time
LONGEST_LINE = 1 << 16  # bytes of a line of JSON


def json_lines(source: int) -> Iterator[Event]:
    """Lines of JSON from a file descriptor, as they arrive; a line in none of the forms is a Problem."""
    for line in _lines(source):
        if line is None:
            yield Problem(f"a line is longer than {LONGEST_LINE} bytes and is ignored")
        elif line.strip():
            yield _event(line)
    yield End()


def _event(line: bytes) -> Event:
    try:
        return parse_event(line.decode("utf-8", "replace"))
    except StreamError as error:
        return Problem(str(error))


def _lines(source: int) -> Iterator[bytes | None]:
    """Lines without their ends; None for one that is too long."""
    rest, dropping = b"", False
    while chunk := os.read(source, CHUNK):
        *whole, rest = (rest + chunk).split(b"\n")
        for line in whole:
            if not dropping:
                yield line if len(line) <= LONGEST_LINE else None
            dropping = False
        if len(rest) > LONGEST_LINE:
            if not dropping:
                yield None
            rest, dropping = b"", True
    if rest and not dropping:
        yield rest


def alignment_file(path: Path, options: Options) -> tuple[str, tuple[Interval, ...], float, Iterator[Event]]:
    """The language of an alignment's labels, its words, its offset in a recording, and its phones.

    Raises AlignmentError.
    """
    alignment = read_with_options(path, options)
    language = find_reading_language(alignment, options.language, options.fallback).language.full_name

    def events() -> Iterator[Event]:
        for interval in alignment.intervals:
            yield Phone(interval.label, interval.start, interval.end)
        yield Tick(alignment.duration)
        yield End()

    return language, alignment.words, alignment.offset, events()


def with_recording(events: Iterator[Event], path: Path, offset: float) -> tuple[int, Iterator[Event]]:
    """The rate of a recording, and phones with the audio until their ends before them.

    The alignment begins `offset` seconds into the recording. Raises AudioError.
    """
    rate, blocks = open_audio(path, READ)

    def merged() -> Iterator[Event]:
        skipped, given = round(offset * rate), 0
        for event in events:
            until = event.end if isinstance(event, Phone) else event.time if isinstance(event, Tick) else 0.0
            try:
                while given < until * rate and (block := next(blocks, None)) is not None:
                    kept, skipped = block[skipped:], max(skipped - len(block), 0)
                    given += len(kept)
                    yield Samples(kept)
            except AudioError as error:  # the rest counts as silence
                yield Problem(str(error))
            yield event

    return rate, merged()


def recording(path: Path) -> tuple[int, Iterator[Event]]:
    """The rate of a recording, and its audio in blocks; channels are averaged. Raises AudioError."""
    rate, blocks = open_audio(path, READ)

    def events() -> Iterator[Event]:
        for block in blocks:
            yield Samples(block)
        yield from map(Problem, truncation_note(path))
        yield End()

    return rate, events()


def raw_samples(source: int, channels: int) -> Iterator[Event]:
    """16-bit little-endian samples from a file descriptor, as they arrive; channels are averaged.

    Raises AudioError when it is a WAV file.
    """
    width, rest, first = 2 * channels, b"", True
    while chunk := os.read(source, CHUNK):
        data = rest + chunk
        if first and data[:4] in (b"RIFF", b"fLaC", b"OggS"):
            raise AudioError("stdin: is a sound file, not raw samples; name the file instead of -")
        first = first and len(data) < 4
        whole = len(data) // width * width
        rest = data[whole:]
        if whole:
            yield Samples(to_mono(data[:whole], channels))
    if rest:
        yield Problem(f"the last {len(rest)} bytes are not a whole sample and are ignored")
    yield End()


def microphone(device: str | None, rate: int) -> Iterator[Event]:
    """Audio from a microphone, without end. Raises MissingExtraError, AudioError."""
    sounddevice = _sounddevice()
    events: SimpleQueue[Event] = SimpleQueue()

    def callback(data: Any, frames: int, time: Any, status: Any) -> None:
        if status:
            events.put(Problem(f"the microphone: {status}"))
        events.put(Samples(data[:, 0].copy()))

    named = int(device) if device and device.isdecimal() else device or None
    try:
        stream = sounddevice.InputStream(
            rate, round(BLOCK * rate), named, channels=1, dtype="float32", callback=callback
        )
        with stream:
            while True:
                yield events.get()
    except (sounddevice.PortAudioError, ValueError) as error:
        what = " ".join(str(error).split())
        raise AudioError(f"the microphone cannot be opened ({what}); name another device") from error


def _sounddevice() -> Any:
    try:
        import sounddevice
    except ImportError as error:
        raise MissingExtraError("a microphone needs pip install 'phonanim[stream]'") from error
    except OSError as error:
        raise AudioError(
            f"a microphone needs the PortAudio library ({error}); install it: apt install libportaudio2, "
            "dnf install portaudio, or brew install portaudio"
        ) from error
    return sounddevice


def is_lines(path: Path) -> bool:
    """Whether a file has lines of JSON instead of an alignment, by its name or its first bytes."""
    if path.suffix.lower() in (".jsonl", ".ndjson"):
        return True
    try:
        with open_plain(path) as file:
            return _is_event(file.readline(LONGEST_LINE))
    except ValueError as error:
        raise AlignmentError(f"{path}: {error}") from error


def _is_event(line: bytes) -> bool:
    try:
        parse_event(line.decode("utf-8", "replace"))
    except StreamError:
        return False
    return True
