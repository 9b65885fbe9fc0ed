import json
import pickle
from collections import Counter

import dataset_samples as samples
import numpy as np
import pytest

from phonanim.datasets import KINDS, SPLITS, Frames, Recording, dataset_names, load_dataset
from phonanim.datasets import _splits as splits
from phonanim.datasets._splits import EIGHTY_TEN_TEN, cut_pieces, draw_splits
from phonanim.errors import CorpusError, OptionError
from phonanim.speech.alignment import Interval

NAMES = dataset_names()


def split_counts(recordings):
    return Counter(recording.split for recording in recordings)


def by_name(recordings):
    return {recording.name: recording for recording in recordings}


@pytest.mark.parametrize("name", NAMES)
def test_every_data_set_keeps_the_contract(name, made):
    folder, recordings = made(name)
    names = [recording.name for recording in recordings]
    assert names == sorted(set(names))
    assert {recording.split for recording in recordings} <= set(SPLITS)
    kind = load_dataset(name).CARD.kind
    assert kind in KINDS
    frames = recordings[0].frames()
    assert frames.values.dtype == np.float32
    assert frames.values.ndim == (2 if kind == "controls" else 3)
    assert len(frames.names) in (0, frames.values.shape[1])
    assert frames.unit == {"controls": ""}.get(kind, frames.unit)
    assert 20 < frames.fps < 600
    assert recordings[0].sound().samples.dtype == np.float32
    again = list(load_dataset(name).recordings(folder))
    assert [(one.name, one.split) for one in again] == [(one.name, one.split) for one in recordings]


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_that_is_laid_out_otherwise(name, tmp_path):
    told = rf"{tmp_path}: is not laid out as .+; looked for "
    with pytest.raises(CorpusError, match=told):
        list(load_dataset(name).recordings(tmp_path))


@pytest.mark.parametrize("name", NAMES)
def test_the_page_has_the_facts_of_the_card(name, root):
    page = " ".join((root / "docs" / "datasets.md").read_text("utf-8").split())
    card = load_dataset(name).CARD
    fields = (card.title, card.content, card.licence, card.ask, card.layout, card.split, card.source)
    for fact in (*fields, card.assumed):
        assert fact.replace("|", "\\|") in page, fact
    assert f"`{name}`" in page


def test_there_is_no_other_data_set():
    with pytest.raises(OptionError, match="there is no data set 'grid'; there are beat, biwi, face"):
        load_dataset("grid")


def test_biwi_splits_what_is_said_with_emotion(made):
    _, recordings = made("biwi")
    found = {one.name: one.split for one in recordings}
    assert found == {
        "F1_01": "", "F1_e01": "", "F1_e33": "", "F1_e40": "test_b",
        "F2_01": "", "F2_e01": "train", "F2_e33": "validation", "F2_e40": "test",
    }  # fmt: skip
    frames = recordings[0].frames()
    np.testing.assert_array_equal(frames.values[2], samples.numbers(4, 3, seed=10))


def test_the_prepared_layout_is_read_as_well(tmp_path):
    for name, speaker in (
        ("biwi", "F2_e05"),
        ("biwi", "F2_45"),
        ("vocaset", "FaceTalk_170731_00024_TA_sentence40"),
    ):
        samples.array(tmp_path / name / "vertices_npy" / f"{speaker}.npy", samples.numbers(3, 12))
    biwi = list(load_dataset("biwi").recordings(tmp_path / "biwi"))
    assert [(one.name, one.speaker, one.split) for one in biwi] == [
        ("F2_45", "F2", "train"), ("F2_e05", "F2", "train"),
    ]  # fmt: skip
    assert biwi[0].sound is None
    (vocaset,) = load_dataset("vocaset").recordings(tmp_path / "vocaset")
    assert (vocaset.speaker, vocaset.split) == ("FaceTalk_170731_00024_TA", "test")
    assert vocaset.frames().values.shape == (3, 4, 3)


def test_damaged_meshes(made, tmp_path):
    folder, recordings = made("biwi")
    (folder / "faces/F1/01/frame_2.vl").write_bytes(np.uint32(4).tobytes())
    with pytest.raises(
        CorpusError, match=r"frame_2\.vl: has 4 bytes, which is not a count and as many vertices"
    ):
        recordings[0].frames()
    (folder / "faces/F1/01/frame_2.vl").write_bytes(np.uint32(1).tobytes() + bytes(12))
    with pytest.raises(CorpusError, match="F1/01: its frames have different numbers of vertices"):
        recordings[0].frames()


def test_vocaset_takes_the_rows_of_the_index(made):
    folder, recordings = made("vocaset")
    assert split_counts(recordings) == {"train": 2, "validation": 1, "test": 1, "": 2}
    found = by_name(recordings)["FaceTalk_170728_03272_TA_sentence21"]
    rows = np.load(folder / "data_verts.npy")[3:6]
    np.testing.assert_allclose(found.frames().values, rows * 1000, rtol=1e-6)
    sound = found.sound()
    assert (sound.rate, sound.samples[1]) == (22000, np.float32(100 / 32768))


def test_damaged_vocaset(made):
    folder, recordings = made("vocaset")
    (folder / "raw_audio_fixed.pkl").write_bytes(pickle.dumps({}))
    load_dataset("vocaset")._sounds.cache_clear()
    with pytest.raises(
        CorpusError, match=r"raw_audio_fixed\.pkl: has no recording of FaceTalk_\S+ sentence20"
    ):
        recordings[0].sound()
    (folder / "subj_seq_to_idx.pkl").write_bytes(pickle.dumps([1]))
    with pytest.raises(
        CorpusError, match=r"to_idx\.pkl: is not an index of rows by speaker and sentence \('list'"
    ):
        list(load_dataset("vocaset").recordings(folder))
    samples.array(folder / "data_verts.npy", samples.numbers(1, 5, 3))
    with pytest.raises(CorpusError, match=r"data_verts\.npy: does not have the frames of the index"):
        recordings[-1].frames()


def test_multiface_numbers_sentences_without_regard_to_case(made):
    _, recordings = made("multiface")
    counts = split_counts(recordings)
    assert counts == {"train": 9 * 40, "validation": 9 * 5, "test": 9 * 5, "test_b": 4 * 5, "": 4 * 45}
    first = by_name(recordings)["m--20180000--0000--0--GHS_SEN_A_00"]
    assert (first.split, first.text) == ("", "A 00")
    assert by_name(recordings)["m--20180000--0000--0--GHS_SEN_b_24"].split == "test_b"
    np.testing.assert_array_equal(first.frames().values, [[[1, 2, 3], [4, 5, 6]]])
    assert by_name(recordings)["m--20180001--0000--1--GHS_SEN_b_24"].split == "test"
    assert by_name(recordings)["m--20180001--0000--1--GHS_SEN_b_24"].sound is None


def test_multiface_without_all_sentences_has_no_split(tmp_path):
    samples.multiface(tmp_path, sentences=3)
    recordings = list(load_dataset("multiface").recordings(tmp_path))
    assert split_counts(recordings) == {"": 39}
    mesh = tmp_path / "m--20180001--0000--1--GHS/tracked_mesh/SEN_A_00"
    (mesh / "000102.bin").write_bytes(bytes(10))
    broken = by_name(recordings)["m--20180001--0000--1--GHS_SEN_A_00"]
    with pytest.raises(CorpusError, match=r"000102\.bin: has no vertices \(.+\); fetch it again"):
        broken.frames()
    (mesh / "000102.bin").unlink()
    with pytest.raises(CorpusError, match="SEN_A_00: has no frames, or frames of different sizes"):
        broken.frames()


def test_beat_is_cut_into_pieces(made):
    folder, recordings = made("beat")
    assert len(recordings) == 12
    second = by_name(recordings)["1_wayne_0_1_1_02"]
    assert second.frames().values.shape == (600, 2)
    assert second.frames().names == ("jawOpen", "mouthClose")
    assert second.sound().duration == 10
    assert [i.label for i in second.phones()] == ["m", "sil"]
    assert second.phones()[0].end == pytest.approx(0.2)
    assert {one.split for one in recordings if one.speaker == "wayne"} == {""}
    english = [one for one in recordings if one.name.startswith("2_scott_0")]
    assert all(one.split for one in english)
    assert load_dataset("beat").group_of("2_scott_0_65_65") == "2 happiness"
    assert load_dataset("beat").group_of("2_scott_0_119_119") == ""
    (folder / "2" / "2_scott_1_1_1.wav").unlink()
    with pytest.raises(CorpusError, match=r"2_scott_1_1_1\.wav: is missing; fetch the audio of BEAT too"):
        list(load_dataset("beat").recordings(folder))


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ({"names": []}, r"has no facial weights \(KeyError\('frames'\)\); fetch it again"),
        (
            {"names": ["a"], "frames": [{"weights": [1, 2], "time": 0}, {"weights": [1, 2], "time": 1}]},
            r"has frames of \(2,\) weights, but 1 names",
        ),
    ],
)
def test_damaged_weights(tmp_path, document, told):
    samples.text(tmp_path / "a.json", json.dumps(document))
    with pytest.raises(CorpusError, match=rf"a\.json: {told}"):
        load_dataset("beat").load(tmp_path / "a.json")


def test_uudamm_splits_both_speakers_alike(made):
    _, recordings = made("uudamm")
    found = {one.name: one.split for one in recordings}
    assert all(found[f"S1_{n}"] == found[f"S2_{n}"] for n in (1, 2, 3, 2537))
    assert found["S1_3000"] == ""
    split_of = load_dataset("uudamm").split_of
    counts = Counter(split_of("S1", str(number)) for number in range(1, 2538))
    assert counts == {"train": 2029, "validation": 254, "test": 254}


def test_lists_say_the_split(made):
    _, recordings = made("imt22")
    assert split_counts(recordings) == {"train": 2, "test": 1, "": 7}
    frames = recordings[3].frames()
    assert frames.names[:2] == ("TD", "TB")
    assert frames.values.shape == (6, 10, 3)
    assert recordings[3].phones()[1] == Interval("m", 0.1, 0.2)
    assert recordings[4].phones is None


def test_without_lists_the_split_is_drawn(made):
    _, recordings = made("imft23")
    assert split_counts(recordings) == {"train": 8, "test": 2}


def test_fifty_of_kb2k_are_held_out():
    cuts = (("train", 1 - load_dataset("kb2k").HELD_OUT), ("test", 1.0))
    found = draw_splits({str(number): "" for number in range(2543)}, cuts, np.random.default_rng(0))
    assert Counter(found.values()) == {"train": 2493, "test": 50}


def test_every_group_is_divided_in_the_same_parts():
    groups = {f"{group}{number}": group for group in "ab" for number in range(20)}
    found = draw_splits(groups, EIGHTY_TEN_TEN, np.random.default_rng(0))
    counts = Counter((groups[name], split) for name, split in found.items())
    parts = {"train": 16, "validation": 2, "test": 2}
    assert counts == {(group, split): part for group in "ab" for split, part in parts.items()}
    assert found != draw_splits(groups, EIGHTY_TEN_TEN, np.random.default_rng(1))


def test_pieces_without_sound_or_phones():
    whole = Recording("a", "s", "", lambda: Frames(np.zeros((25, 1), np.float32), 10.0))
    found = list(cut_pieces(whole, 2.5, 1.0))
    assert [one.name for one in found] == ["a_01", "a_02"]
    assert found[1].frames().values.shape == (10, 1)
    assert found[1].sound is None
    assert found[1].phones is None
    assert splits.EIGHTY_TWENTY[0] == ("train", 0.8)


def test_mngu0_has_the_file_sets_of_the_corpus(made):
    _, recordings = made("mngu0")
    assert [one.split for one in recordings] == ["train", "validation", "test", ""]
    frames = recordings[0].frames()
    assert frames.names == ("TT", "TB", "TD", "LI", "UL", "LL")
    assert frames.values.shape == (5, 6, 3)
    assert frames.fps == 200
    values = samples.numbers(5, 42, seed=1)
    np.testing.assert_allclose(frames.values[0, 0], 10 * values[0, 12:15], rtol=1e-6)
    assert np.isnan(frames.values[2]).all()
    assert recordings[0].phones()[-1] == Interval("m", 0.1, 0.2)


def test_mocha_is_read_as_text_and_binary(made):
    _, recordings = made("mocha")
    assert [one.split for one in recordings] == ["train", "test", "validation"] * 2
    binary, ascii_ = recordings[0].frames(), recordings[3].frames()
    np.testing.assert_allclose(binary.values, ascii_.values, rtol=1e-5)
    assert binary.values.shape == (5, 8, 2)
    assert binary.fps == ascii_.fps == 500
    np.testing.assert_allclose(binary.values[0, 1], 10 * samples.numbers(5, 16)[0, [1, 9]], rtol=1e-5)


def test_hprc_holds_sound_and_phones(made):
    _, recordings = made("hprc")
    first = recordings[0]
    assert (first.speaker, first.split) == ("F01", "")
    assert first.frames().names == ("TR", "TB", "TT", "UL", "LL", "JAW")
    np.testing.assert_allclose(first.frames().values[:, 0], samples.numbers(5, 6)[:, :3], rtol=1e-6)
    assert first.sound().rate == 44100
    assert first.phones() == (Interval("SIL", 0.0, 0.1), Interval("M", 0.1, 0.2))
