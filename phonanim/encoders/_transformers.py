"""Encoders that run with transformers; their weights come from a local folder, never from the network."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError, decode_table, read_json
from phonanim.core.files import content_hash
from phonanim.encoders import HOP, RATE
from phonanim.encoders._weights import MAX_CONFIG, encoder_folder
from phonanim.errors import MissingExtraError, ModelError

Floats = NDArray[np.float32]
PLAIN = ("hubert", "wav2vec2")  # models whose blocks are plain transformers
BLOCK = {
    "query": "attention.q_proj",
    "key": "attention.k_proj",
    "value": "attention.v_proj",
    "out": "attention.out_proj",
    "norm1": "layer_norm",
    "wide": "feed_forward.intermediate_dense",
    "narrow": "feed_forward.output_dense",
    "norm2": "final_layer_norm",
}
"""Names of the weights of a block, and those of transformers."""


@dataclass(frozen=True)
class Hidden:
    """A stack of convolutions and transformer layers on the raw waveform.

    `model` is the transformers object, `field` the number of samples that one step covers through the
    convolutions. Layer 0 is the input of the transformer, layer i the output of its block i.
    """

    model: Any
    field: int
    normalized: bool
    identity: str
    window: int = 20
    margin: int = 2

    @property
    def layers(self) -> int:
        """Number of blocks, plus one for the input of the first block."""
        return int(self.model.config.num_hidden_layers) + 1

    @property
    def dims(self) -> int:
        """768 for the base models."""
        return int(self.model.config.hidden_size)

    @property
    def start(self) -> float:
        """The centre of the samples that the first step covers, in seconds."""
        return self.field / 2 / RATE

    @property
    def heads(self) -> int:
        """Heads of the attention of a block."""
        return int(self.model.config.num_attention_heads)

    @cached_property
    def tensors(self) -> dict[str, Floats]:
        """The weights of the blocks as `core.neural.transformer_block` names them, after blockN_.

        The blocks normalize their sums. Raises ModelError for blocks of another kind, such as those of WavLM
        and of large models.
        """
        config = self.model.config
        if config.model_type not in PLAIN or config.hidden_act != "gelu" or config.do_stable_layer_norm:
            raise ModelError(
                f"the blocks of this {config.model_type} cannot be trained further; use a base model of "
                f"{' or '.join(PLAIN)}"
            )
        state, found = self.model.encoder.state_dict(), dict[str, Floats]()
        for block in range(self.layers - 1):
            for ours, theirs in BLOCK.items():
                for suffix, part in (("", "weight"), ("_bias", "bias")):
                    tensor = state[f"layers.{block}.{theirs}.{part}"].numpy()
                    found[f"block{block}_{ours}{suffix}"] = np.ascontiguousarray(tensor.T, np.float32)
        return found

    def run(self, samples: Floats) -> Floats:
        """Features of (steps * HOP,) samples -> (steps, layers, dims)."""
        import torch

        if self.normalized:
            samples = (samples - samples.mean()) / np.sqrt(samples.var() + np.float32(1e-7))
        padded = torch.from_numpy(np.pad(samples, (0, self.field - HOP)).astype(np.float32))
        with torch.no_grad():
            found = self.model(padded[None], output_hidden_states=True).hidden_states
        return np.asarray(torch.stack(found, dim=2)[0].numpy(), np.float32)


def load_hidden(name: str, kind: str, example: str) -> Hidden:
    """A model of a transformers class from the encoder's folder; `example` names suitable weights.

    Raises ModelError when weights are missing, damaged or of another shape, and MissingExtraError.
    """
    folder = encoder_folder(name)
    if not (folder / "config.json").is_file():
        raise ModelError(
            f"{name} has no weights: put config.json, preprocessor_config.json and model.safetensors of "
            f"such a model (transformers' {kind}, for instance {example}) into {folder}"
        )
    model = _read(folder, kind)
    if int(np.prod(model.config.conv_stride)) != HOP:
        raise ModelError(
            f"{folder}: a step has {np.prod(model.config.conv_stride)} samples, not {HOP}; get another model"
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
        model, loading = getattr(transformers, kind).from_pretrained(
            folder, local_files_only=True, output_loading_info=True, use_safetensors=True, dtype=torch.float32
        )
    except (OSError, ValueError, RuntimeError, SafetensorError) as error:
        reason = str(error).strip().splitlines()[0]
        raise ModelError(f"{folder}: cannot be read as {kind} ({reason}); get it again") from error
    missing = sorted(loading["missing_keys"])
    if missing:
        raise ModelError(
            f"{folder}: lacks {len(missing)} tensors of {kind}, first {missing[0]}; get it again"
        )
    return model.eval()


def _normalized(folder: Path) -> bool:
    """Whether the model was trained on audio of unit variance."""
    try:
        path = folder / "preprocessor_config.json"
        settings = decode_table(read_json(path, MAX_CONFIG), "the file")
    except OSError:
        return True  # like most models
    except DecodeError as error:
        raise ModelError(
            f"{folder / 'preprocessor_config.json'}: is not valid JSON ({error}); get it again"
        ) from error
    return bool(settings.get("do_normalize", True))
