"""Networks that were damaged, and models that name them, are refused in a line."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from phonanim.core.catalog import RECOGNITION_MODEL, SHIPPED
from phonanim.errors import ModelError
from phonanim.recognition.network import network_from
from phonanim.regressors import load

Tensors = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def tensors() -> Tensors:
    return load_file(SHIPPED / RECOGNITION_MODEL / "recognizer.safetensors")


DAMAGE: dict[str, Callable[[Tensors], Any]] = {
    "no layers": lambda t: t.pop("weights0"),
    "no bias": lambda t: t.pop("bias2"),
    "far offsets": lambda t: t.update(offsets4=np.array([-(10**12), -4, 0])),
    "offsets out of order": lambda t: t.update(offsets1=np.array([1, 0, -1])),
    "no offsets": lambda t: t.update(offsets1=np.zeros(0, np.int64)),
    "other widths": lambda t: t.update(weights3=t["weights3"][:, :-1]),
    "not finite": lambda t: t.update(bias0=np.full_like(t["bias0"], np.nan)),
    "fewer phones": lambda t: t.update(prior=t["prior"][:-1]),
    "other pairs": lambda t: t.update(follows=t["follows"][:2]),
}


@pytest.mark.parametrize("what", DAMAGE)
def test_damaged_networks(what: str, tensors: Tensors) -> None:
    changed = dict(tensors)
    DAMAGE[what](changed)
    with pytest.raises(ModelError, match=r"^a\.safetensors: .*; install phonanim again$"):
        network_from(changed, "a.safetensors")


def test_a_sound_network(tensors: Tensors) -> None:
    assert network_from(tensors, "a").ahead == 8


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SHIPPED / RECOGNITION_MODEL, tmp_path / "ears"))


@pytest.mark.parametrize("name", [None, 3, RECOGNITION_MODEL])
def test_a_model_that_is_animated_by_none(name: object, folder: Path) -> None:
    card = json.loads((folder / "model.json").read_text("utf-8"))
    card["config"] = {"animated_by": name}
    (folder / "model.json").write_text(json.dumps(card), encoding="utf-8")
    with pytest.raises(ModelError, match="animated_by is not a phone-driven model"):
        load(folder)


def test_a_model_without_its_network(folder: Path, tensors: Tensors) -> None:
    (folder / "recognizer.safetensors").unlink()
    with pytest.raises(ModelError, match=r"recognizer\.safetensors: cannot be read"):
        load(folder)
    save_file({"other": np.zeros(1)}, folder / "recognizer.safetensors")
    with pytest.raises(ModelError, match=r"recognizer\.safetensors: is damaged"):
        load(folder)
