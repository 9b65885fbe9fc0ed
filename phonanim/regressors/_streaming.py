"""Common part of the audio-driven regressors that can be streamed: receptive field and latency."""

from __future__ import annotations

from dataclasses import dataclass

from phonanim.encoders import RATE
from phonanim.encoders._cepstra import Cepstra
from phonanim.errors import ModelError
from phonanim.regressors._audio import AudioRegressor
from phonanim.regressors._convolution import convolve_within, receptive_field, steps_before
from phonanim.regressors._decoders import output
from phonanim.regressors._steps import Floats, cached_encoder


@dataclass(frozen=True)
class Streamed(AudioRegressor):
    """A convolutional regressor: each step depends on a fixed number of steps before and after it."""

    @property
    def receptive_field(self) -> int:
        """Number of steps that affect one step."""
        return receptive_field(self.config)

    @property
    def before(self) -> int:
        """Steps before a step that affect it; a stream is warm after as many steps."""
        return steps_before(self.config)

    @property
    def ahead(self) -> int:
        """Steps after a step that affect it."""
        return int(self.config.ahead)

    @property
    def encoder(self) -> Cepstra:
        """The encoder. Raises ModelError when its features depend on the whole recording."""
        found = cached_encoder(self.config.encoder)
        if not isinstance(found, Cepstra):
            raise ModelError(
                f"the encoder {self.config.encoder!r} needs a whole recording and cannot be streamed; "
                "train with mfcc or mfcc_live"
            )
        return found

    @property
    def look_ahead(self) -> float:
        """Seconds of sound after an instant that affect its frame.

        It is the sum of the steps ahead, the encoder's reach, and one step, as frames are between steps.
        """
        return (self.ahead + 1) / self.config.rate + self.encoder.reach / RATE

    def step(self, values: Floats) -> Floats:
        """Modes of the steps whose receptive field is complete, (steps, layers, dims) -> (steps', modes).

        steps' = steps - receptive_field + 1.
        """
        signal = self.mix_layers(values)[None]
        return output(self.weights, convolve_within(self.config, self.weights, signal), self.config.style)[0]
