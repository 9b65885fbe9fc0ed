"""Phone-driven regressors tell speakers apart: the same phones move as the style that is asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.errors import ModelError
from phonanim.regressors import Examples, make_config, regressor_class
from phonanim.regressors._styles import add_style, layer_of_style

pytest.importorskip("torch")
pytest.importorskip("sklearn")
KINDS: dict[str, dict[str, Any]] = {
    "dnn": {"hidden": (32,), "epochs": 60, "patience": 60, "dropout": 0.0, "batch": 32, "networks": 2},
    "lstm": {"units": 32, "epochs": 60, "patience": 60, "dropout": 0.0},
    "tree": {"leaf": 1, "width": 1, "features": "raw"},
}


@pytest.fixture(scope="module")
def data() -> Examples:
    """The same clips by a speaker who moves half as far, and by one who moves twice as far."""
    one = made_up_examples(np.random.default_rng(5), clips=6)
    quiet, lively = (
        tuple(target * gain for target in one.targets) for gain in (np.float32(0.5), np.float32(2))
    )
    both = replace(one, targets=quiet) + replace(one, targets=lively)
    return replace(both, styles=(0,) * 6 + (1,) * 6)


def fitted(kind: str, data: Examples, **more: Any) -> Any:
    fit: Any = regressor_class(kind).fit
    config = make_config(kind, KINDS[kind] | more, "test")
    return fit(config, data, data, np.random.default_rng(1), lambda done: None)


@pytest.mark.parametrize("kind", KINDS)
def test_styles_are_told_apart(kind: str, data: Examples) -> None:
    model = fitted(kind, data, styles=2)
    again = type(model).from_tensors(model.config, model.tensors())
    quiet, lively = (
        again.with_settings(style=style).predict(data.tracks[0], data.times[0]) for style in (0, 1)
    )
    assert lively.std(axis=0).mean() > 2.5 * quiet.std(axis=0).mean()
    assert np.array_equal(quiet, model.predict(data.tracks[0], data.times[0]))
    alone = fitted(kind, data).predict(data.tracks[0], data.times[0])
    assert quiet.std() < alone.std() < lively.std()


@pytest.mark.parametrize("kind", KINDS)
def test_styles_that_are_not_there(kind: str, data: Examples) -> None:
    short = {"epochs": 1} if kind != "tree" else {}
    with pytest.raises(ModelError, match=f"{kind}: there is no style 2; take 0 to 1"):
        make_config(kind, {"styles": 2, "style": 2}, "test")
    third = replace(data, styles=tuple(2 * style for style in data.styles))
    with pytest.raises(ModelError, match="the examples have style 2; set styles to 3 or more"):
        fitted(kind, third, styles=2, **short)
    model = fitted(kind, data, styles=2, **short)
    with pytest.raises(ModelError, match="there is no style 5"):
        model.with_settings(style=5)
    with pytest.raises(ModelError, match="does not sample: leave out --seed"):
        model.with_settings(seed=1)


def test_a_style_is_a_bias_of_the_first_layer() -> None:
    rng = np.random.default_rng(0)
    rows, weights, bias = (rng.normal(size=size).astype(np.float32) for size in ((4, 5), (8, 2), (2,)))
    config = make_config("dnn", {"styles": 3, "style": 1}, "test")
    columns = add_style(rows, 1, 3)
    assert columns[:, 5:].tolist() == [[0, 1, 0]] * 4
    smaller, moved = layer_of_style(weights, bias, config)
    np.testing.assert_allclose(rows @ smaller + moved, columns @ weights + bias, atol=1e-5)
    assert add_style(rows, 0, 1) is rows
