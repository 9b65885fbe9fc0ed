"""The model that samples motion from noise and sound, trained by `regressors/_torch_diffusion.py`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import tensors_with_prefix
from phonanim.encoders import Features
from phonanim.media.audio import Sound
from phonanim.regressors._audio_input import AudioInput
from phonanim.regressors._diffusion import embed, no_sound, sample_motion, step_noise
from phonanim.regressors._facediffuser_config import Config
from phonanim.regressors._steps import cached_encoder
from phonanim.regressors._tuned import last_blocks, run_blocks
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
NO_AUDIO_TURN = 10**6  # the turn of the noise that replaces the sound, beyond all turns of sampling
SAME = 1e-6  # relative difference of two rates that are the same
BEYOND = 5  # extra steps that are sampled after the last one
Self = TypeVar("Self", bound="Denoiser")


@dataclass(frozen=True)
class Denoiser(AudioInput):
    """A trained model: `centre` and `scale` (1, dims) of the features, `low` and `span` (modes,) of targets.

    `weights` are the network's (regressors/_diffusion.py); `identity` is the encoder's in training.
    """

    config: Config
    centre: Floats
    scale: Floats
    low: Floats
    span: Floats
    weights: dict[str, Floats]
    identity: str

    config_class: ClassVar[type] = Config

    @classmethod
    def input_features(cls, config: Any, sound: Sound, track: PhoneTrack | None) -> Features:
        """The features of a sound; with `pairs` "concatenate", two of the encoder's steps side by side."""
        audio = super().input_features(config, sound, track)
        if config.pairs == "average":
            return audio
        values = audio.values
        if config.tuned:  # the input of the blocks that are trained further, beside the output of the last
            last_blocks(cached_encoder(config.encoder), config.tuned)
            values = values[:, [-1 - config.tuned, -1]]
        return PairedFeatures(values, audio.rate, audio.start)

    def with_settings(self: Self, **settings: Any) -> Self:
        """The same model with another `seed`, `steps`, `guidance` or `style`. Raises ModelError."""
        return replace(self, config=replace(self.config, **settings))

    def modes_at_steps(self, features: Features, grid: Array) -> Floats:
        """Modes at steps, (steps,) seconds of `step_times` -> (steps, modes).

        The network looks a step ahead, which makes the last step jump, so a few extra steps are sampled.
        """
        return super().modes_at_steps(features, extend_steps(grid, self.config.rate))[: len(grid)]

    def decode_stretch(self, values: Floats, first: int) -> Floats:
        """Modes of steps from the step `first` on, (steps, layers, dims) -> (steps, modes)."""
        values = self.normalize_features(values)
        noise = partial(self.noise, first=first, count=len(values))
        audio, no_audio = self.embed_sound(values[None]), None
        if self.config.guidance != 1:
            rng = np.random.default_rng([self.config.seed, NO_AUDIO_TURN, first])
            no_audio = self.embed_sound(no_sound(self.config.masking, (1, *values.shape), rng))
        return self.unscale_modes(sample_motion(self.config, self.weights, audio, noise, no_audio)[0])

    def noise(self, turn: int, first: int, count: int) -> Floats:
        """Noise of some steps at one turn of the sampling, (1, count, modes)."""
        return step_noise(self.config.seed, turn, first, count, len(self.low))[None]

    def normalize_features(self, values: NDArray[np.floating]) -> Floats:
        """The network's input for features, (..., steps, layers, dims) -> (..., steps, dims)."""
        last = values[..., -1, :]
        if self.config.tuned:
            heads = last_blocks(cached_encoder(self.config.encoder), self.config.tuned)[1]
            blocks = tensors_with_prefix(self.weights, "tuned_")
            last = run_blocks(blocks, self.config.tuned, heads, values[..., 0, :])
        return np.asarray((last - self.centre[0]) * self.scale[0])

    def embed_sound(self, values: Floats) -> Floats:
        """The part that is constant during sampling, (n, steps, dims) -> (n, steps, size)."""
        return embed(self.config.sound, tensors_with_prefix(self.weights, "sound_"), values)

    def unscale_modes(self, motion: Floats) -> Floats:
        """Modes in the unit of the targets; any shape whose last axis is modes."""
        return np.asarray(motion * self.span + self.low)


@dataclass(frozen=True)
class PairedFeatures(Features):
    """Features at both halves of every step, side by side (Stan 2023, section 6.4)."""

    def at(self, times: Array, span: float = 0.0) -> Floats:
        """(times,) seconds -> (times, layers, 2 dims); a step is `span` seconds long.

        Where a step is two of the encoder's long, these are taken as they are, not interpolated.
        """
        halves = [times + side * span / 4 for side in (-1, 1)]
        if abs(span * self.rate - 2) < SAME:
            halves = [
                self.start + np.floor((half - self.start) * self.rate + SAME) / self.rate for half in halves
            ]
        return np.concatenate([super(PairedFeatures, self).at(half, span / 2) for half in halves], axis=2)


def extend_steps(grid: Array, rate: float) -> Array:
    """Steps that continue beyond the last one, (steps,) seconds -> (steps + BEYOND,)."""
    return np.append(grid, grid[-1] + np.arange(1, BEYOND + 1) / rate)
