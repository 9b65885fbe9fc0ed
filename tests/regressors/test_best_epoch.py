"""Every network that is trained by epochs keeps the best of them, and drops units in training alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.regressors import Examples, make_config, regressor_class

torch = pytest.importorskip("torch")
AUDIO = {"encoder": "mfcc", "hidden": 6, "depth": 1, "window": 20, "epochs": 4, "learning_rate": 0.05}
DIFFUSES = AUDIO | {"latent": 4, "timesteps": 5, "steps": 2, "batch": 3}
ERRORS = (3.0, 1.0, 2.0, 2.5)  # of four epochs: the second is the best


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=4)


def fitted(kind: str, data: Examples, settings: dict[str, Any]) -> Any:
    fit: Any = regressor_class(kind).fit
    return fit(make_config(kind, settings, "test"), data, data, np.random.default_rng(1), lambda done: None)


@pytest.mark.parametrize(
    ("kind", "module", "judge", "settings"),
    [
        ("phisanet", "_torch_audio", "validation_error", AUDIO),
        ("facediffuser", "_torch_diffusion", "sampled_error", DIFFUSES),
    ],
)
def test_the_best_epoch_of_an_audio_model_is_kept(
    kind: str,
    module: str,
    judge: str,
    settings: dict[str, Any],
    data: Examples,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[dict[str, Any]] = []

    def judged(model: Any, steps: Any) -> float:
        seen.append({name: part.copy() for name, part in model.weights.items()})
        return ERRORS[len(seen) - 1]

    monkeypatch.setattr(f"phonanim.regressors.{module}.{judge}", judged)
    kept = fitted(kind, data, settings).weights
    same = [all(np.array_equal(part, kept[name]) for name, part in epoch.items()) for epoch in seen]
    assert same == [False, True, False, False]


def test_the_best_epoch_of_the_recurrent_network_is_kept(
    data: Examples, monkeypatch: pytest.MonkeyPatch
) -> None:
    from phonanim.regressors import _torch_lstm

    seen: list[Any] = []

    def judged(network: Any, *rest: Any) -> float:
        seen.append(network.output.weight.detach().clone().numpy())
        return ERRORS[len(seen) - 1]

    monkeypatch.setattr(_torch_lstm, "_validate", judged)
    kept = fitted("lstm", data, {"units": 8, "epochs": 4, "rate": 0.05}).tensors()["output"]
    spread = np.concatenate(data.targets).std()
    same = [np.allclose(weight.T * spread, kept, rtol=1e-4) for weight in seen]
    assert same == [False, True, False, False]


def test_the_recurrent_network_drops_units_in_training_alone() -> None:
    from phonanim.regressors._lstm_config import Config, n_inputs
    from phonanim.regressors._torch_lstm import Network

    torch.manual_seed(0)
    network = Network(Config(units=16, dropout=0.5), 3)
    signal = torch.randn(2, 9, n_inputs("triphone"))
    with torch.no_grad():
        assert not torch.equal(network.train()(signal), network(signal))
        assert torch.equal(network.eval()(signal), network(signal))
