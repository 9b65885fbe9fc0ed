"""wav2vec 2.0, HuBERT and WavLM: the layers of transformers, and weights that are damaged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from encoder_samples import put_hidden, speech
from safetensors.numpy import load_file, save_file

from phonanim.encoders import load_encoder
from phonanim.errors import MissingExtraError, ModelError


@pytest.mark.slow
def test_hidden_layers_are_those_of_transformers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_hidden(tmp_path, "hubert")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    import torch
    import transformers

    model = transformers.HubertModel.from_pretrained(tmp_path / "hubert").eval()
    samples = speech(0.5).samples
    normal = (samples - samples.mean()) / np.sqrt(samples.var() + 1e-7)
    with torch.no_grad():
        padded = torch.from_numpy(np.pad(normal, (0, 80)).astype(np.float32))[None]
        found = model(padded, output_hidden_states=True).hidden_states
    mine = load_encoder("hubert").run(samples)
    for layer, theirs in enumerate(found):
        np.testing.assert_allclose(mine[:, layer], theirs[0].numpy(), atol=1e-5)


def test_transformers_absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "hubert").mkdir()
    (tmp_path / "hubert" / "config.json").write_text("{}")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    monkeypatch.setitem(__import__("sys").modules, "transformers", None)
    with pytest.raises(MissingExtraError, match=r"needs pip install 'phonanim\[encoders\]'"):
        load_encoder("hubert")


def edit_hidden(folder: Path, **changes: Any) -> None:
    path = folder / "hubert" / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_hidden_weights_that_are_not_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_hidden(tmp_path, "hubert")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    weights = tmp_path / "hubert" / "model.safetensors"
    whole = weights.read_bytes()
    tensors = load_file(weights)
    del tensors["encoder.layer_norm.weight"]
    save_file(tensors, weights, metadata={"format": "pt"})
    with pytest.raises(ModelError, match=r"hubert: lacks 1 tensors of HubertModel, first encoder.layer_norm"):
        load_encoder("hubert")
    weights.write_bytes(whole[:1000])
    with pytest.raises(ModelError, match=r"hubert: cannot be read as HubertModel \(.*; get it again"):
        load_encoder("hubert")
    weights.write_bytes(whole)
    (tmp_path / "hubert" / "preprocessor_config.json").write_text("{")
    with pytest.raises(ModelError, match=r"preprocessor_config.json: is not valid JSON"):
        load_encoder("hubert")
    edit_hidden(tmp_path, conv_stride=[5, 2, 2, 2, 2, 2, 1])
    with pytest.raises(ModelError, match=r"hubert: a step has 160 samples, not 320; get another model"):
        load_encoder("hubert")
    edit_hidden(tmp_path, hidden_size=48)
    with pytest.raises(ModelError, match=r"hubert: cannot be read as HubertModel"):
        load_encoder("hubert")


def test_sound_may_not_be_normalized(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_hidden(tmp_path, "wavlm")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    plain = load_encoder("wavlm")
    (tmp_path / "wavlm" / "preprocessor_config.json").write_text('{"do_normalize": false}')
    other = load_encoder("wavlm")
    assert plain.identity != other.identity
    assert not np.allclose(plain.run(speech(0.2).samples), other.run(speech(0.2).samples))
