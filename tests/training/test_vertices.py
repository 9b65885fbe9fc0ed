"""Vertices of a data set become a corpus, a model of two speakers, a moving mesh, and scores."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from dataset_samples import wav

from phonanim.__main__ import run
from phonanim.corpus.motion import load_motion_corpus
from phonanim.media.glb import read_glb
from phonanim.pipeline import load_model

pytest.importorskip("torch")
SPEAKERS = ("FaceTalk_170728_03272_TA", "FaceTalk_170904_00128_TA")
TEST = "FaceTalk_170809_00138_TA"
VERTICES, FRAMES = 12, 30
RECIPE = """
kind = "facediffuser"
corpus = "corpus"
validation = 0.5
[target]
components = {components}
[settings]
encoder = "mfcc"
latent = 8
hidden = 8
depth = 1
timesteps = 20
steps = 4
window = 20
batch = 4
epochs = 2
rate = 30.0
"""


def face(speaker: int) -> np.ndarray:
    """A round face in metres, larger for each speaker."""
    turn = np.linspace(0, 2 * np.pi, VERTICES, endpoint=False)
    return (0.1 + 0.01 * speaker) * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(VERTICES)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("vocaset")
    for place, speaker in enumerate((*SPEAKERS, TEST)):
        for sentence in (21, 22):
            name = f"{speaker}_sentence{sentence}"
            opened = 0.01 * np.sin(np.arange(FRAMES) / (2 + place + sentence % 2))[:, None, None]
            points = face(place) + opened * np.array([0, 1, 0]) * (face(place)[:, 1:2] < 0)
            (made / "vertices_npy").mkdir(exist_ok=True)
            np.save(made / "vertices_npy" / f"{name}.npy", points.reshape(FRAMES, -1).astype(np.float32))
            wav(made / "wav" / f"{name}.wav", FRAMES / 60)
    rests = {speaker: face(place) for place, speaker in enumerate((*SPEAKERS, TEST))}
    (made / "templates.pkl").write_bytes(pickle.dumps(rests, protocol=2))
    rows = [f"v {x} {y} {z}" for x, y, z in face(0)]
    rows += [f"f 1 {n} {n + 1}" for n in range(2, VERTICES)]
    (made / "mesh.obj").write_text("\n".join(rows) + "\n", "utf-8")
    given = ["corpus", "build", str(made), "--dataset", "vocaset", "--every", "2", "-o", str(made / "corpus")]
    assert run([*given, "--mesh", str(made / "mesh.obj")]) == 0
    return made


def trained(folder: Path, components: int) -> Path:
    recipe = folder / f"components{components}.toml"
    recipe.write_text(RECIPE.format(components=components), "utf-8")
    assert run(["train", str(recipe), "-o", str(folder / recipe.stem)]) == 0
    return folder / recipe.stem


@pytest.fixture(scope="module")
def model(folder: Path) -> Path:
    return trained(folder, 0)


def test_subjects_have_their_templates_and_the_splits_are_published(folder: Path) -> None:
    corpus = load_motion_corpus(folder / "corpus")
    assert (corpus.kind, corpus.fps) == ("vertices", 30.0)
    assert {clip.subject: clip.split for clip in corpus.clips} == dict.fromkeys(SPEAKERS, "train") | {
        TEST: "test"
    }
    for number, clip in enumerate(corpus.clips):
        assert corpus.frames(number).shape == (FRAMES // 2, VERTICES, 3)
        place = (*SPEAKERS, TEST).index(clip.subject)
        assert corpus.rest(number) == pytest.approx(face(place), abs=1e-6)


def test_styles_are_the_training_speakers(model: Path) -> None:
    loaded = load_model(str(model))
    assert loaded.card["styles"] == list(SPEAKERS)
    assert loaded.regressor.config.styles == 2
    assert loaded.target.size == 3 * VERTICES


def test_a_model_moves_a_mesh_of_a_subject(folder: Path, model: Path) -> None:
    line = folder / "wav" / f"{TEST}_sentence21.wav"
    for style, suffix in (("0", "npy"), ("1", "npy"), ("1", "glb")):
        out = folder / f"line{style}.{suffix}"
        given = ["animate", str(line), "--model", str(model), "--style", style, "--fps", "30", "-o", str(out)]
        assert run(given) == 0
    first, second = (np.load(folder / f"line{style}.npy") for style in "01")
    assert first.shape == second.shape == (FRAMES // 2 + 1, VERTICES, 3)
    assert np.abs(first[:, :, 0] - face(0)[:, 0]).max() < np.abs(first[:, :, 0] - face(1)[:, 0]).max()
    glb = read_glb(folder / "line1.glb")
    mesh = glb.tree["meshes"][0]["primitives"][0]
    rest = glb.accessor(mesh["attributes"]["POSITION"])
    assert rest == pytest.approx(face(1), abs=1e-5)  # metres
    targets = np.stack([glb.accessor(one["POSITION"]) for one in mesh["targets"]])
    sampler = glb.tree["animations"][0]["samplers"][0]
    weights = glb.accessor(sampler["output"]).reshape(len(second), -1)
    assert rest + np.tensordot(weights, targets, 1) == pytest.approx(second, abs=1e-5)


def test_a_style_has_a_name(folder: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["animate", str(folder / "wav" / f"{TEST}_sentence21.wav"), "--model", str(model), "--fps", "30"]
    for name, style in (("number", "1"), ("name", SPEAKERS[1])):
        assert run([*line, "--style", style, "-o", str(folder / f"{name}.npy")]) == 0
    assert np.array_equal(np.load(folder / "number.npy"), np.load(folder / "name.npy"))
    capsys.readouterr()
    assert run([*line, "--style", SPEAKERS[1][:-1], "-o", str(folder / "none.npy")]) == 2
    assert f"did you mean {SPEAKERS[1]!r}?" in capsys.readouterr().err
    assert run([*line, "--style", "zzz", "-o", str(folder / "none.npy")]) == 2
    assert f"choose {', '.join(SPEAKERS)}, " in capsys.readouterr().err


def test_a_mesh_as_template_brings_its_triangles(
    folder: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["corpus", "build", str(folder / "corpus"), "-o", str(folder / "bare")]
    assert run(given) == 0  # without --mesh
    recipe = folder / "bare.toml"
    text = RECIPE.format(components=2).replace('"corpus"', '"bare"').replace("epochs = 2", "epochs = 1")
    recipe.write_text(text, "utf-8")
    capsys.readouterr()
    assert run(["train", str(recipe), "-o", str(folder / "bare model")]) == 0
    assert f"styles, for --style: {', '.join(SPEAKERS)}" in capsys.readouterr().err
    line = ["animate", str(folder / "wav" / f"{TEST}_sentence21.wav"), "--model", str(folder / "bare model")]
    outputs = ["-o", str(folder / "bare.npy"), "-o", str(folder / "bare.glb")]
    assert run([*line, *outputs]) == 2
    assert "give a face of it as a mesh (--template face.obj or .ply)" in capsys.readouterr().err
    assert not (folder / "bare.npy").exists()
    assert run([*line, *outputs, "--template", str(folder / "mesh.obj")]) == 0
    glb = read_glb(folder / "bare.glb")
    mesh = glb.tree["meshes"][0]["primitives"][0]
    assert glb.accessor(mesh["attributes"]["POSITION"]) == pytest.approx(face(0), abs=1e-5)
    assert len(glb.accessor(mesh["indices"]).ravel()) == 3 * (VERTICES - 2)
    assert run([*line, "-o", str(folder / "mesh.obj"), "--template", str(folder / "mesh.obj")]) == 2
    assert "is named twice, as input or output" in capsys.readouterr().err


def test_a_model_that_samples_makes_takes(folder: Path, model: Path) -> None:
    line = ["animate", str(folder / "wav" / f"{TEST}_sentence21.wav"), "--model", str(model), "--seed", "7"]
    assert run([*line, "-o", str(folder / "take.npy"), "--takes", "2"]) == 0
    assert run([*line, "-o", str(folder / "seven.npy"), "--steps", "2"]) == 0
    first, second = (np.load(folder / f"take.take{number}.npy") for number in (1, 2))
    assert first.shape == second.shape
    assert not np.array_equal(first, second)
    assert not np.array_equal(first, np.load(folder / "seven.npy"))
    assert run([*line, "-o", str(folder / "seven.npy")]) == 0
    assert np.array_equal(first, np.load(folder / "seven.npy"))


def test_a_face_of_ones_own(folder: Path, model: Path) -> None:
    np.save(folder / "own.npy", face(5))
    line = ["animate", str(folder / "wav" / f"{TEST}_sentence21.wav"), "--model", str(model)]
    assert run([*line, "--template", str(folder / "own.npy"), "-o", str(folder / "own_line.npy")]) == 0
    assert np.load(folder / "own_line.npy")[:, 0, 0].mean() == pytest.approx(0.15, abs=0.02)


def test_components_are_scored_beside_all_coordinates(
    folder: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reduced = trained(folder, 2)
    target = load_model(str(reduced)).target
    corpus = load_motion_corpus(folder / "corpus")
    rows = target.encode(corpus.frames(0), corpus.rest(0))
    assert rows.shape == (FRAMES // 2, target.size)
    assert target.decode(rows, corpus.rest(0)) == pytest.approx(corpus.frames(0), abs=1e-5)
    capsys.readouterr()
    given = ["corpus", "score", str(folder / "corpus"), "--model", str(model), "--model", str(reduced)]
    pytest.importorskip("matplotlib")
    assert run([*given, "-o", str(folder / "scored"), "--heat", str(folder / "heat.png"), "--json"]) == 0
    assert (folder / "heat.png").read_bytes().startswith(b"\x89PNG")
    facts = json.loads(capsys.readouterr().out)
    assert facts["clips"] == 2
    assert all(row["mve_mm"] > 0 for row in facts["models"].values())
    assert np.load(next((folder / "scored" / "captured").glob("*.npy"))).shape == (FRAMES // 2, VERTICES, 3)


def test_what_is_not_a_mesh_is_said(folder: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["animate", str(folder / "wav" / f"{TEST}_sentence21.wav"), "--model", str(model)]
    assert run([*line, "-o", str(folder / "line.csv")]) == 2
    assert "a moving mesh is written as .npy or .glb" in capsys.readouterr().err
    assert run([*line, "-o", str(folder / "line.npy"), "--view"]) == 2
    assert "--view: the model moves vertices" in capsys.readouterr().err
    np.save(folder / "other.npy", np.zeros((5, 3)))
    assert run([*line, "--template", str(folder / "other.npy"), "-o", str(folder / "line.npy")]) == 2
    assert "is (5, 3) of numbers, and the model has 12 vertices" in capsys.readouterr().err
