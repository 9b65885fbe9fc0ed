"""Stream sound through phones that are recognized in it: the engine of models that recognize phones."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import StreamError
from phonanim.media.audio import Level
from phonanim.options import Options
from phonanim.pipeline import load_model
from phonanim.recognition.network import load_network
from phonanim.recognition.recognizer import LANGUAGE, PhoneRecognizer, look_ahead
from phonanim.recognition.spectrum import RATE, VoiceMean
from phonanim.speech.intervals import Interval
from phonanim.stream.engine import PhoneStream
from phonanim.stream.events import Event, Samples
from phonanim.stream.resampling import Resampler

Floats = NDArray[np.float32]

GOES_ON = 0.03  # seconds that a phone that has begun is taken to go on


@dataclass
class RecognizedStream:
    """Sound in, frames out, by the phones that are recognized in it, as a `PhoneStream` makes them.

    `ahead` is the number of seconds of sound after a frame that it waits for, the time that recognition takes
    included; None waits until no later sound can change it. The phone that is being spoken counts as far as
    it is known. `line` is the name for the seed of the life layer. `mean` is that of the voice at the start,
    which knows the loudest step of a recording (`voice_mean`) and of no other sound.
    """

    options: Options
    rate: int = RATE
    ahead: float | None = None
    line: str = "stream"
    mean: VoiceMean = field(default_factory=VoiceMean)
    level: Level = field(default_factory=Level)
    spoken: bool = False  # whether a phone was recognized
    patience: ClassVar[float] = 0.25  # seconds that a due frame waits for its audio

    def __post_init__(self) -> None:
        model = load_model(self.options.model)
        assert model.recognizer is not None
        network = load_network(model.recognizer)
        self.recognizer, self.resampler = PhoneRecognizer(network, mean=self.mean), Resampler(self.rate)
        self.slowest = look_ahead(network)
        phones_ahead = None if self.ahead is None else max(self.ahead - self.slowest, 0.0)
        options = replace(self.options, language=LANGUAGE)
        self.phones = PhoneStream(options, phones_ahead, self.line, rate=self.rate)
        self.rig = self.phones.rig

    @property
    def look_ahead(self) -> float | None:
        """Seconds of sound after a frame that it waits for; None where it waits for phones."""
        return None if self.ahead is None else max(self.ahead, self.slowest)

    @property
    def emitted(self) -> int:
        """Number of frames that were made."""
        return self.phones.emitted

    @property
    def ended(self) -> bool:
        """Whether the input has ended."""
        return self.phones.ended

    @property
    def known_until(self) -> float:
        """Seconds of received audio."""
        return self.level.count / self.rate

    @property
    def ready(self) -> int:
        """Number of frames that may be released."""
        return self.phones.ready

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the received audio."""
        loud = self.level.peak > 0
        return (*self.level.notes, *("no speech was recognized in the audio",) * (loud and not self.spoken))

    def news(self) -> str:
        """Nothing: the language of the labels is known."""
        return ""

    def warm_up(self) -> None:
        """Make a frame and discard it, so that the first real one is as fast as the others."""
        other = RecognizedStream(self.options, self.rate, self.ahead)
        other.pass_time(0.5)
        other.frames()

    def take(self, event: Event) -> None:
        """Add audio. Raises StreamError for samples that are not finite, which count as silence."""
        if not isinstance(event, Samples):
            raise StreamError("the model is audio-driven and ignores phones; send it audio")
        samples = np.nan_to_num(event.values, nan=0.0, posinf=0.0, neginf=0.0)
        self.level.add(samples)
        self.phones.take(Samples(samples))
        self._recognize(self.resampler.push(samples))
        lost = int((~np.isfinite(event.values)).sum())
        if lost:
            place = f"before {self.known_until:.2f} s"
            raise StreamError(f"{lost} samples {place} are not finite numbers and count as silence")

    def _recognize(self, samples: Floats) -> None:
        self._say(self.recognizer.push(samples))
        self.phones.pass_time(self.recognizer.until)
        self.phones.begun = self.recognizer.going_on(GOES_ON)

    def _say(self, phones: list[Interval]) -> None:
        for phone in phones:
            self.phones.push(phone.label, phone.start, phone.end)
            self.spoken = True

    def pass_time(self, now: float) -> None:
        """Set the time to `now` seconds: missing audio counts as silence."""
        missing = round((now - self.known_until) * self.rate)
        if missing > 0 and not self.ended:
            self.take(Samples(np.zeros(missing, np.float32)))

    def end(self) -> None:
        """Declare the end of the input."""
        if self.ended:
            return
        self._recognize(self.resampler.end())
        self._say(self.recognizer.end())
        self.phones.begun = None
        self.phones.pass_time(self.known_until)
        self.phones.end()

    def frames(self, most: int | None = None) -> Floats:
        """Frames decided since the last call, all or the first `most`, (frames, controls)."""
        return self.phones.frames(most)
