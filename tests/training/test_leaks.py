"""Nothing that is fitted looks at the clips on which a model is measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from motions import KINDS, made_up_motion
from speech import made_up_corpus

from phonanim.comparison.fit import train_job
from phonanim.comparison.folds import make_folds
from phonanim.comparison.plan import Plan, Sweep
from phonanim.comparison.run import _jobs
from phonanim.comparison.sweeps import split_clips, sweep_jobs
from phonanim.corpus import pictures
from phonanim.corpus.corpus import RIGID, Corpus, remove_pose_leak, save_corpus, stabilize
from phonanim.corpus.motion import load_motion_corpus
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel
from phonanim.regressors import load
from phonanim.training.recipes import train


def with_noise(corpus: Corpus, clips: list[int]) -> Corpus:
    """The corpus with landmarks that make no sense in some clips."""
    landmarks = corpus.landmarks.copy()
    rows = corpus.rows(clips)
    noise = np.random.default_rng(7).normal(0, 9, landmarks[rows].shape)
    landmarks[rows] += noise.astype(np.float32)
    return replace(corpus, landmarks=landmarks)


def saved(corpus: Corpus, folder: Path) -> Path:
    """A corpus with a recipe of mean modes beside it."""
    save_corpus(corpus, folder / "corpus")
    (folder / "mean.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    return folder


def same(one: FaceModel, other: FaceModel) -> bool:
    return one.id == other.id


def test_the_face_of_a_training_ignores_the_test_clips(tmp_path: Path) -> None:
    corpus = made_up_corpus(np.random.default_rng(3))
    clips = corpus.clips_of("test").tolist()
    changed = with_noise(corpus, clips)
    faces = [
        load(train(saved(made, tmp_path / name) / "mean.toml", tmp_path / name / "model")).face
        for name, made in (("plain", corpus), ("changed", changed))
    ]
    assert same(*faces)
    every = range(len(corpus.clips))
    fitted = [fit_face(made.landmarks[made.rows(every)], made.indices) for made in (corpus, changed)]
    assert not same(*fitted)


def test_an_appearance_model_is_fitted_to_training_clips(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    corpus = made_up_corpus(np.random.default_rng(3))
    faces: list[FaceModel] = []

    def keep_face(films: None, face: FaceModel, *rest: object) -> None:
        faces.append(face)

    for part in ("open_mouth_films", "capture_joint_modes", "save_captured"):
        monkeypatch.setattr(pictures, part, lambda *given: None)
    monkeypatch.setattr(pictures, "fit_appearance", keep_face)
    for name, made in (("plain", corpus), ("changed", with_noise(corpus, corpus.clips_of("test").tolist()))):
        save_corpus(made, tmp_path / name)
        pictures.build_appearance(tmp_path, tmp_path / name)
    assert same(*faces)
    assert set(pictures.choose_samples(corpus)[0].tolist()) <= set(corpus.clips_of("train").tolist())


def test_no_fold_of_a_comparison_has_a_face_of_what_it_withholds(tmp_path: Path) -> None:
    folder = saved(made_up_corpus(np.random.default_rng(3)), tmp_path)
    sweep = Sweep("clips", (0.5, 1.0), folder / "mean.toml")
    plan = Plan(
        folder / "corpus",
        {"mean": folder / "mean.toml"},
        "mean",
        words=(("w1",),),
        phones=("m",),
        folds=("test", "words", "phones"),
        sweeps={"amount": sweep},
    )
    corpus = made_up_corpus(np.random.default_rng(3))
    found = list(make_folds(plan, corpus))
    assert len(found) == 3
    for fold in found:
        (job,) = _jobs(plan, fold, tmp_path / "work")
        assert not set(job.face_clips) & set(fold.test.tolist())
        train_job(job)
        shapes = corpus.landmarks[corpus.rows(job.face_clips)]
        assert same(load(job.folder).face, fit_face(shapes, corpus.indices))
    _, held_out = split_clips(plan, corpus)
    for job in sweep_jobs(plan, corpus, tmp_path / "work"):
        assert not set(job.face_clips) & set(held_out.tolist())


def test_a_model_on_another_face_is_another_job(tmp_path: Path) -> None:
    folder = saved(made_up_corpus(np.random.default_rng(3)), tmp_path)
    plan = Plan(folder / "corpus", {"mean": folder / "mean.toml"}, "mean", folds=("test",))
    (fold,) = make_folds(plan, made_up_corpus(np.random.default_rng(3)))
    (job,) = _jobs(plan, fold, tmp_path / "work")
    assert replace(job, face_clips=job.face_clips[1:]).key != job.key


@pytest.fixture
def takes() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Shapes that bend with the pose, (frames, 2, 3), the pose, the clips' lengths and what is trained on."""
    rng = np.random.default_rng(2)
    clips, frames = 40, 10
    pose = np.repeat(rng.normal(0, 0.1, (clips, 4)), frames, axis=0)
    shapes = rng.normal(0, 1, (clips * frames, 2, 3)) + 8 * pose[:, :1, None]
    return shapes, pose, np.full(clips, frames), np.arange(clips * frames) < 300


def test_the_pose_regression_ignores_the_test_clips(takes: tuple[np.ndarray, ...]) -> None:
    shapes, pose, frames, train = takes
    plain = remove_pose_leak(shapes, pose, frames, train)
    spoiled = np.where(train[:, None, None], shapes, shapes - 50 * pose[:, 1:2, None])
    found = remove_pose_leak(spoiled, pose, frames, train)
    np.testing.assert_allclose(found[train], plain[train], atol=1e-9)
    assert np.abs(found[~train] - plain[~train]).max() > 1


def test_the_head_is_held_to_the_mean_of_the_training_clips() -> None:
    rng = np.random.default_rng(4)
    numbers = np.array(sorted({*RIGID, 468, 473, 13, 14}))
    points = rng.normal(0, 30, (1, len(numbers), 3)) + rng.normal(0, 0.5, (60, len(numbers), 3))
    train = np.arange(60) < 40
    plain, _ = stabilize(points, numbers, train)
    spoiled = points.copy()
    spoiled[~train] += rng.normal(0, 9, spoiled[~train].shape)
    found, _ = stabilize(spoiled, numbers, train)
    np.testing.assert_allclose(found[train], plain[train], atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_the_target_of_a_training_ignores_the_test_clips(kind: str, tmp_path: Path) -> None:
    """The scaling of controls and sensors, the zeros of channels, the components of vertices."""
    learned = []
    for name in ("plain", "changed"):
        folder = made_up_motion(kind, tmp_path / name)
        corpus = load_motion_corpus(folder / "corpus")
        if name == "changed":
            for clip in corpus.clips_of("test"):
                path = corpus.clips[int(clip)].motion
                np.save(path, 9 * np.load(path))
        (folder / "mean.toml").write_text(
            'kind = "phone_mean"\ncorpus = "corpus"\n[target]\ncomponents = 2\n', "utf-8"
        )
        target = load(train(folder / "mean.toml", folder / "model")).target
        assert target.kind == kind
        learned.append(target.tensors() | target.facts())
    assert learned[0].keys() == learned[1].keys()
    assert all(np.array_equal(learned[0][name], learned[1][name]) for name in learned[0])
