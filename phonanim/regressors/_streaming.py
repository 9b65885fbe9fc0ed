"""What the audio-driven regressors that can be streamed say of themselves: what they hear, and how late."""

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
    """A regressor of convolutions: each step is made from so many steps before it and so many after it."""

    @property
    def receptive_field(self) -> int:
        """Steps that one step is made from."""
        return receptive_field(self.config)

    @property
    def before(self) -> int:
        """Steps before one that it is made from; a stream is warm when it has heard as many."""
        return steps_before(self.config)

    @property
    def ahead(self) -> int:
        """Steps after one that it is made from."""
        return int(self.config.ahead)

    @property
    def encoder(self) -> Cepstra:
        """The encoder. Raises ModelError when it is none that hears a bounded stretch around each step."""
        found = cached_encoder(self.config.encoder)
        if not isinstance(found, Cepstra):
            raise ModelError(
                f"the encoder {self.config.encoder!r} hears a whole recording and cannot be streamed; "
                "train with mfcc or mfcc_live"
            )
        return found

    @property
    def look_ahead(self) -> float:
        """Seconds of sound beyond an instant that its frame is made from.

        The steps ahead, what the encoder hears around each, and one step, as frames lie between steps.
        """
        return (self.ahead + 1) / self.config.rate + self.encoder.reach / RATE

    def step(self, values: Floats) -> Floats:
        """Modes of the steps that have all they are made from, (steps, layers, dims) -> (steps', modes).

        steps' = steps - receptive_field + 1.
        """
        signal = self.mix_layers(values)[None]
        return output(self.weights, convolve_within(self.config, self.weights, signal))[0]
