"""Targets of every kind are stored with a model, and a damaged one is told in a line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
from speech import made_up_examples, made_up_face

from phonanim.errors import CorpusError, ModelError
from phonanim.regressors import Model, load, make_config, regressor_class, save
from phonanim.targets import TARGETS, Source, TargetSettings, target_class
from phonanim.targets.sensors import Sensors
from phonanim.targets.vertices import Vertices

RNG = np.random.default_rng(6)
RESTS = {"a": RNG.normal(size=(9, 3)), "b": RNG.normal(size=(9, 3))}
SOURCES = {
    "controls": (Source("sample", ("x", "y", "z")), RNG.random((40, 3))),
    "sensors": (Source("sample", ("TT", "UL", "LL"), "mm"), RNG.normal(size=(40, 3, 3))),
    "vertices": (
        Source("sample", (), "mm", RESTS, np.array([[0, 1, 2]])),
        RESTS["a"] + RNG.normal(0, 0.1, (40, 9, 3)),
    ),
}
STORED = tuple(SOURCES)


def stored(kind: str, folder: Path, **settings: Any) -> tuple[Any, np.ndarray]:
    source, frames = SOURCES[kind]
    target = target_class(kind).fit(
        TargetSettings(**settings),
        source,
        [(frames, RESTS["a"])] * 2 if kind == "vertices" else [(frames, None)] * 2,
    )
    data = made_up_examples(RNG, clips=3, modes=target.size)
    config = make_config("phone_mean", {}, "test")
    regressor = regressor_class("phone_mean").fit(config, data, data, RNG, lambda done: None)
    save(Model(regressor, target, {"fps": 25.0}), folder)
    return target, frames


def test_every_kind_is_here() -> None:
    assert set(TARGETS.names()) == {"landmarks", *STORED}


@pytest.mark.parametrize("kind", STORED)
@pytest.mark.parametrize("components", [0, 3])
def test_a_stored_target_is_the_same(kind: str, components: int, tmp_path: Path) -> None:
    target, frames = stored(kind, tmp_path, components=components)
    again = load(tmp_path).target
    rest = RESTS["a"] if kind == "vertices" else None
    rows = target.encode(frames, rest)
    assert np.array_equal(again.encode(frames, rest), rows)
    assert np.array_equal(again.decode(rows, rest), target.decode(rows, rest))
    if not components:
        assert target.decode(rows, rest) == pytest.approx(frames, abs=1e-5)
    assert "face" not in json.loads((tmp_path / "model.json").read_text("utf-8"))
    with pytest.raises(ModelError, match=f"the model moves {kind}, not landmarks"):
        _ = load(tmp_path).face


@pytest.mark.parametrize("kind", STORED)
@pytest.mark.parametrize("damage", ["absent", "cut", "other", "unnamed", "untold"])
def test_a_damaged_target(kind: str, damage: str, tmp_path: Path) -> None:
    stored(kind, tmp_path, components=2)
    path, card = tmp_path / "target.safetensors", tmp_path / "model.json"
    facts = json.loads(card.read_text("utf-8"))
    if damage == "absent":
        path.unlink()
    elif damage == "cut":
        path.write_bytes(path.read_bytes()[:20])
    elif damage == "other":
        save_file({name: tensor[:1] for name, tensor in load_file(path).items()}, path)
    elif damage == "unnamed":
        card.write_text(json.dumps(facts | {"target": {"kind": "hands"}}), "utf-8")
    else:
        card.write_text(json.dumps(facts | {"target": "controls"}), "utf-8")
    with pytest.raises(ModelError):
        load(tmp_path)


def test_a_model_of_landmarks_names_no_target(tmp_path: Path) -> None:
    data = made_up_examples(RNG, clips=3)
    regressor = regressor_class("phone_mean").fit(
        make_config("phone_mean", {}, "test"), data, data, RNG, lambda done: None
    )
    face = made_up_face(RNG)
    save(Model(regressor, face, {"fps": 25.0}), tmp_path)
    assert "target" not in json.loads((tmp_path / "model.json").read_text("utf-8"))
    assert not (tmp_path / "target.safetensors").exists()
    assert load(tmp_path).face.id == face.id


def test_speakers_sensors_are_taken_from_their_own_mean() -> None:
    source, frames = SOURCES["sensors"]
    far = frames + 100
    means = [part.mean(axis=0) for part in (frames, far)]
    target = Sensors.fit(TargetSettings(scale="none"), source, zip((frames, far), means, strict=True))
    assert target.encode(frames, means[0]) == pytest.approx(target.encode(far, means[1]), abs=1e-4)
    assert target.decode(target.encode(far, means[1]), means[1]) == pytest.approx(far, abs=1e-4)


def test_the_first_components_move_most() -> None:
    source, frames = SOURCES["vertices"]
    whole = [(frames, RESTS["a"])]
    errors = []
    for count in (1, 4, 12):
        target = Vertices.fit(TargetSettings(components=count), source, whole)
        assert target.modes is not None
        assert target.modes @ target.modes.T == pytest.approx(np.eye(count), abs=1e-5)
        rows = target.encode(frames, RESTS["a"])
        assert (np.diff(rows.std(axis=0)) <= 1e-5).all()
        errors.append(np.abs(target.decode(rows, RESTS["a"]) - frames).mean())
    assert errors[0] > errors[1] > errors[2]


def test_other_meshes_are_refused() -> None:
    source, frames = SOURCES["vertices"]
    target = Vertices.fit(TargetSettings(), source, [])
    with pytest.raises(CorpusError, match="and the face at rest"):
        target.encode(frames[:, :5], RESTS["a"])
    with pytest.raises(CorpusError, match="has no faces at rest"):
        Vertices.fit(TargetSettings(), Source("sample"), [])
    with pytest.raises(CorpusError, match="its sensors have no names"):
        Sensors.fit(TargetSettings(), Source("sample"), [])
    with pytest.raises(ModelError, match="the model has no face of 'c'"):
        target.rest_of("c")
