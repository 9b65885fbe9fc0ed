"""The steps that models are trained on: the same in memory and in files, no larger than the targets."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.regressors import Examples, make_config, regressor_class
from phonanim.regressors import _diffusion as diffusion
from phonanim.regressors import _training_steps as training_steps

pytest.importorskip("torch")
SMALL = {"encoder": "mfcc", "hidden": 8, "depth": 1, "window": 20, "epochs": 2, "normalize": "minmax"}
MESH = 15_000  # numbers of a frame


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=4)


@pytest.fixture
def on_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(training_steps, "LARGE", 0)
    monkeypatch.setattr(training_steps, "BLOCK", 1000)


def gathered(data: Examples, **more: Any) -> training_steps.Steps:
    kind = regressor_class("phisanet")
    return training_steps.gather_steps(kind, make_config("phisanet", SMALL | more, "test"), data)  # type: ignore[arg-type]


def trained(data: Examples) -> dict[str, Any]:
    config = make_config("phisanet", SMALL, "test")
    model = regressor_class("phisanet").fit(config, data, data, np.random.default_rng(1), lambda done: None)
    return model.tensors()


def test_steps_on_disk_are_those_in_memory(data: Examples, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = gathered(data)
    monkeypatch.setattr(training_steps, "LARGE", 0)
    stored = gathered(data)
    assert isinstance(stored.targets, np.memmap)
    assert not isinstance(kept.targets, np.memmap)
    for one, other in zip(vars(kept).values(), vars(stored).values(), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("frames", [1, 2, 40])
def test_all_columns_at_once_are_each_column(frames: int) -> None:
    rng = np.random.default_rng(frames)
    times, values = 0.013 + np.arange(frames) / 29.97, rng.standard_normal((frames, 7)).astype(np.float32)
    at = np.sort(np.concatenate([rng.uniform(-0.5, 2, 200), times]))
    each = np.stack([np.interp(at, times, column) for column in values.T], axis=1)
    assert np.array_equal(training_steps.interpolate_columns(at, times, values), each)


def test_means_and_ranges_in_blocks_are_those_of_the_whole(
    data: Examples, monkeypatch: pytest.MonkeyPatch
) -> None:
    targets = gathered(data).targets
    monkeypatch.setattr(training_steps, "BLOCK", 1000)
    assert np.array_equal(training_steps.column_means(targets), targets.mean(axis=0))
    low, high = training_steps.column_range(targets)
    assert np.array_equal(low, targets.min(axis=0))
    assert np.array_equal(high - low, np.ptp(targets, axis=0))


@pytest.mark.usefixtures("on_disk")
def test_deviations_without_a_copy(data: Examples) -> None:
    targets = gathered(data).targets
    assert len(list(training_steps.blocks_of(targets))) > 2
    assert training_steps.overall_deviation(targets) == pytest.approx(np.array(targets).std(), rel=1e-4)
    assert training_steps.column_deviations(targets) == pytest.approx(np.array(targets).std(0), rel=1e-4)


def test_training_from_disk_has_the_same_result(data: Examples, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = trained(data)
    monkeypatch.setattr(training_steps, "LARGE", 0)
    stored = trained(data)
    assert all(np.array_equal(kept[name], stored[name]) for name in kept)


def test_gathering_takes_little_more_than_the_targets(data: Examples) -> None:
    wide = tuple(np.zeros((len(times), MESH), np.float32) for times in data.times)
    mesh = replace(data, targets=wide)
    gathered(data)  # the encoder is loaded
    tracemalloc.start()
    steps = gathered(mesh)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.5 * (steps.targets.nbytes + steps.values.nbytes)


def test_noise_costs_by_its_length() -> None:
    tracemalloc.start()
    noise = diffusion.step_noise(1, 0, 0, 20, MESH)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * noise.nbytes
    whole = np.random.default_rng([1, 0, 0]).standard_normal((1500, 3), np.float32)
    assert np.array_equal(diffusion.step_noise(1, 0, 0, 20, 3), whole[:20])
    assert np.array_equal(diffusion.step_noise(1, 0, 1490, 20, 3)[:10], whole[1490:])
