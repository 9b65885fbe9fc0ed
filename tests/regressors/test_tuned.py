"""The last blocks of an encoder, trained further with FaceDiffuser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from encoder_samples import put_hidden, put_whisper
from speech import made_up_examples

from phonanim.encoders import encode
from phonanim.encoders.whisper import Whisper
from phonanim.errors import ModelError
from phonanim.regressors import Examples, make_config
from phonanim.regressors import _diffusion as diffusion
from phonanim.regressors._denoiser import Denoiser
from phonanim.regressors._steps import cached_encoder
from phonanim.regressors._tuned import last_blocks, run_blocks
from phonanim.regressors.facediffuser import FaceDiffuser

torch = pytest.importorskip("torch")
SMALL: dict[str, Any] = {
    **{"encoder": "whisper", "latent": 4, "hidden": 6, "depth": 1, "timesteps": 10, "steps": 2},
    **{"window": 20, "batch": 3, "epochs": 1, "learning_rate": 0.01, "pairs": "concatenate", "tuned": 1},
}


@pytest.fixture(autouse=True)
def whisper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Whisper with two small random blocks."""
    put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    cached_encoder.cache_clear()
    yield cached_encoder("whisper")
    cached_encoder.cache_clear()


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=3)


def config_of(**more: Any) -> Any:
    return make_config("facediffuser", SMALL | more, "test")


def trained(data: Examples, **more: Any) -> FaceDiffuser:
    return FaceDiffuser.fit(config_of(**more), data, data, np.random.default_rng(1), lambda done: None)


@pytest.mark.parametrize("count", [1, 2])
def test_untrained_blocks_are_those_of_the_encoder(count: int, whisper: Whisper, data: Examples) -> None:
    values = encode(whisper, data.sounds[0]).values
    values = values[: len(values) // 2 * 2].astype(np.float32)
    weights, heads = last_blocks(whisper, count)
    before = values[:, -1 - count].reshape(len(values) // 2, -1)
    found = run_blocks(weights, count, heads, before).reshape(len(values), -1)
    # All but the end, where the encoder attends to the sound that was cut off here.
    np.testing.assert_allclose(found[:-3], values[:-3, -1], atol=0.05)


def test_torch_and_numpy_agree(whisper: Whisper) -> None:
    from phonanim.regressors._torch_tuned import Tuned

    torch.manual_seed(0)
    tuned = Tuned(whisper, 2, 0.0).eval()
    pairs = torch.randn(3, 5, 2 * whisper.dims)
    with torch.no_grad():
        for part in tuned.parameters():
            part.add_(0.1 * torch.randn_like(part))
        expected = tuned(pairs).numpy()
    weights = {name: part.detach().numpy() for name, part in tuned.export().items()}
    np.testing.assert_allclose(run_blocks(weights, 2, whisper.heads, pairs.numpy()), expected, atol=1e-5)


def test_the_blocks_are_trained_and_kept(whisper: Whisper, data: Examples) -> None:
    model, frozen = trained(data), trained(data, tuned=0)
    before = last_blocks(whisper, 1)[0]
    for name in ("block0_query", "block0_wide", "norm"):
        assert not np.allclose(model.weights[f"tuned_{name}"], before[name], atol=1e-6)
    assert not any(name.startswith("tuned_") for name in frozen.weights)
    shapes = diffusion.weight_shapes(model.config, 2 * whisper.dims, data.targets[0].shape[1])
    assert {name: part.shape for name, part in model.weights.items()} == shapes
    again, times = FaceDiffuser.from_tensors(model.config, model.tensors()), np.arange(20) / 25
    found = again.predict(None, times, data.sounds[0])
    assert np.isfinite(found).all()
    assert np.array_equal(found, model.predict(None, times, data.sounds[0]))
    assert not np.array_equal(found, frozen.predict(None, times, data.sounds[0]))


def test_masks_hide_the_same_with_blocks_that_are_trained(data: Examples) -> None:
    """Where the blocks are untrained, the network gets what it gets from a frozen encoder."""
    from phonanim.regressors._torch_denoiser import Network
    from phonanim.regressors._torch_diffusion import Stage, diffusion_steps, scaled

    parts = []
    for count in (0, 1):
        config = config_of(tuned=count, masking="partial random", masked=0.4)
        steps = diffusion_steps(config, data)
        network = Network(config, steps.values.shape[2], 3).eval()
        stage = Stage(config, network, steps, scaled(config, steps), 0)
        rows = np.arange(steps.lengths[0])[None]
        values = torch.from_numpy(steps.values[rows].astype(np.float32))
        parts.append(stage.masked(values, np.random.default_rng(4)).detach().numpy()[:, :-3])
    np.testing.assert_allclose(parts[0], parts[1], atol=0.05)


def test_blocks_of_hubert(tmp_path: Path, data: Examples) -> None:
    """Untrained, they are the encoder's, in NumPy and in torch; then they are trained, kept and read."""
    from phonanim.regressors._torch_tuned import Tuned

    pytest.importorskip("transformers")
    put_hidden(tmp_path, "hubert", wide=96)
    hubert = cached_encoder("hubert")
    values = hubert.run(data.sounds[0].samples[:6400])
    weights, heads = last_blocks(hubert, 2)
    pairs = values[:, 0].reshape(1, len(values) // 2, -1)
    found = run_blocks(weights, 2, heads, pairs)
    np.testing.assert_allclose(found.reshape(len(values), -1), values[:, -1], atol=1e-4)
    tuned = Tuned(hubert, 2, 0.0).eval()
    with torch.no_grad():
        np.testing.assert_allclose(tuned(torch.from_numpy(pairs)).numpy(), found, atol=1e-4)
    model = trained(data, encoder="hubert")
    before = last_blocks(hubert, 1)[0]
    for name in ("block0_query", "block0_norm2", "block0_wide"):
        assert not np.allclose(model.weights[f"tuned_{name}"], before[name], atol=1e-6)
    again, times = FaceDiffuser.from_tensors(model.config, model.tensors()), np.arange(20) / 25
    assert np.array_equal(
        again.predict(None, times, data.sounds[0]), model.predict(None, times, data.sounds[0])
    )


def test_blocks_that_are_no_plain_ones(tmp_path: Path, data: Examples) -> None:
    pytest.importorskip("transformers")
    put_hidden(tmp_path, "wavlm")
    with pytest.raises(ModelError, match="the blocks of this wavlm cannot be trained further; use a base"):
        trained(data, encoder="wavlm")
    put_hidden(tmp_path, "wav2vec2", stable=True)
    with pytest.raises(ModelError, match="the blocks of this wav2vec2 cannot be trained further"):
        trained(data, encoder="wav2vec2")
    put_hidden(tmp_path, "hubert")
    with pytest.raises(ModelError, match="tuned needs blocks that are 4 times as wide inside"):
        trained(data, encoder="hubert")


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"pairs": "average"}, 'tuned needs pairs "concatenate" and the rate 25'),
        ({"rate": 30.0}, 'tuned needs pairs "concatenate" and the rate 25'),
        ({"tuned": -1}, "tuned is -1; take 0 or more blocks"),
    ],
)
def test_settings_that_cannot_be(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        config_of(**settings)


def test_encoders_without_such_blocks(whisper: Whisper, data: Examples) -> None:
    with pytest.raises(ModelError, match="tuned is 3; the encoder has 2 blocks"):
        last_blocks(whisper, 3)
    with pytest.raises(ModelError, match="tuned needs the encoder whisper, hubert or wav2vec2, not"):
        trained(data, encoder="mfcc")


def test_the_input_of_the_blocks_is_kept_beside_their_output(whisper: Whisper, data: Examples) -> None:
    found = Denoiser.input_features(config_of(), data.sounds[0], None).values
    whole = encode(whisper, data.sounds[0]).values
    assert np.array_equal(found, whole[:, [1, 2]])
