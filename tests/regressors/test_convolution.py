"""Convolutions: exactly what is seen, as many steps ahead as is said, the same in torch and in NumPy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.encoders import HOP, RATE, load_encoder
from phonanim.encoders._cepstra import Cepstra
from phonanim.errors import ModelError
from phonanim.regressors import make_config, regressor_class
from phonanim.regressors._convolution import convolution_shapes, convolve, receptive_field
from phonanim.regressors._steps import cached_encoder
from phonanim.regressors._streaming import Streamed

KINDS = {"cnn": (23, 7), "tcn": (15, 0)}  # steps seen, steps ahead


def config_of(kind: str, **more: Any) -> Any:
    return make_config(kind, more, "test")


def random_weights(config: Any, dims: int = 4) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    shapes = convolution_shapes(config, dims)[0]
    return {name: rng.normal(0, 0.3, shape).astype(np.float32) for name, shape in shapes.items()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ahead", [0, 3, 7])
def test_a_step_sees_what_is_said_and_no_more(kind: str, ahead: int) -> None:
    config = replace(config_of(kind), ahead=ahead, channels=(8,) * len(config_of(kind).kernels))
    weights = random_weights(config)
    signal = np.random.default_rng(1).normal(size=(1, 80, 4)).astype(np.float32)
    other = signal.copy()
    other[0, 40] += 1
    moved = np.flatnonzero(
        np.abs(convolve(config, weights, other) - convolve(config, weights, signal))[0].max(1)
    )
    assert moved[0] == 40 - ahead
    assert moved[-1] == 40 + receptive_field(config) - 1 - ahead


@pytest.mark.parametrize("kind", KINDS)
def test_the_published_fields(kind: str) -> None:
    """Medina (2023), Tables 5.2 and 5.3, three layers."""
    config = config_of(kind)
    assert (receptive_field(config), config.ahead) == KINDS[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_torch_and_numpy_agree(kind: str) -> None:
    torch = pytest.importorskip("torch")
    from phonanim.regressors._decoders import decode
    from phonanim.regressors._torch_decoders import Network, export_weights

    config = config_of(kind)
    torch.manual_seed(3)
    network = Network(config, 1, 6, 3).eval()
    values = torch.randn(2, 40, 1, 6)
    with torch.no_grad():
        found = network(values)[1].numpy()
    _, weights = export_weights(network, np.zeros(3, np.float32), np.ones(3, np.float32))
    np.testing.assert_allclose(decode(config, weights, values[:, :, 0].numpy()), found, atol=1e-4)


def test_latency_is_that_of_the_encoder_the_steps_and_one_between() -> None:
    made = {kind: untrained(kind) for kind in KINDS}
    assert made["cnn"].look_ahead == pytest.approx(0.02 + 7 * 0.02 + 0.02)
    assert made["cnn"].look_ahead <= 0.2
    assert made["tcn"].look_ahead == pytest.approx(0.04)
    assert (made["cnn"].before, made["cnn"].ahead) == (15, 7)
    assert untrained("cnn", encoder="mfcc").look_ahead == pytest.approx(0.265)


def untrained(kind: str, **more: Any) -> Streamed:
    found = regressor_class(kind)
    assert issubclass(found, Streamed)
    config = config_of(kind, **more)
    empty = np.zeros((1, 1), np.float32)
    return found(config, empty, empty, np.zeros(1, np.float32), {}, "")


def test_an_encoder_of_whole_recordings_cannot_be_streamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from encoder_samples import put_whisper

    put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    cached_encoder.cache_clear()
    with pytest.raises(ModelError, match="'whisper' needs a whole recording and cannot be streamed; train"):
        _ = untrained("cnn", encoder="whisper").look_ahead
    cached_encoder.cache_clear()


@pytest.mark.parametrize("name", ["mfcc", "mfcc_live"])
def test_what_reaches_a_feature(name: str) -> None:
    """Sound beyond the reach of a step does not change it; sound within does."""
    encoder = load_encoder(name)
    assert isinstance(encoder, Cepstra)
    noise = np.random.default_rng(0).normal(0, 0.1, RATE).astype(np.float32)
    step = 25
    for beyond, changed in ((0, False), (-encoder.size // 4, True)):
        other = noise.copy()
        other[step * HOP + encoder.reach + beyond :] = 0
        assert (encoder.run(other)[step] != encoder.run(noise)[step]).any() == changed
        other = noise.copy()
        other[: step * HOP - encoder.reach - beyond] = 0
        assert (encoder.run(other)[step] != encoder.run(noise)[step]).any() == changed


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"kernels": [3, 3]},
            "kernels, dilations and channels differ in length; give each layer one of each",
        ),
        ({"ahead": 23}, "ahead is 23 steps; these layers allow 0 to 22"),
        ({"ahead": -1}, "ahead is -1 steps; these layers allow 0 to 22"),
    ],
)
def test_layers_that_do_not_fit(more: dict[str, Any], message: str) -> None:
    pytest.importorskip("torch")
    data = made_up_examples(np.random.default_rng(0), clips=2)
    fit: Any = regressor_class("cnn").fit
    config = make_config("cnn", more | {"encoder": "mfcc"}, "test")
    with pytest.raises(ModelError, match=message):
        fit(config, data, data, np.random.default_rng(0), lambda done: None)
