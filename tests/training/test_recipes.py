"""From recordings to a trained model: stabilization, the corpus, recipes, the teacher."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from speech import made_up_face

import phonanim
from phonanim.core.plugins import _entries
from phonanim.corpus.corpus import PUPILS, RIGID, build_corpus, load_corpus, remove_pose_leak, stabilize
from phonanim.errors import CorpusError, ModelError
from phonanim.face.fit import fit_face
from phonanim.regressors import load
from phonanim.training.recipe import read_recipe
from phonanim.training.recipes import train

FACE = made_up_face(np.random.default_rng(0))
NUMBERS = np.array(sorted({*RIGID, *PUPILS, *FACE.indices.tolist()}))
TEXTGRID = """File type = "ooTextFile"
Object class = "TextGrid"

0
1.2
<exists>
2
"IntervalTier"
"words"
0
1.2
3
0
0.4
""
0.4
0.8
"ma"
0.8
1.2
""
"IntervalTier"
"phones"
0
1.2
4
0
0.4
"sil"
0.4
0.5
"M"
0.5
0.8
"AA1"
0.8
1.2
"sil"
"""


def rotation(angles: np.ndarray) -> np.ndarray:
    """Rotations about y, then x, (n, 2) radians -> (n, 3, 3), for rows of points."""
    (a, b), n = angles.T, len(angles)
    yaw, pitch = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    yaw[:, 1, 1] = pitch[:, 0, 0] = 1
    yaw[:, 0, 0], yaw[:, 2, 2], yaw[:, 0, 2], yaw[:, 2, 0] = np.cos(a), np.cos(a), -np.sin(a), np.sin(a)
    pitch[:, 1, 1], pitch[:, 2, 2], pitch[:, 1, 2], pitch[:, 2, 1] = (
        np.cos(b),
        np.cos(b),
        np.sin(b),
        -np.sin(b),
    )
    return yaw @ pitch


def still_face(rng: np.random.Generator) -> np.ndarray:
    """Random points, the rigid ones spread, the pupils 46 apart, the mouth below the nose."""
    points = rng.normal(0, 20, (len(NUMBERS), 3))
    rows = {number: row for row, number in enumerate(NUMBERS)}
    points[rows[468]], points[rows[473]] = (-23, 0, 0), (23, 0, 0)
    points[rows[2]] = (0, -30, 10)
    for number in FACE.indices:
        if number not in RIGID and number != 2:
            points[rows[int(number)]] = FACE.mean[FACE.landmark(int(number))] * 46 / 63
    return points


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    """Twelve clips of 30 frames: a face that turns, and opens its mouth while a vowel lasts."""
    rng = np.random.default_rng(4)
    still, frames = still_face(rng), 30
    rows = {number: row for row, number in enumerate(NUMBERS)}
    folder = tmp_path / "made_up"
    (folder / "textgrid").mkdir(parents=True)
    names = [f"clip{i}" for i in range(12)]
    pixels = []
    for name in names:
        (folder / "textgrid" / f"{name}.TextGrid").write_text(TEXTGRID)
        moving = np.tile(still, (frames, 1, 1))
        times = (np.arange(frames) + 0.5) / 25
        opening = np.where((times > 0.5) & (times < 0.8), 6.0, 0) + rng.normal(0, 0.3, frames)
        for number in (14, 17, 88, 178, 87, 317, 402, 318):
            moving[:, rows[number], 1] -= opening
        moving[:, rows[61], 0] -= rng.normal(0, 0.5, frames)
        turned = moving @ rotation(np.tile(rng.normal(0, 0.05, 2), (frames, 1)))
        pixels.append(turned * [1, -1, -1] + [180, 144, 0])
    scale = 0.05
    whole = np.round(np.concatenate(pixels) / scale).astype(np.int32)
    np.savez(
        folder / "landmarks.npz",
        clips=np.array(names),
        frames=np.full(12, frames, np.int32),
        delta=np.diff(whole, axis=0, prepend=0).astype(np.int16),
        indices=NUMBERS.astype(np.int16),
        scale=np.float32(scale),
        fps=np.float32(25),
    )
    lines = [f"{name},{frames},{'test' if i > 9 else 'train'}" for i, name in enumerate(names)]
    (folder / "clips.csv").write_text("clip,frames,split\n" + "\n".join(lines) + "\n")
    return folder


def test_stabilizing_undoes_the_head() -> None:
    rng = np.random.default_rng(1)
    still = still_face(rng)
    turned = np.stack([still * s for s in rng.uniform(0.8, 1.2, 50)]) @ rotation(rng.normal(0, 0.2, (50, 2)))
    turned += rng.normal(0, 30, (50, 1, 3))
    shapes, pose = stabilize(turned, NUMBERS, np.ones(50, bool))
    assert np.ptp(shapes, axis=0).max() < 1e-6
    assert pose.shape == (50, 4)
    pupils = [int(np.flatnonzero(n == NUMBERS)[0]) for n in PUPILS]
    assert np.linalg.norm(shapes[0, pupils[0]] - shapes[0, pupils[1]]) == pytest.approx(63)
    assert np.allclose(shapes[:, pupils].mean(axis=(0, 1)), 0, atol=1e-9)


def test_what_follows_the_pose_from_clip_to_clip_is_removed_and_speech_stays() -> None:
    rng = np.random.default_rng(2)
    frames, clips = 20, 40
    pose = np.repeat(rng.normal(0, 0.1, (clips, 4)), frames, axis=0)
    speech = np.tile(np.sin(np.arange(frames))[:, None, None], (clips, 2, 3))
    bent = speech + 8 * pose[:, :1, None]
    freed = remove_pose_leak(bent, pose, np.full(clips, frames), np.ones(clips * frames, bool))
    assert np.allclose(freed - freed.mean(axis=0), speech - speech.mean(axis=0), atol=1e-9)


def test_build_and_read_a_corpus(recordings: Path, tmp_path: Path) -> None:
    built = build_corpus(recordings, tmp_path / "corpus")
    corpus = load_corpus(tmp_path / "corpus")
    assert np.array_equal(corpus.landmarks, built.landmarks)
    assert corpus.clips[3] == "clip3"
    assert corpus.clips_of("test").tolist() == [10, 11]
    assert corpus.words[0][0].label == "ma"
    assert corpus.times(0)[0] == pytest.approx(0.02)
    assert len(corpus.rows(corpus.clips_of("train"))) == 300


def test_no_test_clip_changes_what_is_trained_on(recordings: Path, tmp_path: Path) -> None:
    """Neither the mean that holds the head nor the regression on its pose is fitted to test clips."""
    plain = build_corpus(recordings, tmp_path / "plain")
    stored = dict(np.load(recordings / "landmarks.npz"))
    learned, tested = (plain.rows(plain.clips_of(split)) for split in ("train", "test"))
    assert learned.max() < tested.min()  # so that a change of the last clips is theirs alone
    stored["delta"][tested] += np.random.default_rng(0).integers(-40, 40, stored["delta"][tested].shape, "i2")
    np.savez(recordings / "landmarks.npz", **stored)
    changed = build_corpus(recordings, tmp_path / "changed")
    np.testing.assert_array_equal(changed.landmarks[learned], plain.landmarks[learned])
    assert np.abs(changed.landmarks[tested] - plain.landmarks[tested]).max() > 1


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda f: (f / "clips.csv").unlink(), "clips.csv: not found; a recordings folder has"),
        (lambda f: (f / "clips.csv").write_text("name\n1\n"), "needs a row per clip with the columns"),
        (
            lambda f: (f / "landmarks.npz").write_bytes(b""),
            "landmarks.npz: is damaged .*; track the clips again",
        ),
        (lambda f: (f / "landmarks.npz").unlink(), "landmarks.npz: not found; a recordings folder has"),
        (lambda f: (f / "clips.csv").write_text("clip,frames,split\nx,3,train\n"), "differ from clips.csv"),
    ],
)
def test_recordings_that_cannot_be_used(
    recordings: Path, tmp_path: Path, spoil: object, message: str
) -> None:
    spoil(recordings)  # type: ignore[operator]
    with pytest.raises(CorpusError, match=message):
        build_corpus(recordings, tmp_path / "corpus")


def test_recordings_without_what_holds_the_head(recordings: Path, tmp_path: Path) -> None:
    stored = dict(np.load(recordings / "landmarks.npz"))
    stored["indices"] = stored["indices"] + 500
    np.savez(recordings / "landmarks.npz", **stored)
    with pytest.raises(CorpusError, match=r"lacks the landmarks \[5, 6, 8"):
        build_corpus(recordings, tmp_path / "corpus")


def test_a_folder_that_is_no_corpus(tmp_path: Path) -> None:
    with pytest.raises(CorpusError, match="not a corpus .*; make one with `phonanim corpus build`"):
        load_corpus(tmp_path)


@pytest.fixture
def recipe(recordings: Path, tmp_path: Path) -> Path:
    pytest.importorskip("torch")
    pytest.importorskip("sklearn")
    build_corpus(recordings, tmp_path / "corpus")
    (tmp_path / "lines").mkdir()
    (tmp_path / "lines" / "a.TextGrid").write_text(TEXTGRID.replace('"AA1"', '"SH"'))
    path = tmp_path / "small.toml"
    path.write_text(
        'kind = "dnn"\ncorpus = "corpus"\nlicence = "made up"\nvalidation = 0.2\n'
        "[settings]\nhidden = [8]\nepochs = 3\nbatch = 32\n"
        '[teacher]\nnatural = ["lines"]\nblend = 0.5\n[[teacher.members]]\nkind = "phone_mean"\n'
    )
    return path


def test_training_twice_gives_the_same_bytes(recipe: Path, tmp_path: Path) -> None:
    seen: list[float] = []
    first = train(recipe, tmp_path / "a", progress=seen.append)
    second = train(recipe, tmp_path / "b")
    assert seen == sorted(seen)
    assert seen[-1] == 1
    for file in ("weights.safetensors", "model.json"):
        assert (first / file).read_bytes() == (second / file).read_bytes()
    other = train(recipe, tmp_path / "c", seed=7)
    assert (other / "weights.safetensors").read_bytes() != (first / "weights.safetensors").read_bytes()


def test_the_card_says_where_it_comes_from(recipe: Path, tmp_path: Path) -> None:
    card = load(train(recipe, tmp_path / "a")).card
    assert card["provenance"]["licence"] == "made up"
    assert set(card["provenance"]["scores"]) == {
        "validation_vertex_error_mm", "validation_aperture_r", "validation_width_r",
    }  # fmt: skip


def test_a_teacher_without_lines(recipe: Path, tmp_path: Path) -> None:
    recipe.write_text(recipe.read_text().replace('"lines"', '"nowhere"'))
    with pytest.raises(CorpusError, match=r"\[teacher\] natural: no TextGrid in"):
        train(recipe, tmp_path / "a")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind = ", "cannot be read: it is not TOML"),
        ('corpus = "x"', "lacks 'kind'; see the examples"),
        ('kind = "dnn"\ncorpus = "x"\nsed = 3', "there is no key 'sed'; did you mean 'seed'"),
        ('kind = "dnn"\ncorpus = "x"\n[teacher]\nzzz = 3', r"\[teacher\]: there is no key 'zzz'; known are"),
    ],
)
def test_recipes_that_cannot_be_used(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ModelError, match=message):
        read_recipe(path)


def test_the_shipped_recipes_are_sound(root: Path) -> None:
    recipes = sorted((root / "benchmarks/configs").glob("*.toml"))
    assert {"default", "taylor2017", "tree", "procedural", "phone_mean"} <= {r.stem for r in recipes}
    for path in recipes:
        read_recipe(path)


def test_commands_build_and_train(recordings: Path, recipe: Path, tmp_path: Path) -> None:
    from phonanim.commands.corpus import command as corpus_command
    from phonanim.commands.train import command as train_command

    built = CliRunner().invoke(
        corpus_command, ["build", str(recordings), "-o", str(tmp_path / "c2"), "--json"]
    )
    assert built.exit_code == 0, built.output
    done = CliRunner().invoke(train_command, [str(recipe), "-o", str(tmp_path / "m"), "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["model"] == str(tmp_path / "m")


@pytest.mark.parametrize("rig", ["arkit", "vrm", "metahuman", "oculus15", "face"])
def test_a_model_of_another_speaker_moves_every_rig(recipe: Path, tmp_path: Path, rig: str) -> None:
    pytest.importorskip("torch")
    train(recipe, tmp_path / "mine")
    (tmp_path / "a.TextGrid").write_text(TEXTGRID)
    chosen = {"model": str(tmp_path / "mine"), "rig": rig, "fps": 60.0}
    for how in ("auto", "direct" if rig == "face" else "poses"):
        moved = phonanim.animate(tmp_path / "a.TextGrid", retarget=how, life=0, **chosen)
        assert np.ptp(moved.values, axis=0).max() > 0.2
    notes = moved.provenance["notes"]
    assert any("the model's face is not the rig's" in note for note in notes)


@pytest.mark.slow
def test_real_recordings(shared_data: Path, tmp_path: Path) -> None:
    corpus = build_corpus(shared_data / "grid_s1", tmp_path / "corpus")
    train_rows = corpus.rows(corpus.clips_of("train"))
    face = fit_face(corpus.landmarks[train_rows], corpus.indices)
    assert len(corpus.clips_of("test")) == 50
    assert 12 <= len(face.std) <= 16
    energy = face.std**2
    assert energy[:4].sum() / energy.sum() > 0.9


def test_a_regressor_of_another_package_is_trained_by_a_recipe(
    recordings: Path, tmp_path: Path, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("sklearn")
    facts = tmp_path / "site/phonanim_example-1.0.dist-info"
    facts.mkdir(parents=True)
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: phonanim-example\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[phonanim.regressors]\nheld_mean = phonanim_example.held_mean\n")
    for folder in (tmp_path / "site", root / "examples/plugin"):
        monkeypatch.syspath_prepend(str(folder))
    _entries.cache_clear()
    build_corpus(recordings, tmp_path / "corpus")
    path = tmp_path / "held.toml"
    path.write_text('kind = "held_mean"\ncorpus = "corpus"\n[settings]\ngain = 1.5\n')
    model = load(train(path, tmp_path / "held"))
    _entries.cache_clear()
    assert (model.card["kind"], model.regressor.config.gain) == ("held_mean", 1.5)
    assert model.card["provenance"]["scores"]["validation_aperture_r"] > 0.3
