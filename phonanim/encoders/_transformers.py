"""Encoders that transformers runs: weights from a local folder, never from elsewhere."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import content_hash
from phonanim.encoders import HOP, RATE
from phonanim.encoders._weights import encoder_folder
from phonanim.errors import MissingExtraError, ModelError

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Hidden:
    """A stack of convolutions and transformer layers on the bare wave.

    `model` is transformers' own, `field` the samples that one step hears through the convolutions. Layer
    0 is what enters the transformer, layer i what its block i makes of it.
    """

    model: Any
    field: int
    normalized: bool
    identity: str
    window: int = 20
    margin: int = 2

    @property
    def layers(self) -> int:
        """Blocks, and one for what enters the first of them."""
        return int(self.model.config.num_hidden_layers) + 1

    @property
    def dims(self) -> int:
        """768 for the base models."""
        return int(self.model.config.hidden_size)

    @property
    def start(self) -> float:
        """The middle of what the first step hears, seconds."""
        return self.field / 2 / RATE

    def run(self, samples: Floats) -> Floats:
        """Features of (steps * HOP,) samples -> (steps, layers, dims)."""
        import torch

        if self.normalized:
            samples = (samples - samples.mean()) / np.sqrt(samples.var() + np.float32(1e-7))
        heard = torch.from_numpy(np.pad(samples, (0, self.field - HOP)).astype(np.float32))
        with torch.no_grad():
            found = self.model(heard[None], output_hidden_states=True).hidden_states
        return np.asarray(torch.stack(found, dim=2)[0].numpy(), np.float32)


def load_hidden(name: str, kind: str, example: str) -> Hidden:
    """A model of one of transformers' classes from the encoder's folder; `example` names weights.

    Raises ModelError when there are none, or they are not whole or of another shape, and MissingExtraError.
    """
    folder = encoder_folder(name)
    if not (folder / "config.json").is_file():
        raise ModelError(
            f"{name} has no weights here: put config.json, preprocessor_config.json and model.safetensors of "
            f"such a model (transformers' {kind}, for instance {example}) into {folder}"
        )
    model = _read(folder, kind)
    if int(np.prod(model.config.conv_stride)) != HOP:
        raise ModelError(
            f"{folder}: steps {np.prod(model.config.conv_stride)} samples, not {HOP}; get another model"
        )
    field = 1
    for kernel, stride in zip(model.config.conv_kernel[::-1], model.config.conv_stride[::-1], strict=True):
        field = (field - 1) * stride + kernel
    return Hidden(model, field, _normalized(folder), f"{name} {content_hash(folder)[:16]}")


def _read(folder: Path, kind: str) -> Any:
    from safetensors import SafetensorError

    try:
        import torch
        import transformers
    except ImportError as error:
        raise MissingExtraError("this encoder needs pip install 'phonanim[encoders]'") from error
    transformers.logging.set_verbosity_error()
    transformers.logging.disable_progress_bar()
    try:
        model, told = getattr(transformers, kind).from_pretrained(
            folder, local_files_only=True, output_loading_info=True, use_safetensors=True, dtype=torch.float32
        )
    except (OSError, ValueError, RuntimeError, SafetensorError) as error:
        reason = str(error).strip().splitlines()[0]
        raise ModelError(f"{folder}: cannot be read as {kind} ({reason}); get it again") from error
    missing = sorted(told["missing_keys"])
    if missing:
        raise ModelError(
            f"{folder}: lacks {len(missing)} tensors of {kind}, {missing[0]} the first; get it again"
        )
    return model.eval()


def _normalized(folder: Path) -> bool:
    """Whether the model was trained on sound of unit variance."""
    try:
        told = json.loads((folder / "preprocessor_config.json").read_text("utf-8"))
    except OSError:
        return True  # as most are
    except ValueError as error:
        raise ModelError(
            f"{folder / 'preprocessor_config.json'}: is no JSON ({error}); get it again"
        ) from error
    return bool(told.get("do_normalize", True))
