"""An audio-driven model as a stream: sound in, frames out, as many as what was heard decides."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.rates import frame_count
from phonanim.animation.style import scale_controls
from phonanim.encoders import HOP, RATE, STEPS
from phonanim.encoders._cepstra import Cepstra
from phonanim.errors import MissingExtraError, OptionError, StreamError
from phonanim.inputs.prosody import life_ahead
from phonanim.life import life_of
from phonanim.media.audio import Level
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.regressors._steps import step_times
from phonanim.regressors._streaming import Streamed
from phonanim.rig.retarget import retarget
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.prosody import Prosody
from phonanim.stream.engine import ABREAST, reject_whole_line_layers
from phonanim.stream.events import Event, Samples
from phonanim.stream.life import HeardVoice, StreamedLife

Floats = NDArray[np.float32]


@dataclass
class SoundStream:
    """Sound in, frames out: those that the whole recording would give, once what decides them is heard.

    Frame n stands at n / fps and needs `look_ahead` seconds of sound beyond. There is no warm-up in which
    the mouth stays still: before the first sample the first step holds, as in training, so that frames
    come from the start, and are exact from the start. Memory stays flat. `line` is the name that the seed of
    life comes from. Raises OptionError when the model cannot be streamed, or a layer looks at a whole line.
    """

    options: Options
    rate: int = RATE
    line: str = "stream"
    emitted: int = 0
    ended: bool = False
    level: Level = field(default_factory=Level)
    modes: Floats = field(init=False)
    forgotten: int = 0  # steps of modes that no frame needs any more
    patience: ClassVar[float] = 0.25  # seconds that a frame which is due waits for its sound

    def __post_init__(self) -> None:
        reject_whole_line_layers(self.options)
        self.model = load_model(self.options.model)
        self.rig = load_cached_rig(self.options.rig)
        if self.rig.visemes is not None:
            raise OptionError(f"rig {self.rig.name} shows phones, and sound has none; choose another --rig")
        self.regressor = streamable(self.model.regressor, self.options.model)
        self.resampler = Resampler(self.rate)
        self.steps = Steps(self.regressor.encoder)
        self.context: Floats = np.empty((0, 1, self.regressor.encoder.dims), np.float32)
        life = life_of(self.options, self.line)
        self.voice = HeardVoice(self.rate, life_ahead(self.regressor))
        streamed = StreamedLife(life, self.rig, self.options.fps, self._prosody)
        self.life = streamed if life.moves(self.rig) else None
        self.modes = np.empty((0, len(self.model.face.std)), np.float32)

    @property
    def look_ahead(self) -> float:
        """Seconds of sound beyond a frame that decide it."""
        return self.regressor.look_ahead

    @property
    def seconds(self) -> float:
        """Sound that came."""
        return self.level.count / self.rate

    @property
    def known_until(self) -> float:
        """Seconds of sound that came."""
        return self.seconds

    @property
    def ready(self) -> int:
        """Frames that may be given out."""
        return max(self._due() - self.emitted, 0)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is odd about the sound that came."""
        return self.level.notes

    def warm_up(self) -> None:
        """Make a frame that nobody sees, so that the first one takes no longer than the others."""
        other = SoundStream(self.options, self.rate)
        other.pass_time(0.5)
        other.frames()

    def take(self, event: Event) -> None:
        """Take sound. Raises StreamError for samples that are no numbers, which count as silence."""
        if not isinstance(event, Samples):
            raise StreamError("the model hears, and has no use for phones; send it sound")
        samples = np.nan_to_num(event.values, nan=0.0, posinf=0.0, neginf=0.0)
        self.level.add(samples)
        if self.life is not None:
            self.voice.push(samples)
        self._hear(self.steps.push(self.resampler.push(samples)))
        lost = int((~np.isfinite(event.values)).sum())
        if lost:
            place = f"before {self.seconds:.2f} s"
            raise StreamError(f"{lost} samples {place} are no numbers and count as silence")

    def pass_time(self, now: float) -> None:
        """Say that it is `now` seconds: sound that did not come was silent."""
        missing = round((now - self.seconds) * self.rate)
        if missing > 0 and not self.ended:
            self.take(Samples(np.zeros(missing, np.float32)))

    def end(self) -> None:
        """Say that nothing more will come."""
        if self.ended:
            return
        self.ended = True
        self._hear(self.steps.end(self.resampler.end()))
        if len(self.context):
            self._hear(np.repeat(self.context[-1:], self.regressor.ahead + 1, axis=0))  # the last step holds
            self.modes = self.modes[: len(step_times(self.seconds, STEPS)) - self.forgotten]

    def frames(self, most: int | None = None) -> Floats:
        """Frames that are decided since the last call, all or the first `most`, (frames, controls)."""
        ready = self.ready
        count = ready if most is None else min(ready, most)
        if count <= 0:
            return np.empty((0, len(self.rig.controls)), np.float32)
        times = np.arange(self.emitted, self.emitted + count) / self.options.fps
        modes = self._at(times)
        values = retarget(modes, self.model.face, self.rig, self.options.retarget)
        options = self.options
        values = scale_controls(values, self.rig, options.intensity, options.jaw, options.lips, options.gains)
        if self.life is not None:
            values = self.life.add(values, self.emitted, self.emitted + ready)
        self.emitted += count
        self._forget()
        return values

    def _prosody(self, time: float) -> tuple[Prosody, PhoneTrack]:
        return self.voice.prosody(time, self.ended)

    def _hear(self, features: Floats) -> None:
        """Take features of the next steps, (steps, 1, dims), and predict the steps that they decide."""
        if len(features) and not len(self.context):
            features = np.concatenate([np.repeat(features[:1], self.regressor.before, axis=0), features])
        self.context = np.concatenate([self.context, features])
        if len(self.context) >= self.regressor.receptive_field:
            self.modes = np.concatenate([self.modes, self.regressor.step(self.context)])
            self.context = self.context[len(self.context) - self.regressor.receptive_field + 1 :]

    def _due(self) -> int:
        """How many frames, from the first of all, are decided."""
        if self.seconds == 0:
            return 0
        if self.ended:
            return frame_count(self.seconds, self.options.fps)
        last = (self.forgotten + len(self.modes) - 1) / STEPS
        return max(math.floor(last * self.options.fps + ABREAST) + 1, self.emitted)

    def _at(self, times: NDArray[np.float64]) -> Floats:
        """Modes at instants, straight between steps."""
        place = np.clip(times * STEPS - self.forgotten, 0, len(self.modes) - 1)
        below = np.floor(place).astype(np.int64)
        share = (place - below).astype(np.float32)[:, None]
        upper = self.modes[np.minimum(below + 1, len(self.modes) - 1)]
        return np.asarray(self.modes[below] + (upper - self.modes[below]) * share, np.float32)

    def _forget(self) -> None:
        past = math.floor(self.emitted / self.options.fps * STEPS + ABREAST) - self.forgotten
        past = min(max(past, 0), max(len(self.modes) - 1, 0))
        self.modes, self.forgotten = self.modes[past:], self.forgotten + past


@dataclass
class Steps:
    """Features of overlapping stretches of sound, each step with all that it is made from.

    The first and the last steps see the sound mirrored, as they do in a whole recording.
    """

    encoder: Cepstra
    samples: Floats = field(default_factory=lambda: np.empty(0, np.float32))
    skipped: int = 0  # steps at the beginning of `samples` that were given out

    def push(self, samples: Floats) -> Floats:
        """Take 16 kHz samples; the steps that they decide, (steps, 1, dims)."""
        self.samples = np.concatenate([self.samples, samples])
        # A step is sure when nothing behind the samples can reach it.
        sure = (len(self.samples) - self.encoder.reach - 1) // HOP + 1
        return self._steps(sure) if sure > self.skipped else self._none()

    def end(self, samples: Floats) -> Floats:
        """Take the last samples; all steps that are left."""
        self.samples = np.concatenate([self.samples, samples])
        if not len(self.samples):
            return self._none()
        self.samples = np.pad(self.samples, (0, -len(self.samples) % HOP))
        return self._steps(len(self.samples) // HOP)

    def _steps(self, upto: int) -> Floats:
        padded = np.pad(self.samples, (0, -len(self.samples) % HOP))
        found = self.encoder.run(padded)[self.skipped : upto].astype(np.float16).astype(np.float32)
        self._forget(upto)
        return found

    def _forget(self, upto: int) -> None:
        """Keep what the next step sees before it."""
        kept = -(-self.encoder.reach // HOP)
        gone = max(upto - kept, 0)
        self.samples, self.skipped = self.samples[gone * HOP :], upto - gone

    def _none(self) -> Floats:
        return np.empty((0, 1, self.encoder.dims), np.float32)


class Resampler:
    """Sound of any rate to that of the encoders, as it comes. Raises MissingExtraError without soxr."""

    def __init__(self, rate: int) -> None:
        self.stream: Any = None
        if rate == RATE:
            return
        try:
            import soxr
        except ImportError as error:
            needed = "pip install 'phonanim[stream]'"
            raise MissingExtraError(f"sound of {rate} Hz needs {needed}, or sound of {RATE} Hz") from error
        self.stream = soxr.ResampleStream(rate, RATE, 1, dtype="float32")

    def push(self, samples: Floats) -> Floats:
        """Samples at the encoders' rate, some of them later."""
        return np.asarray(self.stream.resample_chunk(samples) if self.stream else samples, np.float32)

    def end(self) -> Floats:
        """Those that are left."""
        last = np.empty(0, np.float32)
        return np.asarray(self.stream.resample_chunk(last, last=True) if self.stream else last, np.float32)


def streamable(regressor: object, name: str) -> Streamed:
    """The regressor of a model, if sound may be streamed to it. Raises OptionError, ModelError."""
    if not isinstance(regressor, Streamed):
        raise OptionError(f"model {name} cannot take sound as it comes; choose one of kind cnn or tcn")
    if regressor.config.rate != STEPS:
        raise OptionError(f"model {name} predicts {regressor.config.rate:g} times a second, not {STEPS:g}")
    return regressor
