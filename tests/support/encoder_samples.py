"""Encoders of small random weights, one that only measures loudness, and sound for them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from phonanim.encoders import HOP, RATE
from phonanim.media.audio import Sound

HIDDEN = {"wav2vec2": "Wav2Vec2", "hubert": "Hubert", "wavlm": "WavLM"}


def speech(seconds: float = 1.0, rate: int = RATE, seed: int = 0) -> Sound:
    """Noise that swells and fades."""
    noise = np.random.default_rng(seed).normal(0, 0.1, round(seconds * rate))
    swell = 1 + np.sin(np.arange(len(noise)) / rate * 9)
    return Sound((noise * swell).astype(np.float32), rate)


def whisper_parts(dims: int = 8, blocks: int = 2) -> dict[str, np.ndarray]:
    """A small random Whisper by the names of transformers."""
    rng = np.random.default_rng(3)
    shapes: dict[str, tuple[int, ...]] = {
        "conv1.weight": (dims, 80, 3),
        "conv2.weight": (dims, dims, 3),
        "embed_positions.weight": (1500, dims),
        "layer_norm.weight": (dims,),
    }
    for block in range(blocks):
        for part in ("q_proj", "k_proj", "v_proj", "out_proj"):
            shapes[f"layers.{block}.self_attn.{part}.weight"] = (dims, dims)
        shapes[f"layers.{block}.fc1.weight"] = (4 * dims, dims)
        shapes[f"layers.{block}.fc2.weight"] = (dims, 4 * dims)
        for part in ("self_attn_layer_norm", "final_layer_norm"):
            shapes[f"layers.{block}.{part}.weight"] = (dims,)
    biases = {
        n.replace("weight", "bias"): s[:1]
        for n, s in shapes.items()
        if "embed" not in n and "k_proj" not in n
    }
    parts = {n: rng.normal(0, 0.3, s) for n, s in (shapes | biases).items()}
    return {f"model.encoder.{n}": part.astype(np.float32) for n, part in parts.items()}


def put_whisper(folder: Path, parts: dict[str, np.ndarray] | None = None) -> Path:
    """Random weights where `whisper` looks for them."""
    place = folder / "whisper"
    place.mkdir(parents=True, exist_ok=True)
    save_file(parts or whisper_parts(), place / "model.safetensors")
    (place / "config.json").write_text(json.dumps({"encoder_attention_heads": 2}))
    return place


def put_hidden(folder: Path, name: str, wide: int = 32, stable: bool = False) -> None:
    """A small random model of transformers where an encoder looks for it; `stable` normalizes first."""
    torch, transformers = pytest.importorskip("torch"), pytest.importorskip("transformers")
    config = getattr(transformers, f"{HIDDEN[name]}Config")(
        hidden_size=24,
        num_hidden_layers=2,
        num_attention_heads=2,
        intermediate_size=wide,
        do_stable_layer_norm=stable,
        conv_dim=(8,) * 7,
        num_conv_pos_embeddings=16,
        num_conv_pos_embedding_groups=2,
    )
    torch.manual_seed(0)
    getattr(transformers, f"{HIDDEN[name]}Model")(config).save_pretrained(folder / name)


def put(folder: Path, name: str) -> None:
    """Whatever weights an encoder needs."""
    if name == "whisper":
        put_whisper(folder)
    elif name in HIDDEN:
        put_hidden(folder, name)
    elif name == "phones":
        pytest.importorskip("pocketsphinx")


@dataclass(frozen=True)
class Loudness:
    """An encoder that is quick and remembers how much it read at a time."""

    lengths: list[int]
    identity: str = "loudness"
    layers: int = 1
    dims: int = 2
    start: float = 0.0
    window: int = 12
    margin: int = 1

    def run(self, samples: np.ndarray) -> np.ndarray:
        self.lengths.append(len(samples))
        blocks = samples.reshape(-1, HOP)
        return np.stack([blocks.mean(axis=1), np.full(len(blocks), 1.0)], axis=1)[:, None].astype(np.float32)
