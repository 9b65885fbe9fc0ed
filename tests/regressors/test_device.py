"""Every tensor of a training follows the device: on one that holds no numbers, a stranger is an error."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from encoder_samples import put_whisper
from speech import made_up_examples

from phonanim.__main__ import run
from phonanim.core.device import use_device
from phonanim.errors import OptionError
from phonanim.regressors import Examples, kinds, make_config, regressor_class
from phonanim.regressors._steps import cached_encoder

torch = pytest.importorskip("torch")
AUDIO: dict[str, Any] = {"encoder": "mfcc", "hidden": 8, "depth": 1, "window": 20, "epochs": 1}
SAMPLES: dict[str, Any] = {**AUDIO, "latent": 8, "timesteps": 20, "steps": 4, "batch": 3}
TUNED: dict[str, Any] = {"encoder": "whisper", "pairs": "concatenate", "tuned": 1}
MEMBERS: tuple[dict[str, Any], ...] = (
    {"kind": "phisanet", **AUDIO, "ctc": 0.0},
    {"kind": "dnn", "hidden": (8,), "epochs": 1},
)
NO_TORCH = {"dynamic_visemes", "hmm", "phone_mean", "tree"}
VERSIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "gru": ("phisanet", {**AUDIO, "classifier": 0.1, "ctc": 0.0}),
    "sequence": ("phisanet", {**AUDIO, "ctc": 0.1}),
    "windows": ("two_stage", {**AUDIO, "decoder": "mlp", "widths": (5, 3)}),
    "attention": ("two_stage", {**AUDIO, "decoder": "transformer", "heads": 2}),
    "convolution": ("cnn", {"encoder": "mfcc", "epochs": 1}),
    "diffusion": ("facediffuser", SAMPLES),
    "diffusion by attention": ("facediffuser", {**SAMPLES, "decoder": "transformer", "heads": 2}),
    "features": ("facediffuser", {**SAMPLES, "noise_over": "features"}),
    "first stage": ("facediffuser", {**SAMPLES, "autoencoder": 1}),
    "further trained": ("facediffuser", {**SAMPLES, **TUNED}),
    "styles from sound": ("phisanet", {**AUDIO, "ctc": 0.0, "styles": 2}),
    "sampled styles": ("facediffuser", {**SAMPLES, "styles": 2}),
    "causal": ("tcn", {"encoder": "mfcc", "epochs": 1, "channels": (4,) * 6}),
    "both": ("hybrid", AUDIO),
    "mean of both": ("late_fusion", {"members": MEMBERS}),
    "teacher": ("ensemble", {"members": MEMBERS[1:]}),
    "network": ("dnn", {"hidden": (8,), "epochs": 1}),
    "as published": ("dnn", {"hidden": (8,), "epochs": 1, "optimizer": "sgd", "features": "raw", "width": 5}),
    "styles from phones": ("dnn", {"hidden": (8,), "epochs": 1, "styles": 2}),
    "recurrent": ("lstm", {"units": 8, "epochs": 1}),
    "recurrent styles": ("lstm", {"units": 8, "epochs": 1, "styles": 2}),
    "dominance": ("procedural", {"steps": 3}),
}


class ReachedEndError(Exception):
    """Training has come to reading a number, which the device "meta" cannot give."""


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=4)


@pytest.fixture
def small_whisper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Whisper with two small random blocks."""
    put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    cached_encoder.cache_clear()
    yield
    cached_encoder.cache_clear()


@pytest.fixture
def meta(monkeypatch: pytest.MonkeyPatch) -> None:
    """Training goes to "meta", whose tensors have shapes and no numbers; steps are counted, not read."""
    names = ("", "_audio", "_diffusion", "_dnn", "_lstm", "_procedural")
    # All are imported before one is changed: they take `device` from the first.
    parts = [import_module(f"phonanim.regressors._torch{name}") for name in names]
    for part in parts:
        monkeypatch.setattr(part, "device", lambda: torch.device("meta"))

    def first_step(optimizer: Any, *given: Any, **named: Any) -> None:
        for group in optimizer.param_groups:
            for part in group["params"]:
                assert part.device.type == "meta"
                assert part.grad is None or part.grad.device.type == "meta"
        raise ReachedEndError

    def sequence_loss(scores: Any, labels: Any, *lengths: Any, **named: Any) -> Any:
        """In place of PyTorch's, which has no version without numbers; lengths may be on the processor."""
        assert (scores.device.type, labels.device.type) == ("meta", "meta")
        assert scores.shape[1] == len(lengths[0]) == len(lengths[1])
        return scores.mean()

    monkeypatch.setattr(torch.nn.functional, "ctc_loss", sequence_loss)
    for kind in ("Adam", "AdamW", "RAdam", "SGD"):
        monkeypatch.setattr(getattr(torch.optim, kind), "step", first_step)


@pytest.mark.usefixtures("meta", "small_whisper")
@pytest.mark.parametrize("version", VERSIONS)
def test_every_tensor_follows(version: str, data: Examples) -> None:
    kind, settings = VERSIONS[version]
    if "styles" in settings:
        data = replace(data, styles=(0, 1, 0, 1))
    config = make_config(kind, settings, "test")
    with pytest.raises(ReachedEndError):
        regressor_class(kind).fit(config, data, data, np.random.default_rng(1), lambda done: None)


def test_no_kind_is_left_out() -> None:
    assert {kind for kind, _ in VERSIONS.values()} | NO_TORCH == set(kinds())


def test_apple_gets_single_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    from phonanim.regressors import _torch

    class Stands:
        type = "mps"

    asked: list[Any] = []
    monkeypatch.setattr(_torch, "device", Stands)
    monkeypatch.setattr(torch.Tensor, "to", lambda self, place: asked.append(place) or self)
    assert _torch.tensor(np.zeros(2)).dtype == torch.float32
    assert _torch.tensor(np.zeros(2, np.int64)).dtype == torch.int64
    assert [type(one) for one in asked] == [Stands, Stands]


def test_a_stranger_is_found() -> None:
    with pytest.raises(RuntimeError):
        torch.zeros(2, device="meta") + torch.zeros(2)


@pytest.mark.parametrize("kind", ["phisanet", "facediffuser"])
def test_the_processor_is_the_default(kind: str, data: Examples) -> None:
    config = make_config(kind, AUDIO if kind == "phisanet" else SAMPLES, "test")
    made = []
    for name in (None, "cpu", "auto"):
        if name == "auto" and (torch.cuda.is_available() or torch.backends.mps.is_available()):
            continue
        with use_device(name or "cpu"):
            fit: Any = regressor_class(kind).fit
            made.append(fit(config, data, data, np.random.default_rng(1), lambda done: None).tensors())
    for other in made[1:]:
        assert all(np.array_equal(made[0][name], other[name]) for name in made[0])


@pytest.mark.parametrize("version", ["gru", "diffusion", "network", "recurrent"])
def test_sixteen_bits_come_near(version: str, data: Examples) -> None:
    """Half of the bits change the weights a little, and only where they are asked for."""
    kind, settings = VERSIONS[version]
    config, made = make_config(kind, settings, "test"), []
    for precision in ("single", "bf16", "single"):
        with use_device("cpu", precision):
            fit: Any = regressor_class(kind).fit
            made.append(fit(config, data, data, np.random.default_rng(1), lambda done: None).tensors())
    single, half, again = made
    learned = [name for name, part in single.items() if part.dtype == np.float32]
    assert all(np.array_equal(single[name], again[name]) for name in learned)
    assert any(not np.array_equal(single[name], half[name]) for name in learned)
    for name in learned:
        assert half[name].dtype == np.float32
        apart = np.abs(single[name] - half[name]).max()
        assert apart < 0.1 * max(1.0, float(np.abs(single[name]).max()))


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is such a device")
def test_a_device_that_is_not_there(
    data: Examples, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = make_config("phisanet", AUDIO, "test")
    with use_device("cuda"), pytest.raises(OptionError, match="PyTorch finds no such device here"):
        regressor_class("phisanet").fit(config, data, data, np.random.default_rng(1), lambda done: None)
    (tmp_path / "recipe.toml").write_text('kind = "phisanet"\ncorpus = "none"\n', "utf-8")
    assert run(["train", str(tmp_path / "recipe.toml"), "--device", "gpu"]) == 2
    assert "is not one of" in capsys.readouterr().err
