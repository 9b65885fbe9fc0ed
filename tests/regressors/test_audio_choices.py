"""PhISANet's choices in training: labels with stress, windows at a stride, a start by the L1 error."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.errors import ModelError
from phonanim.regressors import Examples, make_config, regressor_class

torch = pytest.importorskip("torch")
SMALL: dict[str, Any] = {"encoder": "mfcc", "hidden": 8, "depth": 1, "window": 20, "epochs": 2}


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=4)


def config_of(**more: Any) -> Any:
    return make_config("phisanet", SMALL | more, "test")


def trained(data: Examples, **more: Any) -> Any:
    fit: Any = regressor_class("phisanet").fit
    return fit(config_of(**more), data, data, np.random.default_rng(1), lambda done: None)


def stressed(data: Examples) -> Examples:
    """The same clips, with two allophones of every phone by turns."""
    tracks = tuple(
        replace(t, labels=tuple(f"{code}_{n % 2}" for n, code in enumerate(t.codes))) for t in data.tracks
    )
    return replace(data, tracks=tracks)


@pytest.mark.parametrize(
    "choice",
    [
        {"decoder": "rnn"},
        {"labels": "allophones", "classifier": 0.1, "ctc": 0.008},
        {"stride": 4},
        {"l1_until": 0.5},
    ],
    ids=str,
)
def test_every_choice_trains_and_changes_the_result(choice: dict[str, Any], data: Examples) -> None:
    clips, times = stressed(data), np.arange(40) / 30
    changed, plain = (trained(clips, **more).predict(None, times, data.sounds[0]) for more in (choice, {}))
    assert changed.shape == plain.shape
    assert np.isfinite(changed).all()
    assert not np.array_equal(changed, plain)


def test_allophones_are_the_labels_of_the_alignments(data: Examples) -> None:
    from phonanim.regressors._torch_audio import with_allophones
    from phonanim.regressors._torch_decoders import Network
    from phonanim.regressors._training_steps import gather_steps
    from phonanim.regressors.phisanet import PhISANet

    config, clips = config_of(labels="allophones"), stressed(data)
    gathered = gather_steps(PhISANet, config, clips)
    steps, count = with_allophones(gathered, config, clips)
    names = sorted({label for track in clips.tracks for label in track.labels})
    assert count == len(names) > len({code for track in data.tracks for code in track.codes})
    assert steps.codes.max() < count
    # Each label belongs to the phone of its step, and both allophones of a phone are there.
    assert [names[code].split("_")[0] for code in steps.codes] == [str(code) for code in gathered.codes]
    network = Network(config, 1, 4, 3, count)
    assert network.classifier.out_features == count
    assert network.ctc.out_features == count + 1


def test_windows_at_a_stride_are_all_of_them_once(data: Examples) -> None:
    from phonanim.regressors._torch_audio import batches
    from phonanim.regressors._training_steps import gather_steps
    from phonanim.regressors.phisanet import PhISANet

    steps = gather_steps(PhISANet, config_of(), data)
    numbered = replace(steps, codes=np.arange(len(steps.codes)))
    config = config_of(stride=3, batch=7)
    first = [
        row[0] for _, _, codes, *_ in batches(config, numbered, np.random.default_rng(0)) for row in codes
    ]
    wanted = [
        start + place
        for start, length in zip(steps.starts, steps.lengths, strict=True)
        for place in range(0, max(length - config.window, 0) + 1, 3)
    ]
    assert sorted(first) == wanted
    assert first != wanted  # in random order


def test_the_l1_error_ends_where_it_is_small() -> None:
    from phonanim.regressors import _torch_audio as training

    def robust(until: float, *losses: float) -> bool:
        state = training.State(None, None, [(loss, 1.0) for loss in losses], [], "", None)  # type: ignore[arg-type]
        return training.starts_robust(config_of(l1_until=until), state)

    assert robust(0.5)
    assert robust(0.5, 0.9, 0.6)
    assert not robust(0.5, 0.9, 0.4)
    assert not robust(0.5, 0.9, 0.4, 0.7)  # of squared errors by then
    assert not robust(0.0)


def test_the_l1_error_by_its_equation() -> None:
    from phonanim.regressors import _torch_audio as training
    from phonanim.regressors._torch_decoders import Network

    rng = np.random.default_rng(0)
    ones, codes = np.ones((1, 4), np.float32), np.ones((2, 9), np.int64)
    scaling = training.Scaling(0 * ones, ones, np.zeros(3, np.float32), np.ones(3, np.float32))
    config = config_of(window=9, velocity=0.5, acceleration=0.0, ctc=0.0)
    network = Network(config, 1, 4, 3).eval()
    values, targets = (
        torch.from_numpy(rng.normal(size=shape).astype(np.float32)) for shape in ((2, 9, 1, 4), (2, 9, 3))
    )
    total = training.loss(
        config, network, scaling, values, targets, codes, codes, codes[:, 0], torch.ones(2), robust=True
    )
    with torch.no_grad():
        apart = (network(values)[1] - targets).numpy()
    wanted = np.abs(apart).mean() + 0.5 * np.abs(np.diff(apart, axis=1)).mean()
    np.testing.assert_allclose(float(total.detach()), wanted, rtol=1e-5)


def test_styles_are_told_apart(data: Examples) -> None:
    """Two speakers who move twice as far and half as far: a prediction has the style that is asked for."""
    half = len(data) // 2
    styles = (0,) * half + (1,) * (len(data) - half)
    targets = tuple(
        target * (2 if style else 0.5) for target, style in zip(data.targets, styles, strict=True)
    )
    mixed = replace(data, targets=targets, styles=styles)
    fit: Any = regressor_class("phisanet").fit
    config = config_of(styles=2, epochs=150, patience=150, learning_rate=0.05, ctc=0.0, dropout=0.0)
    model = fit(config, mixed, mixed, np.random.default_rng(1), lambda done: None)
    assert model.weights["style"].shape[0] == 2
    again = type(model).from_tensors(model.config, model.tensors())
    first, second = (
        again.with_settings(style=style).predict(None, data.times[0], data.sounds[0]) for style in (0, 1)
    )
    assert second.std(axis=0).mean() > 1.3 * first.std(axis=0).mean()
    assert np.array_equal(first, model.predict(None, data.times[0], data.sounds[0]))
    alone = fit(config_of(epochs=1), data, data, np.random.default_rng(1), lambda done: None)
    assert "style" not in alone.weights
    third = replace(mixed, styles=tuple(2 * style for style in styles))
    with pytest.raises(ModelError, match="the examples have style 2; set styles to 3 or more"):
        fit(config_of(epochs=1, styles=2), third, third, np.random.default_rng(1), lambda done: None)
    with pytest.raises(ModelError, match="style is 2; the model has 0 to 1"):
        again.with_settings(style=2)
    with pytest.raises(ModelError, match="does not sample: leave out --seed"):
        again.with_settings(seed=1)
    with pytest.raises(ValueError, match="there is no style 5 of 2"):
        type(model).from_tensors(replace(model.config, style=5), model.tensors())
