"""Run a stream: events in, frames out, at once or in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from queue import Empty, Queue
from threading import Thread
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import LabelError, PhonanimError, StreamError
from phonanim.rig import Rig
from phonanim.stream.events import End, Event, Problem
from phonanim.stream.sinks import Sink

LEAD = 0.004  # seconds before its due time that a frame is made
AHEAD = 5.0  # seconds that events may be ahead of the clock; later ones wait, so that memory does not grow
WAITING = 1000  # events in the queue
MOST_TOLD = 20  # problems that are reported one by one
REST = 0.25  # seconds from the last frame to rest, when a stream is interrupted
TOLD = 100_000  # last frames whose lateness is kept
Floats = NDArray[np.float32]


class Engine(Protocol):
    """The protocol of a frame source: `PhoneStream` or `SoundStream`."""

    rig: Rig

    @property
    def emitted(self) -> int:
        """Number of frames that were made."""

    @property
    def ended(self) -> bool:
        """Whether the input has ended."""

    @property
    def patience(self) -> float:
        """Seconds that a due frame waits for its input."""

    @property
    def known_until(self) -> float:
        """Seconds of known input."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the whole input, for the end."""

    @property
    def ready(self) -> int:
        """Number of frames that may be released."""

    def warm_up(self) -> None:
        """Make a frame and discard it."""

    def news(self) -> str:
        """What people should know now, once; "" for nothing."""

    def take(self, event: Event) -> None:
        """Process an event. Raises StreamError or LabelError when it is invalid."""

    def pass_time(self, now: float) -> None:
        """Set the time to `now` seconds."""

    def end(self) -> None:
        """Declare the end of the input."""

    def frames(self, most: int | None = None) -> Floats:
        """Frames that may be released, (frames, controls)."""


@dataclass
class StreamStatistics:
    """Statistics of a stream. `late` frames were sent after the next one was due; times in seconds."""

    frames: int = 0
    late: int = 0
    problems: int = 0
    stalls: int = 0
    lateness: list[float] = field(default_factory=list)
    work: float = 0.0  # processor time for all frames

    def note(self, lateness: float, period: float) -> None:
        """Record that a frame was sent `lateness` seconds after it was due."""
        self.late += lateness > period
        if len(self.lateness) < TOLD:
            self.lateness.append(lateness)
        else:
            self.lateness[self.frames % TOLD] = lateness


@dataclass
class Player:
    """An engine, the sinks of its frames, `say` for problems that people should know, and `tell` for news."""

    engine: Engine
    sinks: list[Sink]
    fps: float
    say: Callable[[str], None]
    tally: StreamStatistics = field(default_factory=StreamStatistics)
    silent: set[str] = field(default_factory=set)  # sinks whose problem was reported
    tell: Callable[[str], None] | None = None
    last: tuple[int, Floats] | None = None  # the frame that was sent last

    def go_to_rest(self) -> None:
        """Send the way from the last frame to rest, for a stream that is interrupted."""
        if self.last is None:
            return
        number, values = self.last
        rest = self.engine.rig.rest.astype(np.float32)
        frames = max(round(REST * self.fps), 1)
        began = time.monotonic()
        for frame in range(1, frames + 1):
            share = np.float32((1 - np.cos(np.pi * frame / frames)) / 2)
            self.send(number + frame, values + (rest - values) * share)
            sleep_until(began + min(frame / self.fps, REST))

    def run(self, events: Iterator[Event]) -> None:
        """Send every frame as soon as it is decided."""
        for event in events:
            self.take(event)
            self.give()
            if self.engine.ended or not self.sinks:
                return
        self.engine.end()
        self.give()

    def run_in_time(self, events: Iterator[Event], look_ahead: float, delay: float) -> None:
        """Send frame n when n / fps + `delay` seconds have passed since the first event.

        Input up to `look_ahead` seconds after the frame that is unknown by then counts as silence.
        """
        self.engine.warm_up()
        waiting = read_in_thread(events)
        while not self.engine.ended and self.engine.known_until == 0:
            self.take(unwrap_event(waiting.get()))
        start = time.monotonic()
        while self.sinks:
            second = self.engine.emitted / self.fps
            due = start + second + delay
            self._wait(waiting, due - LEAD, start)
            # After a delay, all due frames are made at once, which costs little more than one frame.
            behind = max(0, int((time.monotonic() - due) * self.fps))
            if self.engine.ready <= behind and not self.engine.ended:
                self._hurry(waiting, due, second + behind / self.fps + look_ahead)
            if self.engine.ready:
                self.give(1 + behind, due)
            elif self.engine.ended:
                return

    def take(self, event: Event) -> None:
        """Process an event, or report why it is invalid."""
        if isinstance(event, Problem):
            self.report_problem(event.text)
        elif isinstance(event, End):
            self.engine.end()
        elif not self.engine.ended:
            began = time.thread_time()
            try:
                self.engine.take(event)
            except (StreamError, LabelError) as error:
                self.report_problem(str(error))
            self.tally.work += time.thread_time() - began
            if news := self.engine.news():
                (self.tell or self.say)(news)

    def give(self, most: int | None = None, due: float | None = None) -> int:
        """Make the frames that may be released and send them, not before `due`; returns their number."""
        began = time.thread_time()
        first = self.engine.emitted
        values = self.engine.frames(most)
        self.tally.work += time.thread_time() - began
        for number, row in enumerate(values, start=first):
            own = None if due is None else due + (number - first) / self.fps
            if own is not None:
                sleep_until(own)
            self.send(number, row)
            if own is not None:
                self.tally.note(time.monotonic() - own, 1 / self.fps)
        return len(values)

    def send(self, number: int, values: Floats) -> None:
        """Send a frame to all sinks; a sink that is disconnected is left out from now on."""
        self.tally.frames += 1
        self.last = number, values
        for sink in tuple(self.sinks):
            try:
                sink.send(number, number / self.fps, values)
            except (BrokenPipeError, ConnectionError):
                self.say(f"{sink.where}: disconnected; the stream continues without it")
                self.sinks.remove(sink)
            except OSError as error:
                if sink.where not in self.silent:
                    self.say(f"{sink.where}: a frame could not be sent ({error.strerror}); trying again")
                self.silent.add(sink.where)

    def report_problem(self, text: str) -> None:
        """Report a problem, up to a limit."""
        self.tally.problems += 1
        if self.tally.problems <= MOST_TOLD:
            self.say(text)
        if self.tally.problems == MOST_TOLD:
            self.say("further problems are counted, but not reported")

    def _wait(self, waiting: Queue[Event | PhonanimError], until: float, start: float) -> None:
        """Process events until a moment, or those in the queue; those far ahead of the clock wait for it."""
        for _ in range(WAITING):
            left = until - time.monotonic()
            if self.engine.ended or self.engine.known_until > time.monotonic() - start + AHEAD:
                break
            try:
                self.take(unwrap_event(waiting.get(left > 0, max(left, 0.0))))
            except Empty:
                return
        sleep_until(until)

    def _hurry(self, waiting: Queue[Event | PhonanimError], due: float, needed: float) -> None:
        """A due frame is not decided: wait as long as the engine allows; then the rest counts as silence."""
        patience = self.engine.patience
        if (left := due + patience - time.monotonic()) > 0 and patience:
            with suppress(Empty):
                self.take(unwrap_event(waiting.get(timeout=left)))
            return
        self.tally.stalls += patience > 0
        self.engine.pass_time(needed + patience)


def read_in_thread(events: Iterator[Event]) -> Queue[Event | PhonanimError]:
    """Read events in another thread; an error that ends them is the last item."""
    waiting: Queue[Event | PhonanimError] = Queue(WAITING)

    def read() -> None:
        try:
            for event in events:
                waiting.put(event)
        except PhonanimError as error:
            waiting.put(error)
        except OSError as error:
            waiting.put(StreamError(f"the input cannot be read: {error.strerror or error}"))

    Thread(target=read, daemon=True).start()
    return waiting


def unwrap_event(item: Event | PhonanimError) -> Event:
    """An event. Raises the error if the item is one."""
    if isinstance(item, PhonanimError):
        raise item
    return item


def sleep_until(until: float) -> None:
    """Sleep until a moment of the monotonic clock."""
    left = until - time.monotonic()
    if left > 0:
        time.sleep(left)


def report_lines(tally: StreamStatistics, places: list[str]) -> list[str]:
    """The statistics of a stream as lines for people."""
    each = 1000 * tally.work / max(tally.frames, 1)
    lines = [f"sent {tally.frames} frames to {', '.join(places)}; {each:.2f} ms of the processor for each"]
    if tally.lateness:
        most = 1000 * float(np.quantile(tally.lateness, 0.999))
        lines.append(
            f"{tally.late} frames were late; 99.9 % were sent within {most:.1f} ms of their due time"
        )
    if tally.stalls:
        lines.append(f"the audio stalled {tally.stalls} times and counted as silence")
    if tally.problems:
        lines.append(f"{tally.problems} problems in the input")
    return lines
