"""A corpus is built from every data set by one command, and damage is told in a line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.corpus.corpus import load_corpus
from phonanim.corpus.motion import corpus_kind, load_motion_corpus
from phonanim.datasets import dataset_names, load_dataset
from phonanim.errors import CorpusError

Made = Callable[[str], tuple[Path, list[Any]]]


def built(folder: Path, name: str, *more: str) -> Path:
    corpus = folder / "built corpus"
    given = ["corpus", "build", str(folder), "--dataset", name, "-o", str(corpus), *more]
    assert run([*given, "--language", "english"]) == 0
    return corpus


@pytest.mark.parametrize("name", dataset_names())
def test_every_data_set_becomes_a_corpus(name: str, made: Made) -> None:
    folder, recordings = made(name)
    corpus = load_motion_corpus(built(folder, name))
    assert corpus.kind == load_dataset(name).CARD.kind == corpus_kind(folder / "built corpus")
    used = {one.name: one for one in recordings}
    assert corpus.source.data == name
    assert corpus.clips
    for number, clip in enumerate(corpus.clips):
        assert clip.subject == used[clip.name].speaker
        frames = corpus.frames(number)
        assert len(frames) == clip.frames
        assert np.isfinite(frames).all()
        assert (corpus.rest(number) is None) == (corpus.kind == "controls")
    assert any(clip.split == "train" for clip in corpus.clips)


def test_guesses_are_said(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    folder, _ = made("vocaset")
    built(folder, "vocaset")
    assert "no faces at rest: the first frame of each subject" in capsys.readouterr().err
    folder, _ = made("facegood")
    built(folder, "facegood")
    assert "no faces at rest" not in capsys.readouterr().err


def test_controls_are_named_by_a_file(made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, _ = made("imft23")
    assert load_motion_corpus(built(folder, "imft23")).source.names == ()
    assert "the controls have no names and are numbered from 0; --names FILE" in capsys.readouterr().err
    names = [f"CTRL_{number}" for number in range(67)]
    (tmp_path / "names.txt").write_text("\ufeff" + "\n".join(names) + "\n", "utf-8")
    corpus = load_motion_corpus(built(folder, "imft23", "--names", str(tmp_path / "names.txt")))
    assert list(corpus.source.names) == names
    assert "no names" not in capsys.readouterr().err
    given = ["corpus", "build", str(folder / "built corpus"), "-o", str(tmp_path / "again"), "--names"]
    for wrong, told in (
        ("a,b", "there are 2 names, and a frame has 67 controls"),
        (",".join(["a"] * 67), "two controls are called 'a'"),
    ):
        assert run([*given, wrong]) == 2
        assert told in capsys.readouterr().err


def test_splits_are_told(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    folder, _ = made("biwi")
    built(folder, "biwi")
    assert "splits: 1 train, 1 validation, 1 test, 1 test_b, 4 unused" in capsys.readouterr().err


def test_vertices_are_left_out(made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As the released code of FaceDiffuser reduces Multiface from 7,306 vertices to 6,172."""
    import pickle

    folder = tmp_path / "multiface"
    ignored = np.random.default_rng(1).choice(7306, 1134, replace=False)
    for sentence in range(11):
        mesh = folder / "m--1" / "tracked_mesh" / f"SEN_{sentence:02d}"
        mesh.mkdir(parents=True)
        values = np.arange(7306 * 3, dtype="<f4") + sentence
        (mesh / "000001.bin").write_bytes(values.tobytes())
    rests = {"m--1": np.zeros((7306, 3)), "small": np.zeros((6172, 3))}
    (folder / "templates.pkl").write_bytes(pickle.dumps(rests, protocol=2))
    (tmp_path / "ignored.txt").write_text(", ".join(map(str, ignored)), "utf-8")
    corpus = load_motion_corpus(
        built(folder, "multiface", "--ignore-vertices", str(tmp_path / "ignored.txt"))
    )
    kept = np.setdiff1d(np.arange(7306), ignored)
    assert corpus.frames(1)[0, :, 0].tolist() == (3.0 * kept + 1).tolist()
    assert {rest.shape for rest in corpus.source.templates.values()} == {(6172, 3)}
    (tmp_path / "ignored.txt").write_text("7306", "utf-8")
    given = ["corpus", "import", "multiface", str(folder), "-o", str(tmp_path / "out"), "--ignore-vertices"]
    capsys.readouterr()
    assert run([*given, str(tmp_path / "ignored.txt")]) == 2
    assert "names vertex 7306, and a frame has 7306 (from 0)" in capsys.readouterr().err
    folder, _ = made("facegood")
    given[2:4] = ["facegood", str(folder)]
    assert run([*given, str(tmp_path / "ignored.txt")]) == 2
    assert "--ignore-vertices: facegood has controls, not vertices" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--dataset", "facegood", "--axes", "left,back,up"], "--axes: is for sensors, and the data set has"),
        (["--dataset", "vocaset", "--names", "a"], "--names: vertices have none; leave it out"),
        (["--every", "2", "--names", "a"], "--every, --names: is for data sets and sensors, and these are"),
    ],
)
def test_options_of_something_else(
    options: list[str], told: str, made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = made(options[1])[0] if options[0] == "--dataset" else tmp_path
    assert run(["corpus", "build", str(folder), "-o", str(tmp_path / "out"), *options]) == 2
    assert told in capsys.readouterr().err


def test_every_second_frame_is_kept(made: Made) -> None:
    folder, _ = made("facegood")
    corpus = load_motion_corpus(built(folder, "facegood", "--every", "2"))
    assert (corpus.fps, corpus.clips[0].frames) == (15.0, 20)


def test_a_model_of_landmarks_needs_landmarks(made: Made) -> None:
    folder, _ = made("facegood")
    corpus = built(folder, "facegood")
    with pytest.raises(CorpusError, match="is a corpus of controls, and landmarks are needed here"):
        load_corpus(corpus)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"fps": "fast"}, "not a corpus"),
        ({"clips": [{"clip": "a"}]}, "not a corpus"),
        ({"names": 3}, "not a corpus"),
    ],
)
def test_a_damaged_index(change: dict[str, Any], why: str, made: Made) -> None:
    folder, _ = made("facegood")
    corpus = built(folder, "facegood")
    document = json.loads((corpus / "corpus.json").read_text("utf-8"))
    (corpus / "corpus.json").write_text(json.dumps(document | change), "utf-8")
    with pytest.raises(CorpusError, match=why):
        load_motion_corpus(corpus)


def test_motion_that_is_not_there(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    folder, _ = made("facegood")
    corpus = built(folder, "facegood")
    (corpus / "motion" / "take_0.npy").write_bytes(b"nothing")
    with pytest.raises(CorpusError, match=r"take_0\.npy: cannot be read"):
        load_motion_corpus(corpus).frames(0)
    (corpus / "motion" / "take_1.npy").unlink()
    capsys.readouterr()
    assert run(["corpus", "build", str(corpus), "-o", str(folder / "again")]) == 2
    assert "take_1.npy: is missing" in capsys.readouterr().err


def test_motion_without_numbers(made: Made) -> None:
    folder, _ = made("facegood")
    corpus = built(folder, "facegood")
    values = np.load(corpus / "motion" / "take_1.npy")
    values[7, 0] = np.nan
    np.save(corpus / "motion" / "take_1.npy", values)
    clips = load_motion_corpus(corpus).examples([0, 1])
    assert len(next(iter(clips))[0]) == 40
    with pytest.raises(CorpusError, match=r"take_1\.npy: frame 7 has numbers that are not finite"):
        list(load_motion_corpus(corpus).examples([0, 1]))


def test_a_folder_that_was_not_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "dataset.json").write_text("{}", "utf-8")
    assert run(["corpus", "build", str(tmp_path), "-o", str(tmp_path / "out")]) == 2
    assert "is not an imported data set" in capsys.readouterr().err


@pytest.mark.parametrize(
    "place", ["../other/take_0.npy", "/etc/take_0.npy", "motion/../../take_0.npy", "c:a.npy", ""]
)
@pytest.mark.parametrize("what", ["motion", "audio"])
def test_files_elsewhere_are_refused(what: str, place: str, made: Made) -> None:
    folder, _ = made("facegood")
    corpus = built(folder, "facegood")
    document = json.loads((corpus / "corpus.json").read_text("utf-8"))
    document["clips"][0][what] = place
    (corpus / "corpus.json").write_text(json.dumps(document), "utf-8")
    with pytest.raises(CorpusError, match=f"{what} is .*; it is the path of a file below this folder"):
        load_motion_corpus(corpus)


def test_a_corpus_elsewhere_has_its_files_with_it(made: Made, tmp_path: Path) -> None:
    """So that it may be moved, and names no file outside."""
    folder, _ = made("facegood")
    imported = built(folder, "facegood")
    assert run(["corpus", "build", str(imported), "-o", str(tmp_path / "a"), "--language", "english"]) == 0
    (tmp_path / "a").rename(tmp_path / "b")
    corpus, first = load_motion_corpus(tmp_path / "b"), load_motion_corpus(imported)
    for number, clip in enumerate(corpus.clips):
        assert clip.motion.is_relative_to(tmp_path / "b")
        np.testing.assert_array_equal(corpus.frames(number), first.frames(number))
