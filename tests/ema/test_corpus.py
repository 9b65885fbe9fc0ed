"""Articulography becomes a corpus of sensors, and a model of it moves the tongue of any rig."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from phonanim import animate
from phonanim.__main__ import run
from phonanim.articulation import CHANNELS
from phonanim.corpus.motion import load_motion_corpus
from phonanim.pipeline import load_model

NAMES = ("TT", "TR", "UL", "LL", "JAW")
SOUNDS = ("sil", "AA", "M", "IY", "L", "AA", "sil")
GRID = """File type = "ooTextFile"\nObject class = "TextGrid"\n
xmin = 0\nxmax = {end}\ntiers? <exists>\nsize = 1\nitem []:
    item [1]:\n        class = "IntervalTier"\n        name = "phones"
        xmin = 0\n        xmax = {end}\n        intervals: size = {size}\n{rows}"""
ROW = '        intervals [{n}]:\n  xmin = {a}\n  xmax = {b}\n  text = "{label}"\n'
RECIPE = 'kind = "phone_mean"\ncorpus = "corpus"\nvalidation = 0.0\n'


def write_recording(folder: Path, name: str, far: float) -> None:
    """A mouth that opens on AA and IY, with a tongue that rises on IY, and sensors glued `far` mm away."""
    opened = {"AA": 10.0, "IY": 4.0, "L": 4.0}
    raised = {"IY": 6.0, "L": 3.0, "AA": -4.0}
    labels = np.repeat(SOUNDS, 20)
    places = np.zeros((len(labels), len(NAMES), 3)) + far
    places[:, [3, 4], 2] -= np.array([opened.get(label, 0.0) for label in labels])[:, None]
    places[:, 0, 2] += np.array([raised.get(label, 0.0) for label in labels])
    places[5, 0] = np.nan
    np.savez(folder / f"{name}.npz", sensors=NAMES, xyz=places, hz=100)
    rows = [ROW.format(n=n + 1, a=0.2 * n, b=0.2 * (n + 1), label=one) for n, one in enumerate(SOUNDS)]
    grid = GRID.format(end=0.2 * len(SOUNDS), size=len(rows), rows="".join(rows))
    (folder / f"{name}.TextGrid").write_text(grid, "utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("sensors")
    for name, far in (("one", 0.0), ("two", 30.0), ("three", -12.0)):
        write_recording(made, name, far)
    assert run(["corpus", "build", str(made), "-o", str(made / "corpus"), "--rate", "50"]) == 0
    (made / "recipe.toml").write_text(RECIPE, "utf-8")
    return made


@pytest.fixture(scope="module")
def model(folder: Path) -> Path:
    assert run(["train", str(folder / "recipe.toml"), "-o", str(folder / "model")]) == 0
    return folder / "model"


def test_a_corpus_has_the_sensors_up_to_the_end_of_speech(folder: Path) -> None:
    corpus = load_motion_corpus(folder / "corpus")
    assert (corpus.kind, corpus.fps, corpus.source.unit) == ("sensors", 50.0, "mm")
    assert corpus.source.names == ("TT", "TD", "UL", "LL", "LI")
    assert {clip.subject for clip in corpus.clips} == {"one", "two", "three"}
    assert all(clip.aligned and clip.frames == 70 for clip in corpus.clips)
    assert np.isfinite(corpus.frames(0)).all()
    rests = [corpus.rest(number) for number in range(3)]
    assert rests[0] == pytest.approx(np.mean(corpus.frames(0), axis=0), abs=1e-4)  # each speaker's own mean
    assert np.ptp([rest[0, 0] for rest in rests]) == pytest.approx(42)  # type: ignore[index]


def test_a_model_of_sensors_moves_jaw_lips_and_tongue(folder: Path, model: Path) -> None:
    line = folder / "one.TextGrid"
    take = animate(line, model=str(model), rig="arkit_tongue", life=0, fps=50)
    mouth = dict(zip(CHANNELS, take.articulation.T, strict=True))  # type: ignore[union-attr]
    at = {"AA": 15, "M": 25, "IY": 35}
    assert mouth["jaw"][at["AA"]] > mouth["jaw"][at["IY"]] + 2
    assert mouth["tongue_tip_height"][at["IY"]] > mouth["tongue_tip_height"][at["AA"]] + 5
    assert mouth["lip_gap"][at["M"]] <= 0  # contacts are enforced
    jaw = take.channel("jawOpen")
    assert jaw[at["AA"]] > jaw[at["M"]] + 0.1
    other = animate(line, model=str(model), rig="metahuman", life=0, fps=50)
    assert other.rig == "metahuman"


def test_the_zeros_of_sensors_are_those_of_the_phones(model: Path) -> None:
    target = load_model(str(model)).target
    far = target.channels(target.decode(target.encode(np.zeros((1, 5, 3)), np.zeros((5, 3)))))  # type: ignore[attr-defined]
    assert 0 < far["jaw"][0] < 12


def test_every_recording_is_left_out_in_turn(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["corpus", "score", str(folder / "corpus"), "--leave-out", str(folder / "recipe.toml"), "--json"]
    assert run(given) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["clips"], facts["split"]) == (3, "each clip left out")
    assert facts["models"]["recipe"]["articulation_jaw_r"] > 0.9
    assert facts["models"]["mean of training"]["articulation_jaw_sd_ratio"] == pytest.approx(0, abs=1e-6)


def test_a_folder_without_common_sensors(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording(tmp_path, "one", 0.0)
    np.savez(tmp_path / "one.npz", sensors=("X1", "UL", "LL"), xyz=np.zeros((140, 3, 3)), hz=100)
    write_recording(tmp_path, "two", 0.0)
    np.savez(tmp_path / "two.npz", sensors=("TT", "X2"), xyz=np.zeros((140, 2, 3)), hz=100)
    assert run(["corpus", "build", str(tmp_path), "-o", str(tmp_path / "corpus")]) == 2
    assert "no sensor in common" in capsys.readouterr().err
    assert not (tmp_path / "corpus" / "corpus.json").exists()
