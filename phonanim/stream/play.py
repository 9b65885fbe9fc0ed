"""The stream itself: events in, frames out, at once or as they fall due."""

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

LEAD = 0.004  # seconds before a frame is due that it is made
AHEAD = 5.0  # seconds that may be known beyond the clock; what comes sooner waits, so that memory stays flat
WAITING = 1000  # events that wait to be taken
MOST_TOLD = 20  # problems that are told one by one
TOLD = 100_000  # frames whose lateness is kept, the last ones
Floats = NDArray[np.float32]


class Engine(Protocol):
    """What makes frames: `PhoneStream` or `SoundStream`."""

    emitted: int
    ended: bool
    rig: Rig

    @property
    def patience(self) -> float:
        """Seconds that a frame which is due waits for what decides it."""

    @property
    def known_until(self) -> float:
        """Seconds that are known."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What is odd about all that came, for the end."""

    @property
    def ready(self) -> int:
        """Frames that may be given out."""

    def warm_up(self) -> None:
        """Make a frame that nobody sees."""

    def take(self, event: Event) -> None:
        """Take an event. Raises StreamError or LabelError when it makes no sense."""

    def pass_time(self, now: float) -> None:
        """Say that it is `now` seconds."""

    def end(self) -> None:
        """Say that nothing more will come."""

    def frames(self, most: int | None = None) -> Floats:
        """Frames that may be given out, (frames, controls)."""


@dataclass
class StreamStatistics:
    """What became of a stream. `late` frames left after the next one was due; times in seconds."""

    frames: int = 0
    late: int = 0
    problems: int = 0
    stalls: int = 0
    lateness: list[float] = field(default_factory=list)
    work: float = 0.0  # of the processor, for all frames

    def note(self, lateness: float, period: float) -> None:
        """A frame left so many seconds after it was due."""
        self.late += lateness > period
        if len(self.lateness) < TOLD:
            self.lateness.append(lateness)
        else:
            self.lateness[self.frames % TOLD] = lateness


@dataclass
class Player:
    """An engine, the sinks that its frames go to, and `say`, which tells people of problems."""

    engine: Engine
    sinks: list[Sink]
    fps: float
    say: Callable[[str], None]
    tally: StreamStatistics = field(default_factory=StreamStatistics)
    silent: set[str] = field(default_factory=set)  # sinks whose trouble was told

    def run(self, events: Iterator[Event]) -> None:
        """Give out every frame as soon as it is decided."""
        for event in events:
            self.take(event)
            self.give()
            if self.engine.ended or not self.sinks:
                return
        self.engine.end()
        self.give()

    def run_in_time(self, events: Iterator[Event], look_ahead: float, delay: float) -> None:
        """Give out frame n when n / fps + `delay` seconds have passed since the first event came.

        What is not known `look_ahead` seconds beyond it by then counts as silence.
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
            # Whoever was held up makes all that is due at once, which costs little more than one frame.
            behind = max(0, int((time.monotonic() - due) * self.fps))
            if self.engine.ready <= behind and not self.engine.ended:
                self._hurry(waiting, due, second + behind / self.fps + look_ahead)
            if self.engine.ready:
                self.give(1 + behind, due)
            elif self.engine.ended:
                return

    def take(self, event: Event) -> None:
        """Take an event, or tell what is wrong with it."""
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

    def give(self, most: int | None = None, due: float | None = None) -> int:
        """Make the frames that may be given out, and send them, not before `due`; how many there were."""
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
        """Send a frame everywhere; a place that is gone is left out from now on."""
        self.tally.frames += 1
        for sink in tuple(self.sinks):
            try:
                sink.send(number, number / self.fps, values)
            except (BrokenPipeError, ConnectionError):
                self.say(f"{sink.where}: nobody is there any more; the stream goes on without it")
                self.sinks.remove(sink)
            except OSError as error:
                if sink.where not in self.silent:
                    self.say(f"{sink.where}: a frame could not be sent ({error.strerror}); trying on")
                self.silent.add(sink.where)

    def report_problem(self, text: str) -> None:
        """Tell a problem, but not for ever."""
        self.tally.problems += 1
        if self.tally.problems <= MOST_TOLD:
            self.say(text)
        if self.tally.problems == MOST_TOLD:
            self.say("further problems are counted, and not told")

    def _wait(self, waiting: Queue[Event | PhonanimError], until: float, start: float) -> None:
        """Take events until a moment, or those that have come; those far ahead of the clock wait for it."""
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
        """A frame is due that is not decided: wait as long as the engine would; then the rest is silent."""
        patience = self.engine.patience
        if (left := due + patience - time.monotonic()) > 0 and patience:
            with suppress(Empty):
                self.take(unwrap_event(waiting.get(timeout=left)))
            return
        self.tally.stalls += patience > 0
        self.engine.pass_time(needed + patience)


def read_in_thread(events: Iterator[Event]) -> Queue[Event | PhonanimError]:
    """Events as another thread reads them; an error that ends them comes last."""
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
    """An event. Raises the error that came instead of one."""
    if isinstance(item, PhonanimError):
        raise item
    return item


def sleep_until(until: float) -> None:
    """Sleep until a moment of the monotonic clock."""
    left = until - time.monotonic()
    if left > 0:
        time.sleep(left)


def report_lines(tally: StreamStatistics, places: list[str]) -> list[str]:
    """What became of a stream, for people."""
    each = 1000 * tally.work / max(tally.frames, 1)
    lines = [f"sent {tally.frames} frames to {', '.join(places)}; {each:.2f} ms of the processor for each"]
    if tally.lateness:
        most = 1000 * float(np.quantile(tally.lateness, 0.999))
        lines.append(f"{tally.late} frames were late; 99.9 % left within {most:.1f} ms of when they were due")
    if tally.stalls:
        lines.append(f"the sound stalled {tally.stalls} times and counted as silence")
    if tally.problems:
        lines.append(f"{tally.problems} problems with what came in")
    return lines
