"""The settings of regressors/facediffuser.py."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

from phonanim.errors import ModelError

# How a signal can be embedded: not at all; by one layer; by two; by a layer and a convolution with pooling
# (section 8.3 of the thesis). The thesis does not define the pooling: here pairs of channels are merged.
EMBEDDINGS = ("none", "linear", "mlp", "conv", "max", "average")
MASKS = ("none", "full zero", "partial zero", "full random", "partial random")
OWN_RATE = 50.0  # steps per second of every encoder
SCHEDULES = ("linear", "cosine")
SAMPLINGS = ("rediffuse", "posterior", "strided")
DECODERS = ("gru", "rnn", "transformer")


@dataclass(frozen=True)
class Config:
    """The published values of the vertex version (Table 8), training on windows of at most `window` steps.

    The version for rigs has `sound` and `noise` "none", `pairs` "concatenate", `latent` 128,
    `timesteps` 1000, 100 epochs, and 4 layers of 1024 (its own recordings) or 2 of 256 (ARKit). `sound` and
    `noise` are embedded by one of EMBEDDINGS; the convolution of the noise runs over "time" (the thesis) or
    over the "features" of a step (`noise_over`; the released code). `pairs` are the encoder's two steps in
    each step: their "average", or side by side (section 6.4: "concatenate"). `decoder` is one of DECODERS
    (section 6.2), with `heads` for the transformer. `schedule` is how noise grows
    (`_diffusion.signal_share`), `sampling` one of SAMPLINGS (`_diffusion.sample_motion`). With `zero_output`
    the last layer starts at zero, as in the released code. The last `tuned` blocks of the encoder are trained
    further (section 8.1); 0 leaves it frozen. `masking` is one of MASKS, for the share `masked`; `guidance`
    weights the prediction with audio against the one without (eq. 8), and 1 uses audio only. `steps` of the
    `timesteps` are sampled. `autoencoder` is the number of epochs of a first stage that trains the decoder
    without sound (appendix B). `style` is the style of the output, out of the `styles` of Examples.styles.
    Without `diffusion` it is the recurrent network of the ablation (8.4). `delta` is where the Huber loss
    (eq. 5) becomes linear, in the targets' scale: `scale` is one number for all modes, `modes` one for each.
    """

    encoder: str = "whisper"
    sound: str = "linear"
    noise: str = "max"
    noise_over: Literal["time", "features"] = "time"
    pairs: Literal["average", "concatenate"] = "average"
    tuned: int = 0
    latent: int = 512
    decoder: str = "gru"
    heads: int = 4
    hidden: int = 512
    depth: int = 2
    bidirectional: bool = False
    zero_output: bool = False
    diffusion: bool = True
    schedule: str = "linear"
    sampling: str = "rediffuse"
    timesteps: int = 500
    steps: int = 500
    seed: int = 0
    guidance: float = 1.0
    masking: str = "partial zero"
    masked: float = 0.25
    styles: int = 1
    style: int = 0
    autoencoder: int = 0
    delta: float = 1.0
    normalize: Literal["scale", "modes"] = "scale"
    rate: float = 25.0
    window: int = 250
    dropout: float = 0.0
    learning_rate: float = 1e-4
    cosine: bool = False
    batch: int = 1
    epochs: int = 50
    patience: int = 50

    def __post_init__(self) -> None:
        _check_name("sound", self.sound, EMBEDDINGS)
        _check_name("noise", self.noise, EMBEDDINGS)
        _check_name("masking", self.masking, MASKS)
        _check_name("decoder", self.decoder, DECODERS)
        _check_name("schedule", self.schedule, SCHEDULES)
        _check_name("sampling", self.sampling, SAMPLINGS)
        _check_decoder(self)
        if self.sampling == "posterior" and self.steps != self.timesteps:
            raise ModelError(
                f'facediffuser: sampling "posterior" takes every timestep: set steps to {self.timesteps}, or '
                'sampling to "strided"'
            )
        if not 1 <= self.steps <= self.timesteps:
            raise ModelError(
                f"facediffuser: steps is {self.steps}; take 1 to {self.timesteps}, the number of timesteps"
            )
        if not 0 <= self.style < self.styles:
            raise ModelError(f"facediffuser: there is no style {self.style}; take 0 to {self.styles - 1}")
        if self.latent % 2 or self.latent < 2:
            raise ModelError(
                f"facediffuser: latent is {self.latent}; take an even number, for sines and cosines"
            )
        if self.seed < 0:
            raise ModelError(f"facediffuser: seed is {self.seed}; take 0 or more")


def _check_decoder(config: Config) -> None:
    if config.tuned < 0:
        raise ModelError(f"facediffuser: tuned is {config.tuned}; take 0 or more blocks")
    if config.tuned and (config.pairs != "concatenate" or config.rate != OWN_RATE / 2):
        raise ModelError(
            f'facediffuser: tuned needs pairs "concatenate" and the rate {OWN_RATE / 2:g}, so that the '
            "blocks get the encoder's own steps"
        )
    if config.decoder == "transformer" and config.hidden % config.heads:
        raise ModelError(
            f"facediffuser: hidden is {config.hidden}; take a multiple of heads, which is {config.heads}"
        )
    if config.decoder == "transformer" and config.bidirectional:
        raise ModelError("facediffuser: a transformer sees both sides; leave out bidirectional")


def _check_name(key: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        near = get_close_matches(value, known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"take {', '.join(known)}"
        raise ModelError(f"facediffuser: {key} is {value!r}; {hint}")
