"""Appearance learned from films, on a few real clips; every frame's joint modes beside the corpus."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.comparison.plan import read_plan
from phonanim.corpus.corpus import build_corpus, load_corpus, read_clips
from phonanim.corpus.pictures import joint_examples, load_captured, open_mouth_films, pixel_mse
from phonanim.errors import CorpusError, ModelError
from phonanim.face.aam import build_fitter, track_face
from phonanim.training.mouth import fit_mouth, load_mouth, save_mouth
from phonanim.training.recipe import Recipe

pytest.importorskip("av")
N_TRAIN, N_TEST = 5, 1


@pytest.fixture(scope="module")
def recordings(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five training clips and a test clip of GRID's speaker s1."""
    source, folder = shared_data / "grid_s1", tmp_path_factory.mktemp("grid")
    rows = read_clips(source)
    chosen = [n for n, row in enumerate(rows) if row["split"] == "train"][:N_TRAIN]
    chosen += [n for n, row in enumerate(rows) if row["split"] == "test"][:N_TEST]
    for part, suffix in (("mouth", "mp4"), ("textgrid", "TextGrid")):
        (folder / part).mkdir()
        for n in chosen:
            name = f"{rows[n]['clip']}.{suffix}"
            shutil.copyfile(source / part / name, folder / part / name)
    with (folder / "clips.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows[n] for n in chosen)
    stored = np.load(source / "landmarks.npz")
    units = np.cumsum(stored["delta"].astype(np.int32), axis=0)
    pieces = np.split(units, np.cumsum(stored["frames"])[:-1])
    units = np.concatenate([pieces[n] for n in chosen])
    facts = {name: stored[name] for name in ("scale", "fps", "indices")}
    delta = np.diff(units, axis=0, prepend=np.zeros_like(units[:1]))
    clips = {name: stored[name][chosen] for name in ("clips", "frames")}
    np.savez(folder / "landmarks.npz", delta=delta, **facts, **clips)
    return folder


@pytest.fixture(scope="module")
def corpus_folder(recordings: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("corpus")
    build_corpus(recordings, folder)
    assert run(["corpus", "appearance", str(recordings), "--corpus", str(folder), "--quiet"]) == 0
    return folder


def test_the_model_explains_clips_that_it_has_not_seen(corpus_folder: Path) -> None:
    captured = load_captured(corpus_folder)
    own = pixel_mse(captured.model, captured.joint[captured.rows], captured.grey).whole.mean()
    mean = pixel_mse(captured.model, np.zeros((1, len(captured.model.std))), captured.grey).whole.mean()
    assert own < 0.4 * mean


def test_every_frame_has_its_joint_modes(corpus_folder: Path) -> None:
    corpus, captured = load_corpus(corpus_folder), load_captured(corpus_folder)
    assert captured.joint.shape == (corpus.frames.sum(), len(captured.model.std))
    assert captured.rows.tolist() == corpus.rows(corpus.clips_of("test")).tolist()
    examples = joint_examples(corpus, captured, [3, 0])
    assert np.array_equal(examples.targets[0], captured.joint[corpus.rows([3])])
    shape = captured.model.instance(captured.joint)[0]
    seen = captured.model.face.project(corpus.landmarks)
    assert np.abs(shape - seen).mean() < 1.0  # mm, where the first deviates by 25


def test_the_face_is_found_without_its_landmarks(recordings: Path, corpus_folder: Path) -> None:
    corpus, model = load_corpus(corpus_folder), load_captured(corpus_folder).model
    films, fitter = open_mouth_films(recordings, corpus), build_fitter(model)
    clip = int(corpus.clips_of("test")[0])
    poses = list(track_face(fitter, films.film(clip)[:30]))
    tracked = films.landmarks[corpus.rows([clip])][:30]
    found = np.stack([fitter.landmarks(pose) for pose in poses if pose])
    assert len(found) == 30
    assert np.linalg.norm(found[..., :2] - tracked, axis=2)[:, model.face.moving].mean() < 1.0  # pixels


def test_the_same_films_give_the_same_bytes(recordings: Path, corpus_folder: Path, tmp_path: Path) -> None:
    for name in ("corpus.json", "landmarks.safetensors"):
        shutil.copyfile(corpus_folder / name, tmp_path / name)
    assert run(["corpus", "appearance", str(recordings), "--corpus", str(tmp_path), "--quiet"]) == 0
    for name in ("appearance.json", "appearance.safetensors", "captured.safetensors"):
        first, second = (folder / "appearance" / name for folder in (corpus_folder, tmp_path))
        assert first.read_bytes() == second.read_bytes()


def test_a_mouth_speaks(corpus_folder: Path, recordings: Path, tmp_path: Path) -> None:
    corpus, captured = load_corpus(corpus_folder), load_captured(corpus_folder)
    recipe = Recipe(kind="phone_mean", corpus="")
    save_mouth(fit_mouth(recipe, corpus, captured, Path("recipe.toml")), tmp_path / "mouth")
    mouth = load_mouth(tmp_path / "mouth")
    clips = corpus.clips_of("test")
    joint = np.concatenate([mouth.predict(corpus.tracks[c], corpus.times(c)) for c in clips])
    error = pixel_mse(captured.model, joint, captured.grey).whole.mean()
    assert error < pixel_mse(captured.model, np.zeros_like(joint), captured.grey).whole.mean()
    line = recordings / "textgrid" / f"{corpus.clips[0]}.TextGrid"
    for name in ("a.png", "a.mp4"):
        arguments = [
            "mouth",
            "draw",
            str(line),
            "--model",
            str(tmp_path / "mouth"),
            "-o",
            str(tmp_path / name),
        ]
        assert run([*arguments, "--quiet", "--scale", "1"]) == 0
        assert (tmp_path / name).stat().st_size > 5000


def test_the_train_command(corpus_folder: Path, tmp_path: Path) -> None:
    recipe = tmp_path / "mouth.toml"
    recipe.write_text(f'kind = "phone_mean"\ncorpus = "{corpus_folder}"\n')
    assert run(["mouth", "train", str(recipe), "-o", str(tmp_path / "mouth"), "--quiet"]) == 0
    assert json.loads((tmp_path / "mouth" / "mouth.json").read_text())["kind"] == "phone_mean"


def test_a_mouth_reads_no_audio(corpus_folder: Path) -> None:
    corpus, captured = load_corpus(corpus_folder), load_captured(corpus_folder)
    with pytest.raises(ModelError, match=r"r\.toml: a mouth is driven by phones, but phisanet uses audio"):
        fit_mouth(Recipe(kind="phisanet", corpus=""), corpus, captured, Path("r.toml"))


def test_a_drawing_of_another_format(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = next((recordings / "textgrid").iterdir())
    assert run(["mouth", "draw", str(line), "--model", str(tmp_path), "-o", str(tmp_path / "a.gif")]) == 2
    assert "a.gif: a mouth is drawn as .mp4 or .png; choose one of them" in capsys.readouterr().err


def test_a_folder_that_is_no_mouth(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="is not a mouth .*make one with `phonanim mouth train`"):
        load_mouth(tmp_path)


def test_a_film_that_is_missing(recordings: Path, corpus_folder: Path, tmp_path: Path) -> None:
    for name in ("clips.csv", "landmarks.npz"):
        shutil.copyfile(recordings / name, tmp_path / name)
    films = open_mouth_films(tmp_path, load_corpus(corpus_folder))
    with pytest.raises(
        CorpusError, match=r"mouth/\w+\.mp4: not found; the appearance model needs a mouth video"
    ):
        films.film(0)


def test_a_film_of_another_length(recordings: Path, corpus_folder: Path) -> None:
    films = open_mouth_films(recordings, load_corpus(corpus_folder))
    films.corpus.frames[0] -= 1
    with pytest.raises(CorpusError, match=r"\.mp4: has 75 frames and 74 landmarks; film it again"):
        films.film(0)


def test_recordings_of_another_corpus(recordings: Path, corpus_folder: Path, tmp_path: Path) -> None:
    lines = (recordings / "clips.csv").read_text().splitlines(keepends=True)
    (tmp_path / "clips.csv").write_text("".join(lines[:-1]))
    with pytest.raises(CorpusError, match="its clips are not those of the corpus; build the corpus from it"):
        open_mouth_films(tmp_path, load_corpus(corpus_folder))


def test_films_of_unknown_place(recordings: Path, corpus_folder: Path, tmp_path: Path) -> None:
    table = (recordings / "clips.csv").read_text().replace("crop_x", "left")
    (tmp_path / "clips.csv").write_text(table)
    with pytest.raises(CorpusError, match=r"clips\.csv: lacks crop_x and crop_y, the position of"):
        open_mouth_films(tmp_path, load_corpus(corpus_folder))


def test_a_corpus_whose_appearance_is_damaged(corpus_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(corpus_folder, tmp_path / "c")
    (tmp_path / "c" / "appearance" / "captured.safetensors").write_bytes(b"no tensors")
    with pytest.raises(CorpusError, match="is damaged .*make it again with `phonanim corpus appearance`"):
        load_captured(tmp_path / "c")


@pytest.mark.slow
def test_a_comparison_with_mouths_that_are_drawn(corpus_folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for name, box in (("narrow", 0.12), ("wide", 2.0)):
        recipe = f'kind = "phone_mean"\ncorpus = "{corpus_folder}"\n[settings]\nsmoothing = {box}\n'
        (tmp_path / f"{name}.toml").write_text(recipe)
    plan = (
        f'corpus = "{corpus_folder}"\nreference = "narrow"\nfolds = ["test"]\nmouths = ["narrow", "wide"]\n'
    )
    models = '[models]\nnarrow = "narrow.toml"\nwide = "wide.toml"\n'
    (tmp_path / "plan.toml").write_text(plan + models)
    assert run(["compare", str(tmp_path / "plan.toml"), "-o", str(tmp_path), "--workers", "1", "-q"]) == 0
    document = json.loads((tmp_path / "models/sums.json").read_text())
    drawn = {
        n: np.array(m["scores"]["raw"]["pixels/all"]["pixel_mse"]) for n, m in document["models"].items()
    }
    least = np.array(document["pixel_bound"])
    assert (least[:, 0] < drawn["narrow"][:, 0]).all()
    assert drawn["narrow"][:, 0].sum() < drawn["wide"][:, 0].sum()
    assert "## Drawn as a mouth" in (tmp_path / "benchmark/test.md").read_text()
    (tmp_path / "plan.toml").write_text(plan.replace('"wide"]', '"tall"]') + models)
    with pytest.raises(ModelError, match="mouths: 'tall' is not a recipe among its models"):
        read_plan(tmp_path / "plan.toml")
