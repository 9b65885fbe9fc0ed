"""Audio-driven models of random weights that can stream, and sound for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from phonanim.encoders import RATE
from phonanim.pipeline import load_model
from phonanim.regressors import Model, regressor_class, save
from phonanim.regressors._convolution import convolution_shapes


def made_up_model(folder: Path, kind: str, **more: Any) -> Path:
    """A network of random weights, on the shipped face."""
    face = load_model("default").face
    rng = np.random.default_rng(0)
    found: Any = regressor_class(kind)
    plain = found.config_class()
    config = found.config_class(channels=(16,) * len(plain.kernels), **more)
    shapes, last = convolution_shapes(config, 27)
    shapes |= {"output": (last, len(face.std)), "output_bias": (len(face.std),)}
    weights = {n: rng.normal(0, 1 / np.sqrt(np.prod(s[:-1]) or 1), s) for n, s in shapes.items()}
    weights["output"] *= 20  # mm, so that the mouth moves
    regressor = found(
        config,
        np.zeros((1, 27), np.float32),
        np.full((1, 27), 0.1, np.float32),
        np.zeros(1, np.float32),
        {n: w.astype(np.float32) for n, w in weights.items()},
        "mfcc 27 of 640, no slopes",
    )
    save(Model(regressor, face, {"fps": 25.0}), folder)
    return folder


def speech(seconds: float, rate: int = RATE) -> np.ndarray:
    """Noise that grows and fades."""
    n = round(seconds * rate)
    noise = np.random.default_rng(0).normal(0, 0.2, round(seconds * RATE) + 1)
    drawn = np.interp(np.arange(n) / rate * RATE, np.arange(len(noise)), noise)
    return (drawn * np.sin(np.arange(n) / rate * 9) ** 2).astype(np.float32)
