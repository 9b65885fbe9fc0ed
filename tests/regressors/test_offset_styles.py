"""Regressors of statistics: styles differ in their mean, and one style changes nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.errors import ModelError
from phonanim.regressors import Examples, make_config, regressor_class
from phonanim.regressors._styles import split_offsets

pytest.importorskip("torch")
pytest.importorskip("sklearn")
KINDS: dict[str, dict[str, Any]] = {
    "phone_mean": {},
    "hmm": {"leaf": 5, "rate": 100.0, "alignments": 1},
    "dynamic_visemes": {"clusters": 8},
    "procedural": {"steps": 40, "batch": 64},
}
APART = np.array([3.0, 0.0, -1.0], np.float32)  # of the second speaker from the first


@pytest.fixture(scope="module")
def data() -> Examples:
    """The same clips by two speakers, the second of whom holds the face otherwise."""
    one = made_up_examples(np.random.default_rng(5), clips=4)
    both = one + replace(one, targets=tuple(target + APART for target in one.targets))
    return replace(both, styles=(0,) * 4 + (1,) * 4)


def fitted(kind: str, data: Examples, **more: Any) -> Any:
    fit: Any = regressor_class(kind).fit
    config = make_config(kind, KINDS[kind] | more, "test")
    return fit(config, data, data, np.random.default_rng(1), lambda done: None)


@pytest.mark.parametrize("kind", KINDS)
def test_each_style_has_its_mean(kind: str, data: Examples) -> None:
    model = fitted(kind, data, styles=2)
    again = type(model).from_tensors(model.config, model.tensors())
    first, second = (
        again.with_settings(style=style).predict(data.tracks[0], data.times[0]) for style in (0, 1)
    )
    assert second - first == pytest.approx(np.tile(APART, (len(first), 1)), abs=1e-4)
    assert np.array_equal(first, model.predict(data.tracks[0], data.times[0]))
    assert first.dtype == np.float32
    with pytest.raises(ModelError, match=f"{kind}: there is no style 2; take 0 to 1"):
        model.with_settings(style=2)
    with pytest.raises(ValueError, match="offsets is"):
        type(model).from_tensors(make_config(kind, {**KINDS[kind], "styles": 3}, "test"), model.tensors())


@pytest.mark.parametrize("kind", KINDS)
def test_styles_that_are_not_there(kind: str, data: Examples) -> None:
    third = replace(data, styles=tuple(2 * style for style in data.styles))
    with pytest.raises(ModelError, match=f"{kind}: the examples have style 2; set styles to 3 or more"):
        fitted(kind, third, styles=2)


def test_one_style_changes_nothing(data: Examples) -> None:
    assert split_offsets("phone_mean", 1, data) == (data, None)
    model = fitted("phone_mean", data)
    assert set(model.tensors()) == {"means"}


def test_a_style_without_examples_is_the_mean_of_all(data: Examples) -> None:
    shifted, offsets = split_offsets("phone_mean", 3, data)
    assert offsets is not None
    assert offsets[2].tolist() == [0, 0, 0]
    assert offsets[1] - offsets[0] == pytest.approx(APART, abs=1e-5)
    whole, left = (np.concatenate(part.targets) for part in (data, shifted))
    assert left.mean(axis=0) == pytest.approx(whole.mean(axis=0), abs=1e-4)
