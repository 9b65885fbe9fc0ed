"""Settings that a kind cannot have are told in one line, before anything is trained."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from phonanim.errors import ModelError
from phonanim.regressors import kinds, make_config, regressor_class
from phonanim.regressors._ranges import check_range


@pytest.mark.parametrize("kind", kinds())
def test_the_defaults_are_within(kind: str) -> None:
    config = regressor_class(kind).config_class
    for name, field in config.__dataclass_fields__.items():
        check_range(name, field.default, "test", own=True)


@pytest.mark.parametrize(
    ("kind", "key", "value", "told"),
    [
        ("phisanet", "hidden", 0, "take 1 or more"),
        ("phisanet", "stride", -1, "take 0 or more"),
        ("phisanet", "batch", 0, "take 1 or more"),
        ("phisanet", "rate", 0.0, "take a number above 0"),
        ("phisanet", "dropout", 2.0, "take 0 or more, at most 0.99"),
        ("cnn", "kernels", [3, 0], "take 1 or more"),
        ("facediffuser", "delta", 0.0, "take a number above 0"),
        ("facediffuser", "masked", -0.5, "take 0 or more, at most 1"),
        ("facediffuser", "autoencoder", -1, "take 0 or more"),
        ("facediffuser", "epochs", -1, "take 0 or more"),
        ("dnn", "hidden", [8, -8], "take 1 or more"),
        ("dnn", "features", "phones", "take 'indicators', 'raw', 'all', 'gestures', 'classes'"),
        ("dnn", "width", 0, "take 1 or more"),
        ("tree", "columns", 0.0, "take a number above 0, at most 1"),
        ("tree", "trees", 0, "take 1 or more"),
        ("lstm", "units", 100000, "the most is 4096"),
        ("lstm", "rate", float("nan"), "the most is 1e\\+09"),
        ("phone_mean", "smoothing", 0.0, "take a number above 0"),
        ("procedural", "steps", 0, "take 1 or more"),
        ("dynamic_visemes", "clusters", 0, "take 1 or more"),
        ("dynamic_visemes", "doubt", 0.0, "take a number above 0"),
        ("hmm", "states", 0, "take 1 or more"),
    ],
)
def test_what_cannot_be(kind: str, key: str, value: object, told: str) -> None:
    with pytest.raises(ModelError, match=f"test: {key} is .*; {told}"):
        make_config(kind, {key: value}, "test")


def test_models_of_states_need_frames() -> None:
    with pytest.raises(ModelError, match="hmm: rate is 2; take 25 or more, for states in short phones"):
        make_config("hmm", {"rate": 2.0}, "test")


def test_settings_of_others_have_their_own_meaning() -> None:
    @dataclass(frozen=True)
    class Config:
        rate: float = -1.0

    check_range("rate", Config().rate, "test", own=False)
    with pytest.raises(ModelError, match="the most is 1e"):
        check_range("rate", 1e12, "test", own=False)
