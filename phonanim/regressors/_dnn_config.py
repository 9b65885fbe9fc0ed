"""The settings of regressors/dnn.py."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from phonanim.features.indicators import WIDTH
from phonanim.regressors._styles import check_style


@dataclass(frozen=True)
class Config:
    """The defaults are ours; `taylor2017` in benchmarks/configs has the published values.

    `features` is one of phonanim.features.inputs.FEATURES, `reach` the input window (Kx) in frames of "raw"
    and "indicators", `width` the output window (Ky), `hidden` the units of each hidden layer. `networks` is
    the number of networks, each trained from another start; their mean is the prediction. `schedule` is how
    the rate goes over all `epochs`: "constant", "cosine" down to 0, or "cycle", up within a tenth and down;
    "" is "cycle" for adamw and "constant" for sgd. `style` is the style of the output, out of the `styles` of
    Examples.styles: inputs of their own, of which one is 1.
    """

    features: Literal["indicators", "raw", "all", "gestures", "classes"] = "all"
    reach: int = WIDTH
    width: int = 1
    hidden: tuple[int, ...] = (256, 256)
    activation: Literal["silu", "tanh"] = "silu"
    dropout: float = 0.3
    optimizer: Literal["adamw", "sgd"] = "adamw"
    rate: float = 2e-3
    momentum: float = 0.0
    schedule: Literal["", "constant", "cosine", "cycle"] = ""
    decay: float = 1e-2
    batch: int = 512
    epochs: int = 12
    patience: int = 5
    standardize: bool = True
    networks: int = 1
    styles: int = 1
    style: int = 0

    def __post_init__(self) -> None:
        check_style("dnn", self)
