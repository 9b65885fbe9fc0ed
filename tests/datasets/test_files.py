"""The files of data sets: pickles, EST tracks, MATLAB files, arrays and lists."""

import os
import pickle

import dataset_samples as samples
import numpy as np
import pytest

from phonanim.core.mat import read_signals
from phonanim.datasets import load_dataset
from phonanim.datasets._est import read_est, sensors
from phonanim.datasets._files import frames_of, load_array, read_list
from phonanim.datasets._pickles import read_pickle
from phonanim.errors import CorpusError, MissingExtraError


class Call:
    def __reduce__(self):
        return print, ("this must not be printed",)


def test_pickles_run_nothing(tmp_path, capsys):
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(Call()))
    with pytest.raises(CorpusError, match=r"a\.pkl: cannot be read as a pickle of arrays: it tries to run"):
        read_pickle(tmp_path / "a.pkl")
    assert capsys.readouterr().out == ""
    for protocol in (0, 2, 5):
        kept = {"a": np.arange(3.0), "b": [np.float32(1), "ä"]}
        (tmp_path / "a.pkl").write_bytes(pickle.dumps(kept, protocol=protocol))
        np.testing.assert_array_equal(read_pickle(tmp_path / "a.pkl")["a"], kept["a"])


def test_tracks_that_cannot_be_read(tmp_path):
    path = tmp_path / "a.ema"
    with pytest.raises(CorpusError, match=r"a\.ema: cannot be read: No such file"):
        read_est(path)
    path.write_bytes(b"RIFF")
    with pytest.raises(
        CorpusError, match=r"a\.ema: is not an EST track; its first line is not 'EST_File Track'"
    ):
        read_est(path)
    whole = samples.est(["a", "b"], samples.numbers(5, 2), 100)
    path.write_bytes(whole[:-16])
    with pytest.raises(CorpusError, match=r"a\.ema: is damaged \(4 frames of 5\); fetch it again"):
        read_est(path)
    path.write_bytes(samples.est(["a", "b"], samples.numbers(5, 2), np.inf))
    with pytest.raises(CorpusError, match=r"a\.ema: is damaged \(its times do not increase\)"):
        read_est(path)
    path.write_bytes(whole)
    with pytest.raises(CorpusError, match=r"a\.ema: has none of the channels x; it has a, b"):
        sensors(path, {"X": ("x",)}, 1.0)


def test_matlab_files_that_cannot_be_used(tmp_path, monkeypatch):
    savemat = pytest.importorskip("scipy.io", reason="needs the extra train").savemat
    path = tmp_path / "F01_B01_S01_R01_N.mat"
    path.write_bytes(b"none")
    (recording,) = load_dataset("hprc").recordings(tmp_path)
    with pytest.raises(CorpusError, match=r"R01_N\.mat: is not a MATLAB file of named signals"):
        recording.frames()
    savemat(path, {"a": samples.structures([samples.signal("TT", 100, np.zeros((5, 6)), [])] * 2)})
    with pytest.raises(CorpusError, match=r"R01_N\.mat: has no element AUDIO; it has TT"):
        recording.sound()
    read_signals.cache_clear()
    savemat(path, {"a": samples.structures([samples.signal("AUDIO", 100, np.zeros((5, 1)), [])] * 2)})
    with pytest.raises(CorpusError, match=r"R01_N\.mat: has no sensors with SRATE and SIGNAL"):
        recording.frames()
    read_signals.cache_clear()
    monkeypatch.setitem(__import__("sys").modules, "scipy.io", None)
    with pytest.raises(MissingExtraError, match=r"MATLAB files need SciPy: pip install 'phonanim\[train\]'"):
        recording.frames()


def test_matlab_files_that_are_pipes_or_unpack_to_too_much(tmp_path, monkeypatch):
    savemat = pytest.importorskip("scipy.io", reason="needs the extra train").savemat
    path = tmp_path / "F01_B01_S01_R01_N.mat"
    savemat(
        path,
        {"a": samples.structures([samples.signal("TT", 100, np.zeros((99, 99)), [])] * 2)},
        do_compression=True,
    )
    (recording,) = load_dataset("hprc").recordings(tmp_path)
    assert recording.frames().values.shape == (99, 1, 3)
    read_signals.cache_clear()
    monkeypatch.setattr("phonanim.core.mat.MAX_UNPACKED", 5000)
    with pytest.raises(CorpusError, match=r"N\.mat: is not a MATLAB file .*unpacks to too much"):
        recording.frames()
    path.unlink()
    if hasattr(os, "mkfifo"):
        os.mkfifo(path)
        with pytest.raises(CorpusError, match=r"N\.mat: is not a MATLAB file .*a pipe or a device"):
            recording.frames()


def test_arrays_and_lists_that_cannot_be_read(tmp_path):
    np.save(tmp_path / "a.npy", np.array([{}]))
    with pytest.raises(CorpusError, match=r"a\.npy: cannot be read as an array of numbers: its array"):
        load_array(tmp_path / "a.npy")
    np.save(tmp_path / "a.npy", np.zeros((4, 5)))
    with pytest.raises(CorpusError, match=r"shape \(4, 5\); frames need a multiple of 3 numbers each"):
        frames_of(tmp_path / "a.npy", 25, 3)
    with pytest.raises(CorpusError, match=r"shape \(4, 5\); frames need 2 numbers each"):
        frames_of(tmp_path / "a.npy", 25, 1, ("x", "y"))
    with pytest.raises(CorpusError, match=r"a\.lst: cannot be read as a list of names: .*No such file"):
        read_list(tmp_path / "a.lst")
