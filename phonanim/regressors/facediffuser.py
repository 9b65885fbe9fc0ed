"""FaceDiffuser (Stan 2023), made anew from the thesis: motion that is sampled from noise, and from sound.

A recurrent network learns to see the motion that lies under noise, given the sound. Asked again and again
from pure noise on, it speaks each line in as many ways as there are seeds. The thesis trains on vertices of
a mesh ("V") and on controls of a rig ("B"); here the targets of `fit` may be either: modes of the face, as
for every regressor, or any other curves (benchmarks/facediffuser.py trains it on ARKit's controls).

What differs: the encoder of the sound is not trained further, and its features are averaged onto the
model's steps, where the thesis concatenates pairs of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import named
from phonanim.encoders import Features
from phonanim.errors import ModelError
from phonanim.regressors import Examples, Progress, Tensors
from phonanim.regressors._audio import AudioInput, check_sounds, fitting, identity_in
from phonanim.regressors._diffusion import EMBEDDINGS, MASKS, absent, embed, noise_of, sample, shapes_of

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
UNHEARD = 10**6  # the turn whose noise stands for no sound, beyond all turns of sampling
BEYOND = 5  # steps that are sampled after the last one


@dataclass(frozen=True)
class Config:
    """The published values of the vertex version (Table 8), training on windows of at most `window` steps.

    That for rigs has `noise` "none", `latent` 128, `timesteps` 1000, 100 epochs, and 4 layers of 1024 (its
    own recordings) or 2 of 256 (ARKit). `sound` and `noise` are embedded by one of _diffusion.EMBEDDINGS.
    `masking` is one of _diffusion.MASKS, for the share `masked`; `guidance` weighs what is heard against
    what is not (eq. 8), 1 hears alone. `steps` of the `timesteps` are sampled. `autoencoder` epochs of a
    first stage learn the decoder without sound (appendix B). `style` is spoken, of as many `styles` as
    Examples.styles tell apart. Without `diffusion` it is the recurrent network of the ablation (8.4).
    `delta` is where the Huber loss (eq. 5) becomes linear, in the targets' scale: that of `scale` is one
    number for all modes, that of `modes` one for each.
    """

    encoder: str = "whisper"
    sound: str = "linear"
    noise: str = "max"
    latent: int = 512
    hidden: int = 512
    depth: int = 2
    bidirectional: bool = False
    diffusion: bool = True
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


def _check_name(key: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        near = get_close_matches(value, known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"take {', '.join(known)}"
        raise ModelError(f"facediffuser: {key} is {value!r}; {hint}")


@dataclass(frozen=True)
class FaceDiffuser(AudioInput):
    """A trained model: `centre` and `scale` (1, dims) of the features, `low` and `span` (modes,) of targets.

    `weights` are the network's (regressors/_diffusion.py), `identity` is the encoder's that it learned from.
    """

    config: Config
    centre: Floats
    scale: Floats
    low: Floats
    span: Floats
    weights: dict[str, Floats]
    identity: str

    config_class: ClassVar[type] = Config

    def changed(self, **settings: Any) -> FaceDiffuser:
        """The same model with another `seed`, `steps`, `guidance` or `style`. Raises ModelError."""
        return replace(self, config=replace(self.config, **settings))

    def decoded(self, features: Features, grid: Array) -> Floats:
        """Modes at steps, (steps,) seconds of `step_times` -> (steps, modes).

        What sees the noise looks a step ahead, and makes the last one jump: a few more are sampled.
        """
        return super().decoded(features, onward(grid, self.config.rate))[: len(grid)]

    def stretch(self, values: Floats, first: int) -> Floats:
        """Modes of steps from the step `first` on, (steps, layers, dims) -> (steps, modes)."""
        values = self.normal(values)
        noise = partial(self.noise, first=first, count=len(values))
        heard, unheard = self.embedded(values[None]), None
        if self.config.guidance != 1:
            rng = np.random.default_rng([self.config.seed, UNHEARD, first])
            unheard = self.embedded(absent(self.config.masking, (1, *values.shape), rng))
        return self.unscaled(sample(self.config, self.weights, heard, noise, unheard)[0])

    def noise(self, turn: int, first: int, count: int) -> Floats:
        """Noise of some steps at one turn of the sampling, (1, count, modes)."""
        return noise_of(self.config.seed, turn, first, count, len(self.low))[None]

    def normal(self, values: Floats) -> Floats:
        """What the network hears of features, (steps, layers, dims) -> (steps, dims)."""
        return np.asarray((values[:, -1] - self.centre[0]) * self.scale[0])

    def embedded(self, values: Floats) -> Floats:
        """What stays the same while sampling, (n, steps, dims) -> (n, steps, size)."""
        return embed(self.config.sound, named(self.weights, "sound_"), values)

    def unscaled(self, motion: Floats) -> Floats:
        """Modes in the unit of the targets, any shape that ends in modes."""
        return np.asarray(motion * self.span + self.low)

    def tensors(self) -> Tensors:
        """The network's weights, how features and targets are scaled, and the encoder's identity in bytes."""
        told = np.frombuffer(self.identity.encode(), np.uint8)
        scaling = {name: getattr(self, name) for name in ("centre", "scale", "low", "span")}
        return scaling | {f"network_{n}": t for n, t in self.weights.items()} | {"identity": told}

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> FaceDiffuser:
        """Raises ValueError when a tensor is not of the size that the configuration gives it."""
        dims, modes = tensors["centre"].shape[1], len(tensors["low"])
        shapes = {f"network_{name}": shape for name, shape in shapes_of(config, dims, modes).items()}
        shapes |= {"centre": (1, dims), "scale": (1, dims), "low": (modes,), "span": (modes,)}
        real = fitting(tensors, shapes)
        scaling = {name: real[name] for name in ("centre", "scale", "low", "span")}
        weights, identity = named(real, "network_"), identity_in(tensors)
        return cls(config=config, weights=weights, identity=identity, **scaling)

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> FaceDiffuser:
        """Learn from recordings; the state with the least error of a quick sample of `validation` is kept.

        With a folder as `journal`, the state after each epoch is kept there, and training goes on from
        it; loss.csv beside it has the errors. Raises ModelError when the examples have no sounds, or a
        style that the configuration does not have.
        """
        from phonanim.regressors._torch_diffusion import fit_diffusion

        check_sounds(train)
        told = {*train.styles, *validation.styles}
        if told - set(range(config.styles)):
            raise ModelError(
                f"facediffuser: the examples have style {max(told)}; set styles to {max(told) + 1} or more"
            )
        return fit_diffusion(cls, config, train, validation, rng, progress, journal)


def onward(grid: Array, rate: float) -> Array:
    """Steps that go on for a little after the last one, (steps,) seconds -> (steps + BEYOND,)."""
    return np.append(grid, grid[-1] + np.arange(1, BEYOND + 1) / rate)


REGRESSOR = FaceDiffuser
