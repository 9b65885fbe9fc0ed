"""Frames in real time: input that stalls, that comes too late or never ends, places that are gone."""

from __future__ import annotations

import itertools
import time
from pathlib import Path
from typing import Any

import numpy as np
from streams import made_up_model, speech

from phonanim.options import Options
from phonanim.stream.engine import PhoneStream
from phonanim.stream.events import End, Event, Phone, Samples
from phonanim.stream.play import Player, report_lines
from phonanim.stream.sound import SoundStream


class Kept:
    """A sink that remembers when frames came, and may fail."""

    def __init__(self, failure: OSError | None = None, after: int = 0) -> None:
        self.where = "memory"
        self.failure, self.after = failure, after
        self.came: list[tuple[float, int]] = []

    def send(self, number: int, time_: float, values: Any) -> None:
        if self.failure and len(self.came) >= self.after:
            raise self.failure
        self.came.append((time.monotonic(), number))

    def close(self) -> None:
        pass


def slowly(events: list[tuple[float, Event]]) -> Any:
    """Events that come when so many seconds have passed."""
    began = time.monotonic()
    for at, event in events:
        time.sleep(max(0, began + at - time.monotonic()))
        yield event


def test_a_stream_that_stalls_goes_on_in_time() -> None:
    sink, said = Kept(), []
    player = Player(PhoneStream(Options(), 0.1), [sink], 60, said.append)
    events = [(0.0, Phone("AA1", 0, 0.2)), (0.8, Phone("M", 0.75, 0.9)), (0.9, End())]
    player.run_in_time(slowly(events), 0.1, 0.1)
    assert [number for _, number in sink.came] == list(range(len(sink.came)))
    assert len(sink.came) >= 55  # a little more where the end was read late
    gaps = np.diff([at for at, _ in sink.came])
    assert gaps.sum() > 0.85
    assert gaps.max() < 0.6  # it did not wait for the phone that came late
    assert said == []
    assert player.tally.frames == len(player.tally.lateness) == len(sink.came)


def test_a_phone_that_comes_too_late_is_told() -> None:
    sink, said = Kept(), []
    player = Player(PhoneStream(Options(), 0.1), [sink], 60, said.append)
    events = [(0.0, Phone("AA1", 0, 0.1)), (0.5, Phone("M", 0.1, 0.2)), (0.6, End())]
    player.run_in_time(slowly(events), 0.1, 0.1)
    assert said == ['phone "M" at 0.1 s arrives after its frames were due; raise the look-ahead']


def test_sound_that_stalls_is_waited_for_and_then_silent(tmp_path: Path) -> None:
    sink, sound = Kept(), Samples(speech(0.4))
    engine = SoundStream(Options(model=str(made_up_model(tmp_path / "cnn", "cnn"))))
    player = Player(engine, [sink], 60, lambda text: None)
    player.run_in_time(slowly([(0.0, sound), (1.0, sound), (1.1, End())]), 0.2, 0.2)
    assert player.tally.stalls >= 1
    assert "the audio stalled" in " ".join(report_lines(player.tally, ["memory"]))
    assert [number for _, number in sink.came] == list(range(len(sink.came)))
    assert len(sink.came) >= 48


def test_a_source_without_end_is_not_read_far_ahead() -> None:
    def endless() -> Any:
        for number in itertools.count():
            yield Phone("AA1", number * 0.1, number * 0.1 + 0.1)

    engine = PhoneStream(Options(), 0.1)
    player = Player(engine, [Kept(BrokenPipeError(), 20)], 60, lambda text: None)
    player.run_in_time(endless(), 0.1, 0.1)
    assert 21 <= player.tally.frames < 600
    assert 5 < engine.known_until < 15
    assert len(engine.known) < 200


def test_a_place_that_is_gone_is_left_out() -> None:
    gone, stays, said = Kept(BrokenPipeError(), 3), Kept(), []
    player = Player(PhoneStream(Options(), 0.1), [gone, stays], 60, said.append)
    player.run(iter([Phone("AA1", 0, 0.5), End()]))
    assert (len(gone.came), len(stays.came)) == (3, 31)
    assert said == ["memory: disconnected; the stream continues without it"]


def test_a_network_that_fails_is_tried_again() -> None:
    failing, said = Kept(OSError(101, "Network is unreachable")), []
    player = Player(PhoneStream(Options(), 0.1), [failing], 60, said.append)
    player.run(iter([Phone("AA1", 0, 0.5), End()]))
    assert said == ["memory: a frame could not be sent (Network is unreachable); trying again"]
    assert player.sinks == [failing]
