"""What a regressor is: its training data, its class, and what it needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from phonanim.inputs.speech_input import InputModality
from phonanim.media.audio import Sound
from phonanim.speech.phones import PhoneTrack

Tensors = dict[str, NDArray[Any]]
Progress = Callable[[float], None]
NEEDS = {
    "phones": "an alignment",
    "audio": "a recording",
    "both": "an alignment and a recording",
    "recognized": "an alignment or a recording",
}
CHECKPOINT = "checkpoint.pt"  # the state of a training, in the model's folder until it ends


@dataclass(frozen=True)
class Examples:
    """Training data of a regressor: per clip the phones, instants (frames,) s, and modes (frames, m).

    Of targets other than landmarks, rows of numbers (frames, m) stand for modes; they may be made on demand.
    `weights` (clips,) scale the clips' squared errors. `sounds` (clips,) are the recordings, for audio-driven
    regressors; `styles` (clips,) are numbers from 0, for clips in several speaking styles.
    """

    tracks: tuple[PhoneTrack, ...]
    times: tuple[NDArray[np.float64], ...]
    targets: Sequence[NDArray[np.float32]]
    weights: tuple[float, ...]
    sounds: tuple[Sound, ...] = ()
    styles: tuple[int, ...] = ()

    def __add__(self, other: Examples) -> Examples:
        return Examples(
            self.tracks + other.tracks,
            self.times + other.times,
            (*self.targets, *other.targets),
            self.weights + other.weights,
            self.sounds + other.sounds,
            self.styles + other.styles,
        )

    def __len__(self) -> int:
        return len(self.tracks)


class Regressor(Protocol):
    """The class that each file of this folder, or a plugin of `phonanim.regressors`, has as `REGRESSOR`.

    A regressor is usually a frozen dataclass of its `config` and the arrays that it has learned. It is
    written as `tensors()` and `config`, and read by `from_tensors`: there is no `save` or `load` to write.
    `fit` must take chance from `rng` alone, so that the same recipe gives the same bytes. `phonanim train`
    tries out what `fit` returns, and says in one line what does not keep this contract.

    Attributes:
        input_modality: The input that is used: "phones" ignores the sound, "audio" ignores the track, "both"
            needs both.
        config_class: A frozen dataclass of numbers, texts, truth values and tuples of them: the keys of
            [settings] in a recipe. A field without a default must be given there.
        config: The settings that it was trained with.
    """

    input_modality: ClassVar[InputModality]
    config_class: ClassVar[type]
    config: Any

    @classmethod
    def fit(
        cls,
        config: Any,
        train: Examples,
        validation: Examples,
        rng: np.random.Generator,
        progress: Progress,
    ) -> Regressor:
        """Learn from examples; `validation` is used for early stopping only. `progress` takes 0 to 1."""

    def predict(
        self, track: PhoneTrack, times: NDArray[np.float64], sound: Sound | None = None
    ) -> NDArray[np.float32]:
        """Modes at instants of a track or a sound, (times,) seconds -> (times, modes) float32.

        Instants are of any rate, and may lie beyond the ends, where there is silence. None at all give (0,
        modes).
        """

    def tensors(self) -> Tensors:
        """Everything learned: NumPy arrays by name, which weights.safetensors holds."""

    @classmethod
    def from_tensors(cls, config: Any, tensors: Tensors) -> Regressor:
        """The regressor that `tensors` describes. Raises KeyError or ValueError when they do not match."""
