"""The training of the sliding-window network: dropout, the epoch that is kept, the optimizer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phonanim.regressors import Progress
from phonanim.regressors._dnn_config import Config
from phonanim.training.recipe import read_recipe

torch = pytest.importorskip("torch")

SMALL = Config(hidden=(8,), dropout=0.0, optimizer="sgd", rate=0.1, batch=16, epochs=1, patience=99)


def made_up_rows(weight: float = 1.0, sign: float = 1.0, size: float = 1.0) -> Any:
    """64 rows of 5 inputs, times `size`; the 3 targets are `sign` times a fixed linear map of them."""
    from phonanim.regressors._torch_dnn import Rows

    rng = np.random.default_rng(0)
    inputs, weights = rng.normal(size=(64, 5)), np.full(64, weight, np.float32)
    targets = sign * inputs @ rng.normal(size=(5, 3))
    return Rows((size * inputs).astype(np.float32), targets.astype(np.float32), weights)


def trained(
    config: Config,
    weight: float = 1.0,
    held_out_sign: float = 1.0,
    size: float = 1.0,
    progress: Progress = lambda done: None,
) -> np.ndarray:
    """All weights and biases after training on the made-up rows from the same start, end to end."""
    from phonanim.regressors._torch import seeded_generator
    from phonanim.regressors._torch_dnn import fit_network

    generator = seeded_generator(np.random.default_rng(1))
    train, held_out = made_up_rows(weight, size=size), made_up_rows(sign=held_out_sign, size=size)
    layers = fit_network(config, train, held_out, generator, progress)
    return np.concatenate([part.ravel() for layer in layers for part in layer])


def test_dropout_takes_part_in_training_and_not_in_the_validation() -> None:
    assert not np.allclose(trained(replace(SMALL, dropout=0.5)), trained(SMALL))
    done: list[float] = []
    still = replace(SMALL, dropout=0.5, rate=0.0, epochs=3, patience=0)
    trained(still, progress=done.append)
    assert len(done) == 2  # weights that stay validate alike, so that the second epoch is no better


def test_the_epoch_with_the_least_validation_error_is_kept() -> None:
    """Where training moves away from the validation targets, the first epoch stays the best."""
    away = trained(replace(SMALL, epochs=6), held_out_sign=-1.0)
    np.testing.assert_array_equal(away, trained(SMALL, held_out_sign=-1.0))
    assert not np.allclose(trained(replace(SMALL, epochs=6)), trained(SMALL))


def test_sgd_moves_in_proportion_to_the_gradient() -> None:
    """Twice the weight of the rows and twice the rate are the same to SGD; AdamW ignores the weight."""
    one_step = replace(SMALL, batch=64)
    start = trained(replace(one_step, rate=0.0))
    step = trained(one_step) - start
    np.testing.assert_allclose(trained(one_step, weight=2.0) - start, 2 * step, rtol=1e-3, atol=1e-5)
    assert np.abs(step).max() > 1e-3
    adam = replace(one_step, optimizer="adamw", decay=0.0)
    np.testing.assert_allclose(trained(adam, weight=2.0), trained(adam), rtol=1e-3, atol=1e-4)


def test_momentum_adds_the_step_before() -> None:
    heavy, plain = replace(SMALL, batch=64, momentum=0.9), replace(SMALL, batch=64)
    np.testing.assert_array_equal(trained(heavy), trained(plain))
    assert not np.allclose(trained(replace(heavy, epochs=2)), trained(replace(plain, epochs=2)))


def test_the_rate_may_fall_over_all_epochs() -> None:
    longer = replace(SMALL, epochs=4)
    constant = trained(longer)
    np.testing.assert_array_equal(trained(replace(longer, schedule="constant")), constant)
    ways = [trained(replace(longer, schedule=kind)) for kind in ("cosine", "cycle")]
    assert not any(np.allclose(one, constant) for one in ways)
    assert not np.allclose(*ways)
    start = trained(replace(SMALL, rate=0.0))
    one_step = replace(SMALL, batch=64)
    np.testing.assert_array_equal(trained(replace(one_step, schedule="cosine")), trained(one_step))
    two = [trained(replace(one_step, epochs=2, schedule=kind)) - start for kind in ("constant", "cosine")]
    assert np.linalg.norm(two[1]) < np.linalg.norm(two[0])  # the second step is half as long
    adam = replace(longer, optimizer="adamw", rate=0.01)
    np.testing.assert_array_equal(trained(replace(adam, schedule="cycle")), trained(adam))
    assert not np.allclose(trained(replace(adam, schedule="constant")), trained(adam))


def test_the_published_network_is_trained_with_sgd_and_dropout(root: Path) -> None:
    settings = read_recipe(root / "benchmarks" / "configs" / "taylor2017.toml").settings
    assert settings is not None
    assert (settings["optimizer"], settings["dropout"], settings["batch"]) == ("sgd", 0.5, 100)


def test_the_size_of_the_inputs_does_not_matter() -> None:
    """Inputs are standardized: a hundred times larger ones have a hundred times smaller weights."""
    config = replace(SMALL, epochs=3)
    plain, large = trained(config), trained(config, size=100.0)
    first = 5 * 8
    np.testing.assert_allclose(100 * large[:first], plain[:first], rtol=0.02, atol=0.01)
    np.testing.assert_allclose(large[first:], plain[first:], rtol=0.02, atol=0.05)
