"""A data set of others is brought into the layout of a corpus."""

import csv
import json
import os
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.corpus.importing import import_dataset, write_templates
from phonanim.corpus.motion import load_motion_corpus
from phonanim.corpus.motion_build import build_motion_corpus, imported_templates
from phonanim.datasets import dataset_names
from phonanim.errors import CorpusError, OutputError
from phonanim.media.audio import Sound, read_sound


@pytest.mark.parametrize("part", ["motion", "audio", "textgrid"])
def test_an_import_does_not_write_through_a_link(made, tmp_path, part):
    folder, _ = made("mngu0")
    for name in ("out", "elsewhere"):
        (tmp_path / name).mkdir()
    (tmp_path / "out" / part).symlink_to("../elsewhere")
    with pytest.raises(
        OutputError, match=rf"{part}: a link points outside the output folder; remove the link"
    ):
        import_dataset("mngu0", folder, tmp_path / "out", 2)
    assert not list((tmp_path / "elsewhere").iterdir())


def test_import_brings_a_data_set_into_one_layout(made, tmp_path):
    folder, _ = made("mngu0")
    done = []
    rows = import_dataset("mngu0", folder, tmp_path / "out", 2, progress=done.append)
    assert done[-1] == 1
    with (tmp_path / "out" / "recordings.csv").open() as stream:
        table = list(csv.DictReader(stream))
    assert [row["split"] for row in table] == ["train", "validation", "test", ""]
    assert (table[0]["frames"], table[0]["fps"], table[0]["seconds"]) == ("3", "100.0", "0.2")
    assert np.load(tmp_path / "out/motion/mngu0_s1_0001.npy").shape == (3, 6, 3)
    facts = json.loads((tmp_path / "out" / "dataset.json").read_text())
    assert facts["names"][0] == "TT"
    assert (facts["fps"], facts["unit"]) == (100, "mm")
    kept = read_sound(tmp_path / "out/audio/mngu0_s1_0001.wav")
    given = read_sound(folder / "mngu0_s1_wav_16kHz_1.1.0/mngu0_s1_0001.wav")
    np.testing.assert_allclose(kept.samples, given.samples, atol=2 / 32768)
    assert (tmp_path / "out/textgrid/mngu0_s1_0001.TextGrid").is_file()
    assert len(rows) == 4


def test_import_of_what_is_not_there(made, tmp_path):
    folder, _ = made("mngu0")
    with pytest.raises(CorpusError, match="mngu0: has no recordings of the split test_b"):
        import_dataset("mngu0", folder, tmp_path / "out", splits=["test_b"])
    assert not (tmp_path / "out").exists()


def test_names_cannot_leave_the_folder(made, tmp_path):
    folder, _ = made("vocaset")
    index = pickle.loads((folder / "subj_seq_to_idx.pkl").read_bytes())
    rows = next(iter(index.values()))["sentence21"]
    (folder / "subj_seq_to_idx.pkl").write_bytes(pickle.dumps({"..": {"/../a21": rows}}))
    with pytest.raises(
        CorpusError, match=r"'\.\._/\.\./a21': is not a valid file name; the data set is damaged"
    ):
        import_dataset("vocaset", folder, tmp_path / "out")


def test_the_name_of_a_clip_cannot_leave_a_folder(made, tmp_path):
    folder, _ = made("facegood")
    assert (
        run(["corpus", "build", str(folder), "--dataset", "facegood", "-o", str(tmp_path / "c"), "-q"]) == 0
    )
    index, table = tmp_path / "c/corpus.json", tmp_path / "c/recordings.csv"
    for name in ("../take_0", "/take_0", ".."):
        tree = json.loads(index.read_text())
        tree["clips"][0]["clip"] = name
        index.write_text(json.dumps(tree))
        with pytest.raises(CorpusError, match=r"clip is '.*take_0'|clip is '\.\.'"):
            load_motion_corpus(tmp_path / "c")
        table.write_text(re.sub("^.*take_0", name, table.read_text(), flags=re.M))
        with pytest.raises(CorpusError, match=r"recordings\.csv row 2: name is"):
            build_motion_corpus(tmp_path / "c", tmp_path / "d")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_motion_that_is_a_pipe_or_something_else_is_one_line(made, tmp_path):
    folder, _ = made("facegood")
    assert (
        run(["corpus", "build", str(folder), "--dataset", "facegood", "-o", str(tmp_path / "c"), "-q"]) == 0
    )
    corpus = load_motion_corpus(tmp_path / "c")
    path = corpus.clips[0].motion
    for content, told in ((b"PK\x03\x04", "cannot be read"), (None, "a pipe or a device")):
        path.unlink()
        path.write_bytes(content) if content else os.mkfifo(path)
        with pytest.raises(CorpusError, match=told):
            corpus.frames(0)


@pytest.mark.parametrize("part", ["frames", "sound", "phones", "rate"])
def test_what_a_data_set_has_wrongly_is_one_line(made, tmp_path, part, monkeypatch):
    def damaged():
        raise KeyError("SIGNAL")

    folder, recordings = made("mngu0")
    wrong = {"sound": lambda: Sound(np.zeros(3, np.float32), 0)} if part == "rate" else {part: damaged}
    one = replace(recordings[0], **wrong)
    monkeypatch.setattr("phonanim.datasets.mngu0.recordings", lambda folder: [one])
    with pytest.raises(CorpusError, match=rf"mngu0: {one.name}: is damaged \((KeyError|DecodeError): "):
        import_dataset("mngu0", folder, tmp_path / "out")


def test_faces_at_rest_come_with_the_data_set_and_into_the_corpus(made, tmp_path):
    folder, _ = made("vocaset")
    rest = np.random.default_rng(3).normal(size=(5023, 3))
    index = pickle.loads((folder / "subj_seq_to_idx.pkl").read_bytes())
    (folder / "templates.pkl").write_bytes(pickle.dumps(dict.fromkeys(index, rest)))
    import_dataset("vocaset", folder, tmp_path / "out")
    assert {path.stem for path in (tmp_path / "out/templates").iterdir()} == set(index)
    known = imported_templates(tmp_path / "out")
    np.testing.assert_allclose(next(iter(known.values())), 1000 * rest, rtol=1e-5)


def test_the_name_of_a_face_at_rest_cannot_leave_the_folder(tmp_path):
    class Faces:
        @staticmethod
        def templates(folder):
            return {"../a": np.zeros((1, 3))}

    with pytest.raises(CorpusError, match=r"'\.\./a': is not a valid file name; the data set is damaged"):
        write_templates(Faces, tmp_path, tmp_path / "out")


def test_the_commands(made, tmp_path, capsys):
    folder, _ = made("mngu0")
    assert run(["corpus", "datasets", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)) == set(dataset_names())
    assert run(["corpus", "datasets", "mngu0"]) == 0
    assert "split    the file sets of the corpus" in capsys.readouterr().out
    arguments = ["corpus", "import", "mngu0", str(folder), "-o", str(tmp_path / "out")]
    assert run([*arguments, "--split", "test", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["splits"] == {"test": 1}
    assert run(["corpus", "import", "biwi", str(folder), "-o", str(tmp_path / "out")]) == 2
    assert "is not laid out as BIWI; looked for faces/" in capsys.readouterr().err
