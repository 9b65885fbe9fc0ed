"""Documents of training, comparison, studies and evaluation: one line says what is wrong."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from phonanim.comparison.legibility import read_legibility
from phonanim.comparison.plan import read_plan
from phonanim.comparison.report import read_document
from phonanim.comparison.tools import read_tools
from phonanim.corpus.corpus import load_corpus, read_clips
from phonanim.errors import CorpusError, PhonanimError
from phonanim.evaluation.predictions import read_motion
from phonanim.face.masks import read_mask, read_masks
from phonanim.speech.language_files import _read_language, load_language
from phonanim.study.results import read_results
from phonanim.study.takes import read_takes
from phonanim.study.tally import read_counts
from phonanim.training.recipe import read_recipe

DEEP = "[" * 100_000
CONTENTS = {
    "deep": DEEP.encode(),
    "deep value": b'{"a": ' + DEEP.encode(),
    "not finite": b'{"a": NaN}',
    "no text": b"\xff\xfe\x00",
    "half a character": b'{"a": "\\ud800"}',
    "nothing": b"",
    "a number": b"3",
    "a list": b"[1, [2]]",
    "a table": b'{"a": 1}',
    "large": b"1" * 10_000,
}


def language(path: Path) -> object:
    _read_language.cache_clear()
    load_language.cache_clear()
    return load_language("mine")


READERS = {
    "own/languages/mine.toml": language,
    "recipe.toml": read_recipe,
    "plan.toml": read_plan,
    "corpus/corpus.json": lambda path: load_corpus(path.parent),
    "recordings/clips.csv": lambda path: read_clips(path.parent),
    "answers.json": lambda path: read_results([path]),
    "counts.csv": read_counts,
    "takes.csv": lambda path: read_takes([path]),
    "masks.json": read_masks,
    "mask.txt": read_mask,
    "mask.npy": read_mask,
    "motion.npy": read_motion,
    "tools.json": read_tools,
    "legibility.json": read_legibility,
    "models/sums.json": lambda path: read_document(path.parent),
}


@pytest.mark.parametrize("content", CONTENTS)
@pytest.mark.parametrize("name", READERS)
def test_one_line_says_what_is_wrong(tmp_path, monkeypatch, name, content):
    monkeypatch.setenv("PHONANIM_PATH", str(tmp_path / "own"))
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(CONTENTS[content])
    (tmp_path / "corpus").mkdir(exist_ok=True)
    save_file({"landmarks": np.zeros((0, 1, 3), "f4")}, tmp_path / "corpus/landmarks.safetensors")
    try:
        READERS[name](path)
    except PhonanimError as error:
        told = str(error)
        assert "\n" not in told
        assert len(told) < 600
        assert Path(name).parts[0] in told
    else:
        assert (name, content) in {("mask.txt", "a number"), ("masks.json", "a table")}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
@pytest.mark.parametrize(
    "name",
    ["recipe.toml", "answers.json", "counts.csv", "masks.json", "mask.npy", "motion.npy", "tools.json"],
)
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(PhonanimError, match=r"pipe or a device"):
        READERS[name](tmp_path / name)


CLIP = {"clip": "a", "frames": 2, "split": "train", "audio": "a.wav", "words": [["so", 0.0, 0.1]]}
CLIP |= {"codes": [0, 1], "bounds": [0.0, 0.05, 0.08], "labels": ["", "DH"]}
CORPUS = {"fps": 25.0, "provenance": {}, "clips": [CLIP]}


def write_corpus(folder: Path, corpus: object, landmarks: object = None) -> Path:
    (folder / "corpus.json").write_text(json.dumps(corpus))
    points = np.zeros((2, 1, 3), "f4") if landmarks is None else landmarks
    save_file({"landmarks": points, "indices": np.zeros(1, np.int64)}, folder / "landmarks.safetensors")
    return folder


def test_a_sound_corpus(tmp_path):
    corpus = load_corpus(write_corpus(tmp_path, CORPUS))
    assert corpus.clips == ("a",)
    assert corpus.tracks[0].codes.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frames": -1}, "frames is -1; it is a whole number from 0 to 2"),
        ({"frames": 1}, r"it has landmarks of \(2, 1, 3\) for 1 frames"),
        ({"codes": [0, 99]}, "a phone is 99; it is a whole number from 0 to 40"),
        ({"bounds": [0.0, 1e300, 2e300]}, "a bound is 1e\\+300"),
        ({"bounds": [0.0, 0.05, 0.05]}, "its phones do not follow each other"),
        ({"labels": [""]}, "its phones do not follow each other"),
        ({"words": [["so", "0", 0.1]]}, "start is '0'; it is a number"),
        ({"words": [[1]]}, "not enough values to unpack"),
        ({"audio": 3}, "audio is 3; it is a text"),
    ],
)
def test_clips_of_wrong_values(tmp_path, changes, message):
    with pytest.raises(CorpusError, match=message):
        load_corpus(write_corpus(tmp_path, {**CORPUS, "clips": [{**CLIP, **changes}]}))


def test_landmarks_that_are_not_finite(tmp_path):
    with pytest.raises(CorpusError, match="landmarks that are not finite"):
        load_corpus(write_corpus(tmp_path, CORPUS, np.full((2, 1, 3), np.nan, "f4")))


@pytest.mark.parametrize("row", ["a,many,train", "a,-3,train", ",3,train", "a,3"])
def test_a_row_of_clips_of_wrong_values(tmp_path, row):
    (tmp_path / "clips.csv").write_text(f"clip,frames,split\nb,3,test\n{row}\n")
    with pytest.raises(CorpusError, match=r"clips.csv row 3: needs a clip, a number of frames and a split"):
        read_clips(tmp_path)
