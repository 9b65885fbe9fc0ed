"""What holds for every regressor: it learns, is stored and read without change, and says what is wrong."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
from speech import made_up_examples, made_up_face, random_track, sound_of, track_of

from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.regressors import InputModality, Model, kinds, load, make_config, regressor_class, save
from phonanim.regressors._contract import check_fitted
from phonanim.speech.inventory import INVENTORY

AUDIO = {"encoder": "mfcc", "hidden": 8, "depth": 1, "epochs": 2, "window": 20, "learning_rate": 0.01}
SMALL: dict[str, dict[str, Any]] = {
    "cnn": AUDIO | {"kernels": [5, 3], "dilations": [1, 1], "channels": [8, 8], "ahead": 2, "ctc": 0.004},
    "dnn": {"hidden": [16], "epochs": 2, "batch": 64},
    "dynamic_visemes": {"clusters": 12},
    "ensemble": {"members": [{"kind": "phone_mean"}, {"kind": "tree", "weight": 3, "leaf": 4}]},
    "facediffuser": {
        **{"encoder": "mfcc", "latent": 8, "hidden": 8, "depth": 1, "epochs": 2, "window": 20},
        **{"timesteps": 20, "steps": 4, "batch": 4, "learning_rate": 0.01},
    },
    "phisanet": AUDIO | {"classifier": 0.01},
    "hybrid": AUDIO,
    "hmm": {"leaf": 5, "rate": 100.0, "alignments": 1},
    "late_fusion": {"members": [{"kind": "phone_mean"}, {"kind": "two_stage", "weight": 3, **AUDIO}]},
    "lstm": {"units": 8, "epochs": 2},
    "phone_mean": {},
    "procedural": {"steps": 20, "batch": 64},
    "tcn": AUDIO | {"channels": [8] * 6},
    "tree": {"leaf": 4},
    "two_stage": AUDIO,
}


def nothing(done: float) -> None:
    assert 0 <= done <= 1


@pytest.fixture(scope="module", params=kinds())
def model(request: pytest.FixtureRequest) -> Model:
    return trained(request.param)


def trained(kind: str, **more: Any) -> Model:
    pytest.importorskip("torch")
    pytest.importorskip("sklearn")
    rng = np.random.default_rng(5)
    data = made_up_examples(rng)
    config = make_config(kind, SMALL[kind] | more, "test")
    regressor = regressor_class(kind).fit(config, data, data, np.random.default_rng(1), nothing)
    return Model(regressor, made_up_face(rng), {"fps": 25.0})


def test_every_kind_is_tested() -> None:
    assert set(SMALL) == set(kinds())


def test_shapes_and_what_drives_it(model: Model) -> None:
    track = random_track(np.random.default_rng(7))
    found = model.predict(track, 60, 33, sound=sound_of(track))
    assert found.shape == (33, 3)
    assert found.dtype == np.float32
    assert model.regressor.input_modality in ("phones", "audio", "both")
    assert model.predict(track, 60, 0, sound=sound_of(track)).shape == (0, 3)
    if model.regressor.input_modality == "phones":
        check_fitted(model.regressor, "this", track, np.arange(20) / 25, 3)


def test_stored_and_read_back(model: Model, tmp_path: Path) -> None:
    save(model, tmp_path / "m")
    again = load(tmp_path / "m")
    track = random_track(np.random.default_rng(8))
    found = [one.predict(track, 30, 40, sound=sound_of(track)) for one in (again, model)]
    assert np.array_equal(*found)
    assert again.face.id == model.face.id == again.card["face"]


def test_the_same_seed_gives_the_same_bytes(model: Model, tmp_path: Path) -> None:
    kind = type(model.regressor).__module__.rpartition(".")[2]
    for name, one in (("a", model), ("b", trained(kind))):
        save(one, tmp_path / name)
    for file in ("weights.safetensors", "model.json", "face.safetensors"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_better_than_the_mean() -> None:
    data = made_up_examples(np.random.default_rng(5))
    for kind in ("dynamic_visemes", "hmm", "phone_mean", "tree"):
        regressor = trained(kind).regressor
        errors, spreads = [], []
        for track, times, target in zip(data.tracks, data.times, data.targets, strict=True):
            errors.append(((regressor.predict(track, times) - target) ** 2).mean())
            spreads.append(((target - np.concatenate(data.targets).mean(axis=0)) ** 2).mean())
        assert np.mean(errors) < 0.8 * np.mean(spreads)


@pytest.mark.parametrize("features", ["indicators", "raw", "classes"])
def test_the_network_on_other_features(features: str, tmp_path: Path) -> None:
    model = trained("dnn", features=features, width=5, activation="tanh", optimizer="sgd", rate=0.01)
    save(model, tmp_path)
    assert load(tmp_path).predict(track_of("sil 0.2 m 0.1 aa 0.3 sil 0.2"), 25, 20).shape == (20, 3)


def test_forests_of_random_splits_average() -> None:
    one = trained("tree", trees=3, split="random", features="gestures", width=1, columns=0.5)
    assert len(one.regressor.tensors()["roots"]) == 3


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save(trained("procedural"), tmp_path)
    return tmp_path


def edit_card(folder: Path, **changes: Any) -> None:
    card = json.loads((folder / "model.json").read_text())
    (folder / "model.json").write_text(json.dumps(card | changes))


def test_a_missing_model(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"model.json: cannot be read as a model .*`phonanim models`"):
        load(tmp_path)


def test_a_card_of_another_format(folder: Path) -> None:
    edit_card(folder, format=99)
    with pytest.raises(ModelError, match="is not a model of format 1; train it again"):
        load(folder)


def test_a_card_of_another_inventory(folder: Path) -> None:
    edit_card(folder, inventory=["a", "b"])
    with pytest.raises(ModelError, match="was made for another phone inventory"):
        load(folder)


def test_a_card_without_its_kind(folder: Path) -> None:
    card = json.loads((folder / "model.json").read_text())
    del card["kind"]
    (folder / "model.json").write_text(json.dumps(card))
    with pytest.raises(ModelError, match="model.json: lacks 'kind'"):
        load(folder)


def test_an_unknown_kind(folder: Path) -> None:
    edit_card(folder, kind="procedurl")
    with pytest.raises(ModelError, match="there is no regressor 'procedurl'; did you mean 'procedural'"):
        load(folder)


def test_an_unknown_setting() -> None:
    with pytest.raises(ModelError, match="here: dnn has no setting 'hiden'; did you mean 'hidden'"):
        make_config("dnn", {"hiden": [3]}, "here")


@pytest.mark.parametrize("cut", [0, 5, 100])
def test_truncated_weights(folder: Path, cut: int) -> None:
    path = folder / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(ModelError, match=r"weights.safetensors: cannot be read"):
        load(folder)


def test_weights_that_are_not_finite(folder: Path) -> None:
    path = folder / "weights.safetensors"
    tensors = load_file(path)
    tensors["target"][0, 0] = np.nan
    save_file(tensors, path)
    with pytest.raises(ModelError, match="the tensor 'target' has numbers that are not finite"):
        load(folder)


def test_weights_of_another_shape(folder: Path) -> None:
    path = folder / "weights.safetensors"
    tensors = load_file(path)
    tensors["target"] = tensors["target"][:3].copy()
    save_file(tensors, path)
    with pytest.raises(ModelError, match=r"does not match its model.json \(target is \(3, 3\)"):
        load(folder)


def test_network_layers_must_follow_each_other(tmp_path: Path) -> None:
    save(trained("dnn"), tmp_path)
    path = tmp_path / "weights.safetensors"
    tensors = load_file(path)
    tensors["weights1"] = tensors["weights1"][:4].copy()
    save_file(tensors, path)
    with pytest.raises(ModelError, match=r"weights1 is \(4, 3\), not \(16, 3\)"):
        load(tmp_path)


def test_means_for_every_phone(tmp_path: Path) -> None:
    save(trained("phone_mean"), tmp_path)
    save_file({"means": np.zeros((4, 3), np.float32)}, tmp_path / "weights.safetensors")
    with pytest.raises(ModelError, match=f"means has 4 rows, not {len(INVENTORY.phones)}"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("name", "message"), [("right", "outside the forest"), ("left", "back to an earlier")]
)
def test_a_tree_that_would_never_end(tmp_path: Path, name: str, message: str) -> None:
    save(trained("tree"), tmp_path)
    path = tmp_path / "weights.safetensors"
    tensors = load_file(path)
    tensors[name][0] = 10**6 if name == "right" else 0
    save_file(tensors, path)
    with pytest.raises(ModelError, match=message):
        load(tmp_path)


def test_a_face_without_its_modes(folder: Path) -> None:
    tensors = load_file(folder / "face.safetensors")
    del tensors["modes"]
    save_file(tensors, folder / "face.safetensors")
    with pytest.raises(ModelError, match=r"face.safetensors: lacks the tensor 'modes'"):
        load(folder)


def test_a_face_whose_shapes_disagree(folder: Path) -> None:
    tensors = load_file(folder / "face.safetensors")
    tensors["std"] = tensors["std"][:1].copy()
    save_file(tensors, folder / "face.safetensors")
    with pytest.raises(ModelError, match=r"face.safetensors: its shapes do not match"):
        load(folder)


@dataclass(frozen=True)
class AudioInput:
    """An audio-driven regressor: its only mode is the loudness of the sound."""

    input_modality: ClassVar[InputModality] = "audio"
    config_class: ClassVar[type] = dict
    config: Any = None

    def predict(self, track: Any, times: Any, sound: Sound | None = None) -> Any:
        assert sound is not None
        assert track.duration == sound.duration
        return np.full((len(times), 1), np.abs(sound.samples).mean(), np.float32)


def test_several_networks_are_the_mean_of_each() -> None:
    """They learn one after the other, as the members of an ensemble do."""
    one = SMALL["dnn"]
    together = trained("dnn", networks=2).regressor
    apart = trained("ensemble", members=[{"kind": "dnn", **one}, {"kind": "dnn", **one}]).regressor
    track, times = track_of("sil 0.2 m 0.1 aa 0.3 sil 0.2"), np.arange(20) / 25
    assert np.allclose(together.predict(track, times), apart.predict(track, times), atol=1e-5)
    ours, theirs = together.tensors(), apart.tensors()
    assert {n: t.tobytes() for n, t in ours.items() if n != "clusters"} == {
        n: t.tobytes() for n, t in theirs.items() if not n.endswith("clusters")
    }
    again = type(together).from_tensors(together.config, ours)
    assert np.array_equal(again.predict(track, times), together.predict(track, times))


def test_an_audio_driven_model_needs_a_recording() -> None:
    model = Model(AudioInput(), made_up_face(np.random.default_rng(0)), {})  # type: ignore[arg-type]
    sound = Sound(np.full(800, 0.5, np.float32), 8000)
    assert np.array_equal(model.predict(None, 50, 5, sound=sound), np.full((5, 1), 0.5))
    with pytest.raises(ModelError, match=r"a model of kind test_regressors needs a recording$"):
        model.predict(track_of("sil 0.2"), 50, 5)


def test_a_model_that_reads_needs_an_alignment() -> None:
    model = trained("phone_mean")
    with pytest.raises(ModelError, match=r"a model of kind phone_mean needs an alignment$"):
        model.predict(None, 50, 5, sound=Sound(np.zeros(800, np.float32), 8000))
