"""Sensors become channels: openings are positive, whichever way a file's axes point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from phonanim.ema import Articulation
from phonanim.ema.channels import load_recordings, sensor_channels
from phonanim.errors import CorpusError

TEXTGRID = """File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0
xmax = 1
tiers? <exists>
size = 1
item []:
    item [1]:
        class = "IntervalTier"
        name = "phones"
        xmin = 0
        xmax = 1
        intervals: size = 2
        intervals [1]:
            xmin = 0
            xmax = 0.5
            text = "sil"
        intervals [2]:
            xmin = 0.5
            xmax = 1
            text = "AA"
"""
NAMES = ("TT", "TR", "UL", "LL", "ML", "JAW")
REAL = Path(__file__).parent.parent.parent.parent / "shared" / "data"


def opening() -> np.ndarray:
    """Sensors, (100, 6, 3) mm, of a mouth that opens by 1 mm in each sample of jaw and lower lip."""
    places = np.zeros((100, len(NAMES), 3))
    places[:, [3, 5], 2] = -np.arange(100.0)[:, None]
    places[:, 2, 0], places[:, 4, 1] = 4.0, -25.0
    return places


def test_sensors_become_channels() -> None:
    found = sensor_channels(Articulation(NAMES, opening(), 100.0))
    assert found["lip_gap"] == pytest.approx(np.arange(100))
    assert found["jaw"] == pytest.approx(np.arange(100))
    assert (found["lip_width"] == 50).all()
    assert (found["protrusion"] == 2).all()
    assert "tongue_body_height" in found


def test_channels_need_lips() -> None:
    with pytest.raises(CorpusError, match="has no sensor UL; it has JAW"):
        sensor_channels(Articulation(("JAW",), np.zeros((1, 1, 3)), 100.0))


def test_what_a_file_lacks_is_left_out() -> None:
    found = sensor_channels(Articulation(("UL", "LL"), np.zeros((1, 2, 3)), 100.0))
    assert set(found) == {"lip_gap", "protrusion", "upper_lip"}


def test_arrays_in_millimetres_are_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", sensors=np.array(NAMES), xyz=opening(), hz=100)
    (tmp_path / "a.TextGrid").write_text(TEXTGRID)
    (one,) = load_recordings(tmp_path)
    assert (one.name, one.speaker, one.in_mm) == ("a", "a", True)
    assert not one.speech[:50].any()
    assert one.speech[50:].all()
    assert one.curves["jaw"][99] == 99


def test_standardized_columns_are_read(tmp_path: Path) -> None:
    table = np.zeros((100, 6))
    table[:, 3], table[:, 4] = -np.arange(100.0), 2.0
    columns = np.array(["ULx", "ULy", "LLx", "LLy", "JAWx", "JAWy"])
    np.savez(tmp_path / "set.npz", columns=columns, set_1=table, hz=100)
    (tmp_path / "set_1.TextGrid").write_text(TEXTGRID)
    (one,) = load_recordings(tmp_path)
    assert (one.name, one.speaker, one.in_mm) == ("set_1", "set", False)
    assert np.diff(one.curves["lip_gap"]) == pytest.approx(4.4)


def test_other_arrays_are_passed_over(tmp_path: Path) -> None:
    np.savez(tmp_path / "frames.npz", columns=np.array(["ULx"]), mm=np.zeros((2, 1)))
    with pytest.raises(CorpusError, match="has no articulography"):
        load_recordings(tmp_path)


def test_damaged_arrays_are_told(tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_bytes(b"PK no archive")
    with pytest.raises(CorpusError, match=r"a\.npz: cannot be read"):
        load_recordings(tmp_path)


@pytest.mark.skipif(not (REAL / "ema_de").is_dir(), reason="needs the folder ema_de of PHONANIM_DATA")
def test_the_jaw_of_a_real_speaker_opens_in_a() -> None:
    for one in load_recordings(REAL / "ema_de"):
        jaw, code = one.curves["jaw"][one.speech], one.track.sample(one.times[one.speech])
        assert jaw[code == 8].mean() > jaw.mean() + 1  # aa
