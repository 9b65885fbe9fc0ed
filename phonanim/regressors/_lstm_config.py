"""Common part of prediction and training of regressors/lstm.py: settings, and the inputs of the network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.features.inputs import n_features, window_features
from phonanim.features.windows import TICK
from phonanim.regressors._styles import check_style, style_columns
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
LAYERS = 2  # recurrent layers
TRIPHONE = 3 * N_PHONES + 2


@dataclass(frozen=True)
class Config:
    """Sizes, dropout and batch are the published ones; rate and epochs were chosen on validation clips.

    `features` is "triphone" (the contextual labels of Fan 2015: the current phone, the one before, the one
    after, and the position in it) or one of phonanim.features.inputs.FEATURES. `units` is the width of each
    layer; in a bidirectional layer, half of them for each direction. `batch` counts utterances. `style` is
    the style of the output, out of the `styles` of Examples.styles: inputs of their own, of which one is 1.
    """

    features: Literal["triphone", "indicators", "raw", "all", "gestures", "classes"] = "triphone"
    units: int = 500
    bidirectional: bool = True
    dropout: float = 0.5
    batch: int = 10
    rate: float = 2e-3
    epochs: int = 20
    patience: int = 5
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("lstm", self)


def sequence_features(features: str, track: PhoneTrack, times: Array, clusters: NDArray[np.int8]) -> Floats:
    """The network's input at instants, (times,) seconds -> (times, features)."""
    return (
        triphones(track, times)
        if features == "triphone"
        else window_features(features, track, times, clusters)
    )


def n_inputs(features: str) -> int:
    """Number of columns of `sequence_features`."""
    return TRIPHONE if features == "triphone" else n_features(features)


def n_columns(config: Config) -> int:
    """Number of input columns, those of styles among them."""
    return n_inputs(config.features) + style_columns(config.styles)


def triphones(track: PhoneTrack, times: Array) -> Floats:
    """Phones before, at and after instants, one-hot; the elapsed share of the phone; and its length.

    (times,) seconds -> (times, 125); the length is in seconds, at most 1.
    """
    segment = track.segment_at(times + TICK)
    around = np.clip(segment[:, None] + np.array([-1, 0, 1]), 0, len(track.codes) - 1)
    found = np.zeros((len(times), TRIPHONE), np.float32)
    columns = track.codes[around] + np.arange(3) * N_PHONES
    np.put_along_axis(found, columns, np.float32(1), axis=1)
    length = np.diff(track.bounds)[segment]
    found[:, -2] = np.clip((times - track.bounds[segment]) / length, 0, 1)
    found[:, -1] = np.minimum(length, 1)
    return found
