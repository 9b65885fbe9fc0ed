"""Files of sensors in the layouts of SSFF, Carstens and MATLAB."""

from __future__ import annotations

import builtins
import json
from pathlib import Path
from typing import Any

import ema_samples as samples
import numpy as np
import pytest

from phonanim.core.mat import read_signals
from phonanim.ema import Articulation, load_utterances
from phonanim.ema.articulation import orient_axes, rename_sensors, sensor_label, standard_name
from phonanim.ema.readers import read_articulation
from phonanim.ema.readers.ssff import read_ssff
from phonanim.ema.utterances import find_spoken
from phonanim.errors import CorpusError, MissingExtraError, OptionError

ROWS = np.arange(1, 13, dtype=float).reshape(4, 3)


def test_ssff_files_of_one_stem_are_one_recording(tmp_path: Path) -> None:
    lost = np.where(np.arange(4)[:, None] < 3, ROWS, 0)
    columns = samples.sensor_columns("tt", lost)
    samples.ssff(tmp_path / "a.t_tip", {name: column * (lost[:, 0] > 0) for name, column in columns.items()})
    samples.ssff(tmp_path / "a.jaw", samples.sensor_columns("jw", ROWS + 100), start=0.0)
    samples.ssff(tmp_path / "a.fms", {"fm": np.ones(9)}, rate=100)
    samples.ssff(tmp_path / "b.jaw", samples.sensor_columns("jw", ROWS))
    found = read_articulation(tmp_path / "a.fms")
    assert found.names == ("jaw", "t_tip")
    assert (found.rate, found.start) == (200.0, 0.0)
    np.testing.assert_array_equal(found.sensor("LI"), ROWS + 100)
    np.testing.assert_array_equal(found.sensor("TT")[:3], ROWS[:3])
    assert np.isnan(found.sensor("TT")[3]).all()
    np.testing.assert_allclose(found.times, [0, 0.005, 0.01, 0.015])


def test_ssff_columns_of_other_types_and_order(tmp_path: Path) -> None:
    path = tmp_path / "a.fms"
    head = "SSFF -- (c) SHLRC\r\nMachine SPARC\r\nRecord_Freq 100\r\nStart_Time 0.5\r\n"
    table = np.array([((1, 2), 0.5), ((3, 4), 1.5)], [("fm", ">i2", 2), ("x", ">f8")])
    path.write_bytes(
        f"{head}Column fm SHORT 2\r\nColumn x DOUBLE 1\r\n{'-' * 17}\r\n".encode() + table.tobytes()
    )
    found = read_ssff(path)
    assert (found.rate, found.start) == (100.0, 0.5)
    np.testing.assert_array_equal(found.values["fm"], [[1, 2], [3, 4]])
    np.testing.assert_array_equal(found.values["x"], [[0.5], [1.5]])


def test_ssff_files_that_cannot_be_used(tmp_path: Path) -> None:
    path = tmp_path / "a.fms"
    samples.ssff(path, {"fm": np.ones(3)})
    with pytest.raises(CorpusError, match=r"a\.fms: has no columns that end in _posx, _posy, _posz"):
        read_articulation(path)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(CorpusError, match=r"a\.fms: is damaged \(its rows are not whole\); fetch it again"):
        read_ssff(path)
    samples.ssff(tmp_path / "b.jaw", samples.sensor_columns("jw", ROWS))
    samples.ssff(tmp_path / "b.tip", samples.sensor_columns("tt", ROWS), rate=100)
    with pytest.raises(
        CorpusError, match=r"b\.jaw: its sensors differ in length or rate; cut them to the same"
    ):
        read_articulation(tmp_path / "b.jaw")


@pytest.mark.parametrize("header", [True, False], ids=["AG501", "AG500"])
def test_carstens_positions(tmp_path: Path, header: bool) -> None:
    positions = np.arange(1, 3 * 12 * 3 + 1, dtype=float).reshape(3, 12, 3)
    positions[1, 4] = 0
    path = tmp_path / "0001.pos"
    samples.pos(path, positions, 250, header)
    found = read_articulation(path)
    assert found.names == tuple(str(number) for number in range(1, 13))
    assert found.rate == (250 if header else 200)
    assert np.isnan(found.positions[1, 4]).all()
    positions[1, 4] = np.nan
    np.testing.assert_array_equal(found.positions, positions)


def test_carstens_files_that_are_damaged(tmp_path: Path) -> None:
    path = tmp_path / "a.pos"
    samples.pos(path, np.ones((2, 3, 3)))
    whole = path.read_bytes()
    path.write_bytes(whole[:-4])
    with pytest.raises(CorpusError, match=r"a\.pos: is truncated: 164 bytes are not whole samples of 84"):
        read_articulation(path)
    path.write_bytes(whole.replace(b"NumberOf", b"Number"))
    with pytest.raises(CorpusError, match=r"a\.pos: its header is damaged \('NumberOfChannels'\); fetch"):
        read_articulation(path)
    path.write_bytes(whole.replace(b"0000006", b"-000006", 1))
    with pytest.raises(CorpusError, match=r"a\.pos: its header is damaged"):
        read_articulation(path)
    path.write_bytes(whole.replace(b"Hz=250", b"Hz=000"))
    with pytest.raises(CorpusError, match=r"a\.pos: its header is damaged \(3 channels at 0 Hz\)"):
        read_articulation(path)


def test_matlab_signals_with_three_columns_are_sensors(tmp_path: Path) -> None:
    savemat = pytest.importorskip("scipy.io", reason="needs the extra train").savemat
    path = tmp_path / "F01.mat"
    savemat(path, {"F01": _structures([("AUDIO", 44100.0, np.ones((9, 1))), ("TT", 100.0, np.ones((4, 6)))])})
    found = read_articulation(path)
    assert (found.names, found.rate, found.positions.shape) == (("TT",), 100.0, (4, 1, 3))
    read_signals.cache_clear()
    savemat(path, {"F01": _structures([("TB", 100.0, np.ones((4, 6))), ("TT", 50.0, np.ones((4, 6)))])})
    with pytest.raises(CorpusError, match=r"F01\.mat: has no sensors with SRATE and SIGNAL of one rate"):
        read_articulation(path)


def _structures(signals: list[tuple[str, float, Any]]) -> Any:
    found = np.zeros(len(signals), [("NAME", object), ("SRATE", object), ("SIGNAL", object)])
    for place, signal in enumerate(signals):
        found[place] = signal
    return found


def test_matlab_files_without_scipy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    imported = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.startswith("scipy"):
            raise ImportError(name)
        return imported(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    (tmp_path / "a.mat").write_bytes(b"")
    with pytest.raises(MissingExtraError, match=r"MATLAB files need SciPy: pip install 'phonanim\[train\]'"):
        read_articulation(tmp_path / "a.mat")


def test_files_of_no_format(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    with pytest.raises(CorpusError, match=r"a\.txt: cannot be read: No such file"):
        read_articulation(path)
    path.write_text("hello")
    with pytest.raises(
        CorpusError, match=r"a\.txt: is not a file of sensors; known formats are mat, pos, ssff"
    ):
        read_articulation(path)


def test_sensors_go_by_their_own_name_or_the_standard_one() -> None:
    found = samples.still((1, 2, 3), (4, 5, 6), names="t_tip jaw")
    assert [standard_name(name) for name in ("t_tip", "JAW", "mine")] == ["TT", "LI", "mine"]
    assert [sensor_label(name) for name in ("t_tip", "mine")] == ["TT, tongue tip", "mine"]
    assert found.has("TT", "LI", "jaw")
    assert not found.has("TT", "TB")
    np.testing.assert_array_equal(found.sensor("TT")[0], [1, 2, 3])
    with pytest.raises(CorpusError, match="made up: has no sensor TB; it has t_tip, jaw"):
        found.sensor("TB")


def test_channels_are_named_and_axes_turned() -> None:
    found = rename_sensors(samples.still((1, 2, 3), (4, 5, 6), names="1 2"), ("-", "TT"))
    assert found.names == ("TT",)
    np.testing.assert_array_equal(orient_axes(found, "left,back,up").positions[0, 0], [-5, 4, 6])
    with pytest.raises(OptionError, match="2 names for the 1 sensors of made up; give one for each, - for"):
        rename_sensors(found, ("a", "b"))
    with pytest.raises(OptionError, match="TT names two sensors of made up; give each another"):
        rename_sensors(samples.still((1, 2, 3), (4, 5, 6), names="1 2"), ("TT", "TT"))
    for axes in ("left,back", "left,back,forward", "left,back,up,sideways"):
        with pytest.raises(
            OptionError, match=f"'{axes}': give the directions of x, y and z, as left,back,up or"
        ):
            orient_axes(found, axes)


def test_folders_of_positions_want_alignments(tmp_path: Path) -> None:
    samples.pos(tmp_path / "0002.pos", np.ones((2, 3, 3)))
    samples.pos(tmp_path / "0001.pos", np.ones((2, 3, 3)))
    samples.textgrid(tmp_path / "0001.TextGrid", (0, 0.1, "sil"), (0.1, 0.2, "m"))
    first, second = find_spoken(tmp_path)
    assert (first.name, second.name) == ("0001", "0002")
    assert [interval.label for interval in first.alignment().intervals] == ["sil", "m"]
    assert first.sensors().rate == 250
    with pytest.raises(CorpusError, match=r"0002\.pos: has no alignment next to it; add 0002\.TextGrid"):
        second.alignment()


def test_imported_data_sets_are_read(tmp_path: Path) -> None:
    for part in ("motion", "textgrid"):
        (tmp_path / part).mkdir()
    np.save(tmp_path / "motion" / "a.npy", np.array([[[1, 2]], [[3, 4]]], np.float32))
    samples.textgrid(tmp_path / "textgrid" / "a.TextGrid", (0, 0.2, "m"))
    facts = {"kind": "sensors", "names": ["TT"], "fps": 500.0}
    (tmp_path / "dataset.json").write_text(json.dumps(facts))
    (spoken,) = find_spoken(tmp_path)
    np.testing.assert_array_equal(spoken.sensors().positions[:, 0], [[1, 0, 2], [3, 0, 4]])
    assert len(spoken.alignment().intervals) == 1
    (tmp_path / "dataset.json").write_text(json.dumps({**facts, "kind": "vertices"}))
    with pytest.raises(CorpusError, match="has vertices and no sensors; mngu0, mocha, hprc have some"):
        find_spoken(tmp_path)
    (tmp_path / "dataset.json").write_text("{}")
    with pytest.raises(
        CorpusError, match=r"dataset\.json: is damaged \(KeyError\('kind'\)\); import the data"
    ):
        find_spoken(tmp_path)


def test_imported_arrays_that_cannot_be_used(tmp_path: Path) -> None:
    (tmp_path / "motion").mkdir()
    (tmp_path / "dataset.json").write_text(json.dumps({"kind": "sensors", "names": ["TT"], "fps": 500.0}))
    np.save(tmp_path / "motion" / "a.npy", np.ones((2, 1, 4)))
    (spoken,) = find_spoken(tmp_path)
    with pytest.raises(
        CorpusError, match=r"a\.npy: is \(2, 1, 4\); sensors are \(samples, sensors, 2 or 3\)"
    ):
        spoken.sensors()
    (tmp_path / "motion" / "a.npy").write_bytes(b"none")
    with pytest.raises(CorpusError, match=r"a\.npy: is not an array \(.*\); import the data set again"):
        spoken.sensors()


def test_folders_without_sensors(tmp_path: Path) -> None:
    with pytest.raises(CorpusError, match=r"has no articulography; looked for dataset\.json, \*_bndl\.json"):
        find_spoken(tmp_path)
    (tmp_path / "a_bndl.json").write_text("{}")
    with pytest.raises(CorpusError, match=r"a: has no SSFF files next to a_bndl\.json; put them there"):
        find_spoken(tmp_path)[0].sensors()


def test_the_german_utterances(shared_data: Path) -> None:
    first, second = load_utterances(shared_data / "ema_de")
    assert set(first.articulation.names) == {"upper_lip", "lower_lip", "jaw", "t_tip", "t_mid", "t_back"}
    assert (first.fps, len(first.times)) == (200.0, 800)
    assert (first.speech.sum(), second.speech.sum()) == (383, 478)
    tip, middle, back = (
        first.articulation.sensor(name)[first.speech, 0].mean() for name in ("TT", "TB", "TD")
    )
    assert tip > middle > back  # forward
    assert first.aperture[first.speech].min() > 10
    assert isinstance(first.articulation, Articulation)
