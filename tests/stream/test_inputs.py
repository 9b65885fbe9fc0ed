"""What a live stream reads: raw samples, lines of JSON, a microphone."""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np
import pytest

from phonanim.errors import AudioError, MissingExtraError, StreamError
from phonanim.stream import inputs
from phonanim.stream.events import End, Phone, Problem, Samples, Tick, parse_event

LINES = b"""{"phone": "HH", "start": 0.1, "end": 0.2}
{"phone": "AA1", "start": 0.2, "end": 0.4}
{"time": 0.5}
{"end": true}
{"time": 7}

x"""


def piped(data: bytes) -> int:
    """A descriptor to read so many bytes from."""
    read, write = os.pipe()
    os.write(write, data)
    os.close(write)
    return read


def test_a_sound_file_is_no_raw_samples() -> None:
    with pytest.raises(
        AudioError, match="stdin: is a sound file, not raw samples; name the file instead of -"
    ):
        list(inputs.raw_samples(piped(b"RIFF1234WAVE" + bytes(40)), 1))


def test_channels_of_raw_samples_are_averaged() -> None:
    data = np.array([[100, 300], [0, -200]], "<i2").tobytes()
    first, end = inputs.raw_samples(piped(data), 2)
    assert isinstance(first, Samples)
    assert isinstance(end, End)
    np.testing.assert_allclose(first.values * 32768, [200, -100])


def test_lines_that_come_in_pieces() -> None:
    found = list(inputs.json_lines(piped(LINES)))
    assert found[:3] == [Phone("HH", 0.1, 0.2), Phone("AA1", 0.2, 0.4), Tick(0.5)]
    assert found[4] == Tick(7.0)
    assert isinstance(found[5], Problem)
    assert found[6] == End()


def test_an_event_is_read_or_refused() -> None:
    assert parse_event('{"end": true}') == End()
    with pytest.raises(StreamError, match="a line is none of"):
        parse_event('{"end": false}')
    with pytest.raises(StreamError, match="a line is none of"):
        parse_event("[1]")


def test_microphones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(MissingExtraError, match=r"a microphone needs pip install 'phonanim\[stream\]'"):
        next(inputs.microphone(None, 16000))


class Device:
    """What stands for the sounddevice module: a microphone that gives two blocks."""

    class PortAudioError(Exception):
        pass

    def __init__(self, failure: str = "") -> None:
        self.failure = failure

    def InputStream(self, rate: int, block: int, device: Any, callback: Any, **more: Any) -> Any:  # noqa: N802
        if self.failure:
            raise self.PortAudioError(self.failure)
        self.callback, self.block, self.device = callback, block, device
        return self

    def __enter__(self) -> None:
        for status in ("", "input overflow"):
            self.callback(np.full((self.block, 1), 0.5, np.float32), self.block, None, status)

    def __exit__(self, *error: object) -> None:
        pass


def test_a_microphone(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Device()
    monkeypatch.setitem(sys.modules, "sounddevice", device)
    events = inputs.microphone("3", 16000)
    first, problem, second = (next(events) for _ in range(3))
    assert isinstance(first, Samples)
    assert isinstance(second, Samples)
    assert (len(first.values), device.device) == (160, 3)
    assert problem == Problem("the microphone: input overflow")


def test_a_microphone_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", Device("no default\n input device"))
    with pytest.raises(
        AudioError, match=r"the microphone cannot be opened \(no default input device\); name another device"
    ):
        next(inputs.microphone(None, 16000))


def test_a_machine_without_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(name: str, *more: Any) -> Any:
        if name == "sounddevice":
            raise OSError("PortAudio library not found")
        return real(name, *more)

    real = __import__
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr("builtins.__import__", refuse)
    with pytest.raises(
        AudioError, match=r"a microphone needs the PortAudio library \(PortAudio library not f"
    ):
        next(inputs.microphone(None, 16000))
