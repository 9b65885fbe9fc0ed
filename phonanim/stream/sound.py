"""Stream audio through an audio-driven model: each frame equals that of the whole recording."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.rates import frame_count
from phonanim.animation.style import scale_controls
from phonanim.encoders import HOP, RATE, STEPS
from phonanim.encoders._cepstra import Cepstra
from phonanim.errors import OptionError, StreamError
from phonanim.inputs.prosody import life_ahead
from phonanim.life import life_of
from phonanim.media.audio import Level
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, model_with_settings
from phonanim.regressors._steps import step_times
from phonanim.regressors._streaming import Streamed
from phonanim.rig.retarget import retarget
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.speech.prosody import Prosody
from phonanim.stream.engine import ABREAST, reject_whole_line_layers
from phonanim.stream.events import Event, Samples
from phonanim.stream.life import StreamedLife, StreamedVoice
from phonanim.stream.own import own_motion
from phonanim.stream.resampling import Resampler

Floats = NDArray[np.float32]


@dataclass
class SoundStream:
    """Audio in, frames out: those of the whole recording, as soon as their input has been received.

    Frame n is at n / fps and needs `look_ahead` seconds of audio after it. There is no warm-up with a
    motionless mouth: before the first sample the first step is repeated, as in training, so that frames are
    exact from the start. Memory use does not grow. `line` is the name for the seed of the life layer. Raises
    OptionError when the model cannot be streamed, or a layer needs a whole line.
    """

    options: Options
    rate: int = RATE
    line: str = "stream"
    emitted: int = 0
    ended: bool = False
    level: Level = field(default_factory=Level)
    modes: Floats = field(init=False)
    forgotten: int = 0  # steps of modes that are not needed any more
    patience: ClassVar[float] = 0.25  # seconds that a due frame waits for its audio

    def __post_init__(self) -> None:
        reject_whole_line_layers(self.options)
        self.model = model_with_settings(self.options)
        self.own = own_motion(self.model, self.options)
        self.rig = self.own.rig if self.own else load_cached_rig(self.options.rig)
        if self.rig.visemes is not None:
            raise OptionError(f"rig {self.rig.name} needs phones, not audio; choose another --rig")
        self.regressor = streamable(self.model.regressor, self.options.model)
        self.resampler = Resampler(self.rate)
        self.steps = Steps(self.regressor.encoder)
        self.context: Floats = np.empty((0, 1, self.regressor.encoder.dims), np.float32)
        life = life_of(self.options, self.line)
        self.voice = StreamedVoice(self.rate, life_ahead(self.regressor))
        streamed = StreamedLife(life, self.rig, self.options.fps, self._prosody)
        lives = self.own is None or self.own.lives
        self.life = streamed if lives and life.moves(self.rig) else None
        self.modes = np.empty((0, self.model.target.size), np.float32)

    @property
    def look_ahead(self) -> float:
        """Seconds of audio after a frame that affect it."""
        return self.regressor.look_ahead

    @property
    def seconds(self) -> float:
        """Seconds of received audio."""
        return self.level.count / self.rate

    @property
    def known_until(self) -> float:
        """Seconds of received audio."""
        return self.seconds

    @property
    def ready(self) -> int:
        """Number of frames that may be released."""
        return max(self._due() - self.emitted, 0)

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the received audio."""
        return (*self.level.notes, *(self.own.notes if self.own else ()))

    def warm_up(self) -> None:
        """Make a frame and discard it, so that the first real one is as fast as the others."""
        other = SoundStream(self.options, self.rate)
        other.pass_time(0.5)
        other.frames()

    def news(self) -> str:
        """Nothing: audio has no language."""
        return ""

    def take(self, event: Event) -> None:
        """Add audio. Raises StreamError for samples that are not finite, which count as silence."""
        if not isinstance(event, Samples):
            raise StreamError("the model is audio-driven and ignores phones; send it audio")
        samples = np.nan_to_num(event.values, nan=0.0, posinf=0.0, neginf=0.0)
        self.level.add(samples)
        if self.life is not None:
            self.voice.push(samples)
        self._predict(self.steps.push(self.resampler.push(samples)))
        lost = int((~np.isfinite(event.values)).sum())
        if lost:
            place = f"before {self.seconds:.2f} s"
            raise StreamError(f"{lost} samples {place} are not finite numbers and count as silence")

    def pass_time(self, now: float) -> None:
        """Set the time to `now` seconds: missing audio counts as silence."""
        missing = round((now - self.seconds) * self.rate)
        if missing > 0 and not self.ended:
            self.take(Samples(np.zeros(missing, np.float32)))

    def end(self) -> None:
        """Declare the end of the input."""
        if self.ended:
            return
        self.ended = True
        self._predict(self.steps.end(self.resampler.end()))
        if len(self.context):
            self._predict(
                np.repeat(self.context[-1:], self.regressor.ahead + 1, axis=0)
            )  # repeat the last step
            self.modes = self.modes[: len(step_times(self.seconds, STEPS)) - self.forgotten]

    def frames(self, most: int | None = None) -> Floats:
        """Frames decided since the last call, all or the first `most`, (frames, controls)."""
        ready = self.ready
        count = ready if most is None else min(ready, most)
        if count <= 0:
            return np.empty((0, len(self.rig.controls)), np.float32)
        times = np.arange(self.emitted, self.emitted + count) / self.options.fps
        values = self._move(self._at(times), times)
        if self.life is not None:
            values = self.life.add(values, self.emitted, self.emitted + ready)
        self.emitted += count
        self._forget()
        return values

    def _move(self, modes: Floats, times: NDArray[np.float64]) -> Floats:
        """Controls from modes, or from the rows of a model of other motion, (frames, controls)."""
        options = self.options
        if self.own:
            return self.own.move(modes, silent_track(float(times[-1]) + 1), times)
        values = retarget(modes, self.model.face, self.rig, options.retarget)
        return scale_controls(values, self.rig, options.intensity, options.jaw, options.lips, options.gains)

    def _prosody(self, time: float) -> tuple[Prosody, PhoneTrack]:
        return self.voice.prosody(time, self.ended)

    def _predict(self, features: Floats) -> None:
        """Add features of the next steps, (steps, 1, dims), and predict the steps that they decide."""
        if len(features) and not len(self.context):
            features = np.concatenate([np.repeat(features[:1], self.regressor.before, axis=0), features])
        self.context = np.concatenate([self.context, features])
        if len(self.context) >= self.regressor.receptive_field:
            self.modes = np.concatenate([self.modes, self.regressor.step(self.context)])
            self.context = self.context[len(self.context) - self.regressor.receptive_field + 1 :]

    def _due(self) -> int:
        """Number of frames, from the start, that are decided."""
        if self.seconds == 0:
            return 0
        if self.ended:
            return frame_count(self.seconds, self.options.fps)
        last = (self.forgotten + len(self.modes) - 1) / STEPS
        return max(math.floor(last * self.options.fps + ABREAST) + 1, self.emitted)

    def _at(self, times: NDArray[np.float64]) -> Floats:
        """Modes at instants, interpolated linearly between steps."""
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
    """Features of overlapping stretches of audio, with the complete context of each step.

    At the first and the last steps the audio is mirrored, as in a whole recording.
    """

    encoder: Cepstra
    samples: Floats = field(default_factory=lambda: np.empty(0, np.float32))
    skipped: int = 0  # steps at the beginning of `samples` that were returned

    def push(self, samples: Floats) -> Floats:
        """Add 16 kHz samples; returns the steps that they decide, (steps, 1, dims)."""
        self.samples = np.concatenate([self.samples, samples])
        # A step is decided when no later sample can change it.
        sure = (len(self.samples) - self.encoder.reach - 1) // HOP + 1
        return self._steps(sure) if sure > self.skipped else self._none()

    def end(self, samples: Floats) -> Floats:
        """Add the last samples; returns all remaining steps."""
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
        """Drop samples that the next step does not need."""
        kept = -(-self.encoder.reach // HOP)
        gone = max(upto - kept, 0)
        self.samples, self.skipped = self.samples[gone * HOP :], upto - gone

    def _none(self) -> Floats:
        return np.empty((0, 1, self.encoder.dims), np.float32)


def streamable(regressor: object, name: str) -> Streamed:
    """The regressor of a model, if it can be streamed. Raises OptionError, ModelError."""
    if not isinstance(regressor, Streamed):
        raise OptionError(f"model {name} cannot be streamed; choose one of kind cnn or tcn")
    if regressor.config.rate != STEPS:
        raise OptionError(f"model {name} predicts {regressor.config.rate:g} times per second, not {STEPS:g}")
    return regressor
