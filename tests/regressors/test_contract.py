"""What a regressor of one's own is told when it does not keep the contract."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples, random_track

from phonanim.errors import ModelError
from phonanim.regressors import REGRESSORS, make_config, regressor_class
from phonanim.regressors._contract import check_class, check_fitted
from phonanim.regressors.phone_mean import Config, PhoneMean

TRACK = random_track(np.random.default_rng(3))
TIMES = np.arange(20) / 25


@dataclass
class Loose:
    gain: float = 1.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"predict": None, "tensors": None}, "has no predict and no tensors; docs/extending.md shows"),
        ({"input_modality": "text"}, "input_modality is 'text'; set phones, audio, both"),
        ({"config_class": Loose}, "config_class is not a frozen dataclass"),
        ({"config_class": dict}, "config_class is not a frozen dataclass"),
        (
            {"fit": classmethod(lambda cls, config, train: None)},
            r"fit is not a class method of \(config, train, validation, rng, progress\): too many positional",
        ),
        ({"from_tensors": lambda cls, config, tensors: None}, "from_tensors is not a class method of"),
        ({"predict": lambda self, track, times, sound: None}, "predict is not a method of .*'sound'"),
    ],
)
def test_a_class_that_lacks_something(change: dict[str, Any], message: str) -> None:
    part = SimpleNamespace(__name__="mine", REGRESSOR=type("Mine", (PhoneMean,), change))
    with pytest.raises(ModelError, match=message):
        check_class(part, "mine")


def test_a_file_without_the_class(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(REGRESSORS), "find", lambda self, name: SimpleNamespace(__name__="mine"))
    with pytest.raises(ModelError, match=r"regressor 'mine' \(mine\): has no class REGRESSOR; end it with"):
        regressor_class("mine")


def test_every_kind_keeps_it() -> None:
    for kind in REGRESSORS.built_in():
        check_class(REGRESSORS.find(kind), kind)


def only_inside(self: PhoneMean, track: Any, times: np.ndarray) -> np.ndarray:
    """Rows for the instants within the track alone."""
    return np.zeros((int(((times >= 0) & (times < track.duration)).sum()), 3), np.float32)


def fails_somewhere(self: PhoneMean, track: Any, times: np.ndarray) -> np.ndarray:
    """Fails beyond the ends of the track."""
    if len(times) and times[-1] > track.duration:
        raise ValueError("far")
    return np.zeros((len(times), 3), np.float32)


def trained() -> PhoneMean:
    data = made_up_examples(np.random.default_rng(5))
    return PhoneMean.fit(Config(), data, data, np.random.default_rng(1), lambda done: None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"predict": lambda *a: np.zeros((20, 2), np.float32)}, r"gives float32 of shape \(20, 2\) at 0"),
        ({"predict": lambda *a: np.zeros((20, 3))}, "gives float64 of shape"),
        ({"predict": lambda *a: None}, "gives NoneType at 0 instants; give float32 of shape"),
        ({"predict": lambda *a: np.full((len(a[2]), 3), np.nan, np.float32)}, "not finite; correct it"),
        ({"predict": lambda *a: np.zeros((20, 3), np.float32)}, r"at 0 instants; give .* shape \(0, 3\)"),
        ({"predict": only_inside}, r"of shape \(20, 3\) at 22 instants; give float32 of shape \(22, 3\)"),
        ({"predict": lambda *a: a[2][0]}, "predict fails at no instant at all: IndexError.*; give shape"),
        (
            {"predict": fails_somewhere},
            r"predict fails at 22 instants, some .* both ends: ValueError\('far'\)",
        ),
        ({"tensors": lambda self: [1]}, r"tensors\(\) is not a dict of NumPy arrays"),
        ({"tensors": lambda self: {"means": np.array([None])}}, r"is not a dict of NumPy arrays of numbers"),
        (
            {"tensors": lambda self: {}},
            r"from_tensors does not read what tensors\(\) gave: KeyError\('means'\)",
        ),
        ({"tensors": lambda self: {"means": self.means + 1}}, "predicts otherwise after tensors"),
    ],
)
def test_what_fit_returns_is_tried_out(change: dict[str, Any], message: str) -> None:
    good = trained()
    check_fitted(good, "mine", TRACK, TIMES, 3)
    bad = type("Mine", (PhoneMean,), change)(good.config, good.means)
    with pytest.raises(ModelError, match=message):
        check_fitted(bad, "mine", TRACK, TIMES, 3)


def test_fit_must_return_a_regressor() -> None:
    with pytest.raises(ModelError, match="fit returns dict, no regressor with its config"):
        check_fitted({}, "mine", TRACK, TIMES, 3)
    assert replace(trained(), config=Config(0.2)).config.smoothing == 0.2


def test_a_setting_without_a_default_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass(frozen=True)
    class Needy:
        size: int

    monkeypatch.setattr(PhoneMean, "config_class", Needy)
    with pytest.raises(ModelError, match=r"mine.toml: lacks the setting 'size'; give it under \[settings\]"):
        make_config("phone_mean", {}, "mine.toml")
    assert make_config("phone_mean", {"size": 3}, "mine.toml") == Needy(3)
