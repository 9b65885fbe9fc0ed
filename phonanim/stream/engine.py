"""Stream phones through a phone-driven model: each frame equals that of the whole line."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.motion import predict_controls
from phonanim.errors import LabelError, OptionError, StreamError
from phonanim.features.context import EDGES
from phonanim.life import AHEAD, life_of
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, model_with_settings
from phonanim.regressors import NEEDS
from phonanim.speech.alignment import ROUNDING, Alignment, Interval
from phonanim.speech.labels import is_silent
from phonanim.speech.language import to_phones
from phonanim.speech.loudness import Loudness
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.prosody import Prosody
from phonanim.stream.events import Event, Phone, Samples, Tick
from phonanim.stream.language import StreamedLanguage
from phonanim.stream.life import StreamedLife, StreamedProsody, StreamedVoice
from phonanim.stream.loudness import StreamedLoudness
from phonanim.stream.own import own_motion

REACH = float(EDGES[-1])  # seconds to either side that the features use
BEYOND = 3  # segments after the current one that their timing uses, including a closure's release
ABREAST = 1e-6  # frames: an instant that is ahead by less counts as reached
LONGEST = 600.0  # seconds that may pass at once; more is a wrong unit
EMPTY = Interval("", 0.0, 0.0)


@dataclass
class PhoneStream:
    """Phones in, frames out, in the order of time.

    Frame n is at n / fps. With `look_ahead` None, a frame is released when no later phone can change it: when
    phones are known for 0.8 s and three segments after it. A number of seconds limits the wait instead: the
    frame is then released when phones are known, or time has passed, for so long after it, and the unknown
    part counts as silence. Memory use does not grow, because the past is dropped. `line` is the name for the
    seed of the life layer; `words` are the line's words, if they are known in advance. `rate` is that of the
    recording, in hertz, if audio arrives with the phones; the mouth then follows its level.
    """

    options: Options
    look_ahead: float | None = None
    line: str = "stream"
    words: tuple[Interval, ...] = ()
    rate: int | None = None
    emitted: int = 0
    ended: bool = False
    now: float = 0.0
    ticked: float = 0.0
    known: list[Interval] = field(default_factory=list)
    begun: Interval | None = None  # a phone that has begun, until now
    patience: ClassVar[float] = 0.0  # seconds that a due frame waits for a phone

    def __post_init__(self) -> None:
        self.language = StreamedLanguage(self.options.language)
        self.options = replace(self.options, language=self.language.name)
        reject_whole_line_layers(self.options)
        self.model = model_with_settings(self.options)
        self.own = own_motion(self.model, self.options)
        self.rig = self.own.rig if self.own else load_cached_rig(self.options.rig)
        modality = self.model.regressor.input_modality
        if modality == "both":
            raise OptionError(
                f"model {self.options.model} needs {NEEDS[modality]}, and cannot be streamed; choose another"
            )
        life = life_of(self.options, self.line)
        ahead = AHEAD if self.look_ahead is None else min(self.look_ahead, AHEAD)
        self.felt = StreamedProsody(self.options, self.words, ahead)
        streamed = StreamedLife(life, self.rig, self.options.fps, self._prosody)
        lives = self.own is None or self.own.lives
        self.life = streamed if lives and life.moves(self.rig) else None
        follows = self.rate is not None and self.options.loudness > 0 and self.own is None
        self.voice_stream = StreamedVoice(self.rate, ahead) if self.rate is not None and follows else None
        self.level = StreamedLoudness(self.options.level, ahead)
        if modality == "audio":
            raise OptionError(f"model {self.options.model} is audio-driven; stream audio to it, not phones")

    @property
    def known_until(self) -> float:
        """End of the last phone, or of the time that has passed without one, in seconds."""
        return max(self.now, self.known[-1].end if self.known else 0.0)

    @property
    def ready(self) -> int:
        """Number of frames that may be released."""
        return max(self._due() - self.emitted, 0)

    @property
    def notes(self) -> tuple[str, ...]:
        """A note when no phone was received, and on the language if that is unsure."""
        own = self.own.notes if self.own else ()
        return (*("no phone was received",) * (self.known_until == 0), *self.language.doubt(), *own)

    def news(self) -> str:
        """The language, as soon as it is settled by the labels; "" before that and afterwards."""
        return self.language.news()

    def warm_up(self) -> None:
        """Make a frame and discard it, so that the first real one is as fast as the others."""
        other = PhoneStream(self.options, 0.0)
        StreamedLanguage("auto").add("m")  # reads the tables of labels
        other.pass_time(0.1)
        other.frames()

    def take(self, event: Event) -> None:
        """Process a phone or the time. Raises StreamError or LabelError, and then ignores the event."""
        if isinstance(event, Phone):
            self.push(event.label, event.start, event.end)
        elif isinstance(event, Tick):
            self.tick(event.time)
        elif isinstance(event, Samples) and self.voice_stream is not None:
            self.voice_stream.push(np.nan_to_num(event.values, nan=0.0, posinf=0.0, neginf=0.0))

    def push(self, label: str, start: float, end: float) -> None:
        """Add the next phone. Raises StreamError when its times are invalid, and then ignores the phone.

        Raises LabelError when it is unknown in the language.
        """
        if not (math.isfinite(start) and math.isfinite(end)) or end <= start or start < 0:
            raise StreamError(f'phone "{label}" from {start:g} to {end:g} s: has no duration; send it again')
        last = self.known[-1] if self.known else EMPTY
        if Interval(label, start, end) == last:
            raise StreamError(f'phone "{label}" at {start:g} s was sent twice; the second is left out')
        if start < last.end - ROUNDING:
            raise StreamError(
                f'phone "{label}" at {start:g} s begins before the last one ends ({last.end:g} s); '
                "phones must arrive in the order of time"
            )
        if end * self.options.fps < self.emitted:
            raise StreamError(
                f'phone "{label}" at {start:g} s arrives after its frames were due; raise the look-ahead'
            )
        self._refuse_leap(end, f'phone "{label}" at {start:g} s')
        self._check_label(label, start, end)
        self.known.append(Interval(label, max(start, last.end), end))
        if self.life is not None:
            self.felt.intervals.append(self.known[-1])

    def _check_label(self, label: str, start: float, end: float) -> None:
        """Raise LabelError for a label that is unknown in the language, which it may help to find."""
        named = self.language.add(label)
        one = Alignment((Interval(label, 0.0, end - start),), end - start, "stream", "the stream")
        try:
            to_phones(replace(one, offset=start), named, self.options.unknown)
        except LabelError:
            self.language.forget(label)
            raise
        if named != self.options.language:
            self.options = replace(self.options, language=named)
            self.felt.options = self.options

    def tick(self, now: float) -> None:
        """Set the source's clock. Raises StreamError, without setting it, for a step back or far ahead."""
        if now < self.ticked:
            raise StreamError(f"the time went back from {self.ticked:g} to {now:g} s and is ignored")
        self._refuse_leap(now, f"the time {now:g} s")
        self.ticked = now
        self.pass_time(now)

    def _refuse_leap(self, time: float, what: str) -> None:
        reached = max(self.known_until, self.emitted / self.options.fps)
        if time > reached + LONGEST:
            raise StreamError(
                f"{what} is {time - reached:g} s ahead, and at most {LONGEST:g} s may pass at once; "
                "times are in seconds"
            )

    def pass_time(self, now: float) -> None:
        """Set the time to `now` seconds: no phone will arrive that ends before it, less the look-ahead."""
        self.now = max(self.now, now)

    def end(self) -> None:
        """Declare the end of the input."""
        self.ended = True

    def frames(self, most: int | None = None) -> NDArray[np.float32]:
        """Frames released since the last call, all or the first `most`, (frames, controls)."""
        ready = self.ready
        count = ready if most is None else min(ready, most)
        if count <= 0:
            return np.empty((0, len(self.rig.controls)), np.float32)
        alignment, origin = self._window(self.emitted, self.emitted + count)
        track, _ = to_phones(alignment, self.options.language, self.options.unknown)
        start = self.emitted / self.options.fps - origin
        values = self._move(track, origin, start, count)
        if self.life is not None:
            values = self.life.add(values, self.emitted, self.emitted + ready)
        self.emitted += count
        self._forget()
        return values

    def _move(self, track: PhoneTrack, origin: float, start: float, count: int) -> NDArray[np.float32]:
        """The controls of the next frames, from `start` seconds of their track."""
        if self.own:
            times = start + np.arange(count) / self.options.fps
            return self.own.move(self.model.predict(track, self.options.fps, count, start), track, times)
        loudness = self._loudness(track, origin, count)
        motion = predict_controls(track, self.model, self.rig, self.options, count, start, loudness=loudness)
        return motion.values

    def _loudness(self, track: PhoneTrack, origin: float, count: int) -> Loudness | None:
        """The level of the next frames, on the clock of their track."""
        if self.voice_stream is None:
            return None
        fps = self.options.fps
        voice = self.voice_stream.analyze(self.emitted / fps, self.ended)
        return self.level.until((self.emitted + count) / fps, voice, track, origin)

    def _prosody(self, time: float) -> tuple[Prosody, PhoneTrack]:
        return self.felt.prosody(time, max(self.known_until, time), self.ended)

    def _due(self) -> int:
        """Number of frames, from the start, that may be released."""
        fps = self.options.fps
        if self.known_until == 0:
            return 0
        if self.ended:
            return math.floor(self.known_until * fps + ABREAST) + 1
        if self.look_ahead is not None:
            return max(math.floor((self.known_until - self.look_ahead) * fps + ABREAST) + 1, self.emitted)
        certain = self.known[-1].end - REACH if self.known else -1.0
        spoken = [i for i in self.known if not is_silent(i.label)]
        beyond = spoken[-BEYOND - 1].start if len(spoken) > BEYOND else -1.0
        return max(math.floor(min(certain, beyond) * fps + ABREAST), self.emitted)

    def _window(self, first: int, last: int) -> tuple[Alignment, float]:
        """The phones that affect some frames, on a clock that starts with the first of them."""
        begin = self._felt_from(first / self.options.fps)
        felt = self.known[begin:] + ([self.begun] if self.begun else [])
        origin = felt[0].start if begin else 0.0
        # The unknown part counts as silence, as far as features use it.
        unknown = max(self.known_until, last / self.options.fps) + REACH
        duration = self.known_until if self.ended else unknown
        moved = tuple(Interval(i.label, i.start - origin, i.end - origin) for i in felt)
        return Alignment(moved, duration - origin, "stream", "the stream"), origin

    def _felt_from(self, time: float) -> int:
        """Index of the first phone that affects an instant."""
        before, index = 0, len(self.known)
        while index > 0 and before <= BEYOND:
            index -= 1
            past = self.known[index].end < time - REACH
            before += past and not is_silent(self.known[index].label)
        return index

    def _forget(self) -> None:
        self.known = self.known[self._felt_from(self.emitted / self.options.fps) :]


def reject_whole_line_layers(options: Options) -> None:
    """Raise OptionError for a layer that needs a whole line."""
    wholes = {
        "--smooth": bool(options.smooth),
        "--retarget solve": options.retarget == "solve",
        "--overlay": bool(options.overlays),
        "--pitch praat": options.pitch == "praat",
    }
    for name, asked in wholes.items():
        if asked:
            raise OptionError(f"{name} needs a whole line and cannot be streamed; leave it out")
