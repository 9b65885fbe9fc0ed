"""Data sets as the released code of FaceDiffuser and CodeTalker prepares them: names, splits, scaling."""

from __future__ import annotations

import pickle
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from dataset_samples import array, wav

from phonanim.animation.own_motion import rig_of_names
from phonanim.datasets import Recording, load_dataset
from phonanim.datasets._pickles import read_pickle, read_scaler
from phonanim.errors import CorpusError


def read(name: str, folder: Path) -> dict[str, Recording]:
    return {one.name: one for one in load_dataset(name).recordings(folder)}


def store(folder: Path, name: str, values: np.ndarray) -> None:
    array(folder / "vertices_npy" / f"{name}.npy", values.reshape(len(values), -1))
    wav(folder / "wav" / f"{name}.wav")


def test_multiface_is_numbered_and_brought_back_to_millimetres(tmp_path: Path) -> None:
    for name in ("1_50", "2_01", "02_41", "13_46", "14_01", "3_51"):
        store(tmp_path, name, np.array([[[-1, -1, -1], [1, 1, 1]]], np.float32))
    (tmp_path / "templates.pkl").write_bytes(pickle.dumps({"2": np.zeros((2, 3))}, protocol=2))
    found = read("multiface", tmp_path)
    assert {name: one.split for name, one in found.items()} == {
        "1_50": "test_b", "2_01": "train", "02_41": "validation", "13_46": "test", "14_01": "", "3_51": "",
    }  # fmt: skip
    frames = found["2_01"].frames()
    assert frames.values[0] == pytest.approx(
        np.array([[-117.798, -213.735, -177.091], [125.922, 185.796, 75.365]]), abs=1e-2
    )
    assert frames.unit == "mm"
    rest = load_dataset("multiface").templates(tmp_path)["2"]  # type: ignore[attr-defined]
    assert rest[0] == pytest.approx([4.062, -13.969, -50.863], abs=1e-2)


def test_beat_has_emotions_by_number(tmp_path: Path) -> None:
    for speaker in ("2", "1"):
        for number in range(10):
            store(tmp_path, f"{speaker}_3_{number:02d}", np.zeros((300, 51), np.float32))
    found = read("beat", tmp_path)
    assert {(one.speaker, one.emotion) for one in found.values()} == {("1", "sadness"), ("2", "sadness")}
    splits = [one.split for one in found.values() if one.speaker == "2"]
    assert [splits.count(name) for name in ("train", "validation", "test")] == [8, 1, 1]
    assert {one.split for one in found.values() if one.speaker == "1"} == {""}
    frames = found["2_3_00"].frames()
    assert frames.values.shape == (300, 51)
    assert (frames.names[0], frames.names[24], frames.names[50]) == (
        "browDownLeft", "jawOpen", "noseSneerRight",
    )  # fmt: skip
    assert rig_of_names(frames.names) == "arkit"


class MinMaxScaler:
    """Stands for scikit-learn's, whose attributes a pickle has."""


class StandardScaler:
    """The same."""


@pytest.fixture
def scikit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scalers that pickle under the names of scikit-learn."""
    for kind in (MinMaxScaler, StandardScaler):
        monkeypatch.setattr(kind, "__module__", "sklearn.preprocessing._data")
    module = types.ModuleType("sklearn.preprocessing._data")
    module.MinMaxScaler, module.StandardScaler = MinMaxScaler, StandardScaler  # type: ignore[attr-defined]
    for name in ("sklearn", "sklearn.preprocessing"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setitem(sys.modules, "sklearn.preprocessing._data", module)


@pytest.mark.usefixtures("scikit")
@pytest.mark.parametrize("kind", [MinMaxScaler, StandardScaler])
def test_uudamm_is_scaled_back(kind: type, tmp_path: Path) -> None:
    own = np.random.default_rng(3).normal(5, 30, (300, 192))
    scaler, shift = kind(), np.linspace(-2, 2, 192)
    scale = np.linspace(0.5, 3, 192)
    scaler.scale_ = scale
    if kind is MinMaxScaler:
        scaler.min_, scaled = shift, own * scale + shift
    else:
        scaler.mean_, scaled = shift, (own - shift) / scale
    (tmp_path / "scaler_192.pkl").write_bytes(pickle.dumps(scaler))
    store(tmp_path, "S1_1", scaled.astype(np.float32))
    assert read("uudamm", tmp_path)["S1_1"].frames().values == pytest.approx(own, abs=1e-3)
    with pytest.raises(CorpusError, match="it tries to run"):
        read_pickle(tmp_path / "scaler_192.pkl")  # only a scaler's own reader knows it


def test_what_is_no_scaler(tmp_path: Path) -> None:
    path = tmp_path / "scaler_192.pkl"
    for content in (pickle.dumps({"scale_": 1}), pickle.dumps(Path("x")), b"", b"\x80\x04N."):
        path.write_bytes(content)
        with pytest.raises(CorpusError, match="cannot be read as a scaler"):
            read_scaler(path)


def test_biwi_alone_is_said_with_emotion_and_scaled_by_its_template(tmp_path: Path) -> None:
    rest = np.array([[0, 0, 0], [100, 200, 50], [20, 40, 10]], np.float32)
    moved = rest + np.array([0, 3, 0], np.float32)
    scaled = (moved - rest.mean(axis=0)) / np.ptp(rest, axis=0)
    for name in ("F2_01", "F2_33", "F1_40"):
        store(tmp_path, name, scaled[None].astype(np.float32))
    found = read("biwi", tmp_path)
    assert {name: one.split for name, one in found.items()} == {
        "F1_40": "test_b", "F2_01": "train", "F2_33": "validation",
    }  # fmt: skip
    assert {one.emotion for one in found.values()} == {"emotional"}
    assert found["F2_01"].frames().values[0] == pytest.approx(scaled, abs=1e-6)
    (tmp_path / "templates_orig.pkl").write_bytes(pickle.dumps({"F2": rest, "F1": rest}, protocol=2))
    assert read("biwi", tmp_path)["F2_01"].frames().values[0] == pytest.approx(moved, abs=1e-3)
    assert load_dataset("biwi").templates(tmp_path)["F2"] == pytest.approx(rest)  # type: ignore[attr-defined]


def test_biwi_with_both_says_which(tmp_path: Path) -> None:
    for name in ("F2_01", "F2_41"):
        store(tmp_path, name, np.zeros((1, 3, 3), np.float32))
    found = read("biwi", tmp_path)
    assert [(one.split, one.emotion) for one in found.values()] == [("", "neutral"), ("train", "emotional")]


def test_biwi_takes_its_scans_as_templates(tmp_path: Path) -> None:
    (tmp_path / "rigid_scans").mkdir()
    (tmp_path / "rigid_scans" / "F1.obj").write_text("v 1 2 3\nv 4 5 6\nvn 0 0 1\nf 1 2 1\n", "utf-8")
    templates = load_dataset("biwi").templates(tmp_path)  # type: ignore[attr-defined]
    assert templates["F1"].tolist() == [[1, 2, 3], [4, 5, 6]]
