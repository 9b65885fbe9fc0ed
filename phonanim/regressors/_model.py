"""A trained regressor with what it moves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import ModelError
from phonanim.face.model import FaceModel
from phonanim.inputs.speech_input import InputModality
from phonanim.media.audio import Sound
from phonanim.regressors._kinds import kind_of
from phonanim.regressors._protocol import NEEDS, Regressor, Tensors
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.targets import Target


@dataclass(frozen=True)
class Model:
    """A trained regressor with what it moves, the face of its modes, and its card (model.json).

    `target` is the reference face, or one of phonanim.targets.

    `articulation` is what phonanim.articulation.from_audio has learned with it, for audio-driven models.
    `recognizer` is the file of the network that recognizes the phones of a recording, for models that do.

    Examples:
        >>> import phonanim
        >>> model = phonanim.load_model("default")
        >>> model.regressor.input_modality
        'phones'
        >>> phonanim.animate("line.TextGrid", model="default").save("line.csv")
    """

    regressor: Regressor
    target: Target
    card: dict[str, Any]
    articulation: Tensors | None = None
    recognizer: Path | None = None

    @property
    def input_modality(self) -> InputModality:
        """The input that is used, as of its regressor; "recognized" where a recording may be read."""
        return self.regressor.input_modality if self.recognizer is None else "recognized"

    @property
    def face(self) -> FaceModel:
        """The reference face of a model of landmarks. Raises ModelError for another target."""
        if isinstance(self.target, FaceModel):
            return self.target
        raise ModelError(
            f"the model moves {self.target.kind}, not landmarks of a face: use phonanim animate or "
            "phonanim corpus score with it"
        )

    def style_name(self, number: int | None) -> str:
        """The name of a style that it has learned, or "" where it has none of that number."""
        styles = self.card.get("styles", [])
        return str(styles[number]) if number is not None and number < len(styles) else ""

    def predict(
        self,
        track: PhoneTrack | None,
        fps: float,
        frames: int,
        start: float = 0.0,
        sound: Sound | None = None,
    ) -> NDArray[np.float32]:
        """Modes at the instants start + n / fps, -> (frames, modes) float32.

        Raises ModelError when the input that the model needs is missing.
        """
        modality = self.regressor.input_modality
        if track is None and sound is not None and modality == "audio":
            track = silent_track(sound.duration)
        if track is None or (sound is None and modality != "phones"):
            raise ModelError(f"a model of kind {kind_of(self.regressor)} needs {NEEDS[modality]}")
        return self.regressor.predict(track, start + np.arange(frames) / fps, sound)


def in_style(model: Model, names: Iterable[str]) -> Regressor:
    """The regressor of a model in the first of these styles that it has learned, else in the one it has."""
    known, regressor = model.card.get("styles", []), model.regressor
    for name in names:
        if name in known and hasattr(regressor, "with_settings"):
            styled: Regressor = regressor.with_settings(style=known.index(name))
            return styled
    return regressor
