"""The settings that the audio-driven regressors share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Decoder = Literal["mlp", "lstm", "gru", "rnn", "transformer", "convolution"]


@dataclass(frozen=True)
class Settings:
    """Settings of an audio-driven regressor; `phisanet` and `two_stage` have the published values.

    `encoder` is one of phonanim.encoders; `inputs` is its last layer ("enc"), or all layers with learned
    weights ("all_enc"). `rate` is in hertz, `window` in steps. The weights of the loss are those of the
    velocity and acceleration of the modes (Medina 2023, eq. 4.8), of the phone classifier (4.20) and of
    connectionist temporal classification (4.28). Both learn `labels`: the 41 "phones" of the inventory, or
    the "allophones", which are all labels of the training alignments with their stress (Medina 2023, Table
    4.3). `stride` is the number of steps between two training windows (section 4.7: 1); 0 draws windows at
    random, as many as cover each clip once. The loss is the L1 error until its mean over an epoch is below
    `l1_until`, and the squared error from then on (section 3.2.2); 0 has no such start. `normalize` scales
    targets for the loss: each mode to 0..1, or all modes by one number, which makes the loss the squared
    error in millimetres. `style` is the style of the output, out of the `styles` of Examples.styles: learned
    factors of the decoder's last features (Stan 2023, section 3.3); one style has none.
    """

    encoder: str = "whisper"
    inputs: Literal["enc", "all_enc"] = "enc"
    decoder: Decoder = "gru"
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
    labels: Literal["phones", "allophones"] = "phones"
    stride: int = 0
    l1_until: float = 0.0
    normalize: Literal["minmax", "scale"] = "scale"
    optimizer: Literal["adam", "radam"] = "adam"
    learning_rate: float = 1e-3
    cosine: bool = False
    batch: int = 32
    epochs: int = 40
    patience: int = 10
    styles: int = 1
    style: int = 0
