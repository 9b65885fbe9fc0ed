"""An interrupted training is continued, to the same numbers as one that was not interrupted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.errors import ModelError
from phonanim.regressors import CHECKPOINT, Examples, make_config, regressor_class

torch = pytest.importorskip("torch")
DNN = {"hidden": (8,), "epochs": 4, "patience": 9}
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "network": ("dnn", DNN),
    "networks": ("dnn", DNN | {"networks": 2}),
    "with momentum": ("dnn", DNN | {"optimizer": "sgd", "rate": 0.05, "momentum": 0.9, "schedule": "cosine"}),
    "recurrent": ("lstm", {"units": 8, "epochs": 4, "patience": 9}),
    "dominance": ("procedural", {"steps": 200, "batch": 32}),
    "teacher": ("ensemble", {"members": [{"kind": "dnn", **DNN}, {"kind": "lstm", "units": 8, "epochs": 2}]}),
}


class CutError(Exception):
    """The training is interrupted."""


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=4)


def fitted(version: str, data: Examples, journal: Path | None, until: float = 2.0) -> Any:
    """A training that is interrupted when it reports that a share of it is done."""
    kind, settings = KINDS[version]

    def progress(done: float) -> None:
        if done >= until:
            raise CutError

    fit: Any = regressor_class(kind).fit
    config = make_config(kind, settings, "test")
    return fit(config, data, data, np.random.default_rng(1), progress, journal=journal)


@pytest.mark.parametrize("version", KINDS)
def test_it_continues_to_the_same_numbers(version: str, data: Examples, tmp_path: Path) -> None:
    whole = fitted(version, data, None).tensors()
    with pytest.raises(CutError):
        fitted(version, data, tmp_path, until=0.5)
    begun = list(tmp_path.rglob(CHECKPOINT))
    assert begun
    # A training that began anew would report its first epoch.
    torch.manual_seed(99)
    first: list[float] = []
    kind, settings = KINDS[version]
    fit: Any = regressor_class(kind).fit
    config = make_config(kind, settings, "test")
    resumed = fit(config, data, data, np.random.default_rng(1), first.append, journal=tmp_path).tensors()
    assert first[0] > 0.25
    assert set(whole) == set(resumed)
    for name, part in whole.items():
        assert np.array_equal(part, resumed[name]), name


@pytest.mark.parametrize("damage", ["cut", "text", "empty", "program", "list", "other", "wrong weights"])
def test_a_damaged_state_is_one_line(damage: str, data: Examples, tmp_path: Path) -> None:
    with pytest.raises(CutError):
        fitted("network", data, tmp_path, until=0.5)
    path = next(tmp_path.rglob(CHECKPOINT))
    parts = torch.load(path, weights_only=True)
    if damage in ("cut", "text", "empty"):
        path.write_bytes({"cut": path.read_bytes()[:-200], "text": b"text", "empty": b""}[damage])
    else:
        wrong = parts | {"network": {"a": torch.zeros(1)}}
        made = {"program": print, "list": [1], "other": {}, "wrong weights": wrong}
        torch.save(made[damage], path)
    with pytest.raises(
        ModelError, match=r"is damaged \(.*\); delete it, and the training begins anew"
    ) as told:
        fitted("network", data, tmp_path)
    assert str(path) in str(told.value)
    assert len(str(told.value).splitlines()) == 1


def test_other_data_begin_anew(data: Examples, tmp_path: Path) -> None:
    with pytest.raises(CutError):
        fitted("network", data, tmp_path, until=0.5)
    other = replace(data, targets=tuple(2 * target for target in data.targets))
    whole, resumed = (fitted("network", other, journal).tensors() for journal in (None, tmp_path))
    assert all(np.array_equal(part, resumed[name]) for name, part in whole.items())


def test_without_clips_to_validate_on_all_epochs_count(data: Examples) -> None:
    nothing = Examples((), (), (), ())
    fit: Any = regressor_class("dnn").fit
    made = []
    for epochs in (1, 4):
        config = make_config("dnn", DNN | {"epochs": epochs, "patience": 0}, "test")
        done: list[float] = []
        made.append(fit(config, data, nothing, np.random.default_rng(1), done.append).tensors())
        assert len(done) == epochs
    assert not np.allclose(made[0]["weights0"], made[1]["weights0"])
