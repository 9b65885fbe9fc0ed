"""What the audio-driven regressors share: an encoder hears, a decoder turns what it hears into modes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import named, softmax
from phonanim.encoders import Encoder, Features, encode, load_encoder
from phonanim.encoders.phones import of_track
from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.regressors import Examples, InputModality, Progress, Tensors
from phonanim.regressors._decoders import Shapes, decode, decoder_shapes
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
FIRST = 0.02  # seconds: the middle of the first frame of 25 fps video is a step, at 25 and at 50 Hz
CHUNK, AROUND = 60.0, 3.0  # seconds decoded at a time, and heard before and after them
Self = TypeVar("Self", bound="AudioRegressor")


@dataclass(frozen=True)
class Settings:
    """What can be chosen of an audio-driven regressor; `phisanet` and `two_stage` have the published values.

    `encoder` is one of phonanim.encoders; `inputs` its last layer ("enc"), or all of them in weights that
    are learned ("all_enc"). `rate` is in hertz, `window` in steps. The weights of the loss are those of
    the velocity and acceleration of the modes (Medina 2023, eq. 4.8), of the phone classifier (4.20)
    and of connectionist temporal classification (4.28). `normalize` scales targets for the loss: each
    mode to 0..1, or all by one number, which makes the loss the squared error in millimetres.
    """

    encoder: str = "whisper"
    inputs: Literal["enc", "all_enc"] = "enc"
    decoder: Literal["mlp", "lstm", "gru", "transformer", "convolution"] = "gru"
    hidden: int = 128
    depth: int = 2
    bidirectional: bool = True
    widths: tuple[int, int] = (15, 5)
    heads: int = 8
    kernels: tuple[int, ...] = ()
    dilations: tuple[int, ...] = ()
    channels: tuple[int, ...] = ()
    ahead: int = 0
    rate: float = 50.0
    window: int = 45
    dropout: float = 0.1
    velocity: float = 0.0
    acceleration: float = 0.0
    classifier: float = 0.0
    ctc: float = 0.0
    normalize: Literal["minmax", "scale"] = "scale"
    optimizer: Literal["adam", "radam"] = "adam"
    learning_rate: float = 1e-3
    cosine: bool = False
    batch: int = 32
    epochs: int = 40
    patience: int = 10


class AudioInput(ABC):
    """What all regressors that hear share: a sound is encoded, and its steps are decoded by stretches.

    `config` has `encoder` and `rate`, `identity` is that of the encoder that the model learned from.
    """

    config: Any
    identity: str

    input_modality: ClassVar[InputModality] = "audio"
    resumable: ClassVar[bool] = True

    def predict(self, track: PhoneTrack | None, times: Array, sound: Sound | None = None) -> Floats:
        """Modes at instants of a sound, (times,) seconds -> (times, modes), interpolated between steps.

        The same settings give the same bytes. Raises ModelError when the encoder is not the one that the
        model learned from.
        """
        if sound is None:
            raise ModelError("an audio-driven model needs a recording")
        features = self.hear(sound, track)
        grid = step_times(sound.duration, self.config.rate)
        return between(self.decoded(features, grid), (times - grid[0]) * self.config.rate)

    def hear(self, sound: Sound, track: PhoneTrack | None = None) -> Features:
        """Features of a sound. Raises ModelError when their encoder is not the one that was learned from."""
        encoder = cached_encoder(self.config.encoder)
        if encoder.identity != self.identity:
            raise ModelError(
                f"the model learned from {self.identity!r}, and {encoder.identity!r} is here: "
                "set PHONANIM_ENCODERS to its weights, or train it again"
            )
        return self.listen(self.config, sound, track)

    @classmethod
    def listen(cls, config: Any, sound: Sound, track: PhoneTrack | None) -> Features:
        """What models of this kind are given of a sound, to be asked for at steps."""
        return listen(cached_encoder(config.encoder), sound, track)

    def decoded(self, features: Features, grid: Array) -> Floats:
        """Modes at steps, (steps,) seconds of `step_times` -> (steps, modes).

        Each stretch is decoded with what is around it, so that memory stays bounded.
        """
        around, size = round(AROUND * self.config.rate), round(CHUNK * self.config.rate)
        found = []
        for begin in range(0, len(grid), size):
            first = max(begin - around, 0)
            values = at_steps(features, grid[first : begin + size + around], self.config.rate)
            found.append(self.stretch(values, first)[begin - first :][:size])
        return np.concatenate(found)

    @abstractmethod
    def stretch(self, values: Floats, first: int) -> Floats:
        """Modes of steps from the step `first` on, (steps, layers, dims) -> (steps, modes)."""


@dataclass(frozen=True)
class AudioRegressor(AudioInput):
    """A trained model: `centre` and `scale` (layers, dims) of the features, `mix` (layers,) if all take part.

    `weights` are the decoder's (regressors/_decoders.py), `identity` is the encoder's that it learned from.
    """

    config: Settings
    centre: Floats
    scale: Floats
    mix: Floats
    weights: dict[str, Floats]
    identity: str

    config_class: ClassVar[type] = Settings

    def stretch(self, values: Floats, first: int) -> Floats:
        """Modes of steps, (steps, layers, dims) -> (steps, modes)."""
        return decode(self.config, self.weights, self.mixed(values)[None])[0]

    def mixed(self, values: Floats) -> Floats:
        """What the decoder gets, (steps, layers, dims) -> (steps, dims)."""
        normal = (values - self.centre) * self.scale
        return normal[:, -1] if self.config.inputs == "enc" else np.einsum("sld,l->sd", normal, self.shares)

    @property
    def shares(self) -> Floats:
        """How much of each layer is heard, (layers,), sum 1 (Medina 2023, eq. 4.14)."""
        return softmax(self.mix)

    def tensors(self) -> Tensors:
        """The decoder's weights, how features are scaled and mixed, and the encoder's identity in bytes."""
        told = np.frombuffer(self.identity.encode(), np.uint8)
        heard: Tensors = {"centre": self.centre, "scale": self.scale, "mix": self.mix, "identity": told}
        return heard | {f"decoder_{name}": tensor for name, tensor in self.weights.items()}

    @classmethod
    def from_tensors(cls: type[Self], config: Any, tensors: Tensors) -> Self:
        """Raises ValueError when a tensor is not of the size that the configuration gives it."""
        layers, dims = tensors["centre"].shape
        modes = len(tensors["decoder_output_bias"]) // (config.widths[1] if config.decoder == "mlp" else 1)
        shapes = {f"decoder_{n}": shape for n, shape in decoder_shapes(config, dims, modes).items()}
        shapes |= {"centre": (layers, dims), "scale": (layers, dims), "mix": (layers,)}
        real = fitting(tensors, shapes)
        weights = named(real, "decoder_")
        return cls(config, real["centre"], real["scale"], real["mix"], weights, identity_in(tensors))

    @classmethod
    def fit(
        cls: type[Self],
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
        journal: Path | None = None,
    ) -> Self:
        """Learn from recordings; early stopping on `validation`.

        With a folder as `journal`, the state after each epoch is kept there, and training goes on from
        it; loss.csv beside it has the errors. Raises ModelError when the examples have no sounds.
        """
        from phonanim.regressors._torch_audio import fit_audio

        check_sounds(train)
        return fit_audio(cls, config, train, validation, rng, progress, journal)


def check_sounds(examples: Examples) -> None:
    """Raise ModelError when there is nothing to hear in examples."""
    if len(examples.sounds) != len(examples) or not all(examples.sounds):
        raise ModelError("an audio-driven regressor learns from recordings: give it clips with sound")


def fitting(tensors: Tensors, shapes: Shapes) -> dict[str, Floats]:
    """The tensors of these names. Raises ValueError when one is not of its shape."""
    for name, shape in shapes.items():
        if tensors[name].shape != shape:
            raise ValueError(f"{name} is {tensors[name].shape}, not {shape}")
    return {name: tensors[name].astype(np.float32) for name in shapes}


def identity_in(tensors: Tensors) -> str:
    """The identity of an encoder that a model was stored with."""
    return tensors["identity"].astype(np.uint8).tobytes().decode()


@lru_cache(maxsize=4)
def cached_encoder(name: str) -> Encoder:
    """An encoder, read once."""
    return load_encoder(name)


def listen(encoder: Encoder, sound: Sound, track: PhoneTrack | None) -> Features:
    """Features of a sound; phones are taken from the alignment, if anything is said in it."""
    if encoder.identity.startswith("phones") and track is not None and track.codes.any():
        return of_track(track)
    return encode(encoder, sound)


def step_times(duration: float, rate: float) -> Array:
    """Instants at which a model of some rate predicts, (steps,) seconds."""
    first = FIRST % (1 / rate)
    return first + np.arange(max(1, int(np.floor((duration - first) * rate + 1e-6)) + 1)) / rate


def at_steps(features: Features, times: Array, rate: float) -> Floats:
    """Features at steps: interpolated, or averaged where steps are further apart than the features."""
    return features.at(times, 1 / rate)


def between(values: Floats, place: Array) -> Floats:
    """Rows of `values` at fractional places, interpolated; the ends repeat."""
    place = np.clip(place, 0, len(values) - 1)
    below = np.floor(place).astype(np.int64)
    share = (place - below).astype(np.float32)[:, None]
    upper = values[np.minimum(below + 1, len(values) - 1)]
    return np.asarray(values[below] + (upper - values[below]) * share, np.float32)
