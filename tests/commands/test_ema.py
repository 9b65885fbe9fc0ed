"""`phonanim ema report`: tables, JSON and pictures of a folder of recordings."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import dataset_samples
import ema_samples as samples
import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.ema import figures
from phonanim.errors import MissingExtraError

NAMES = "NA,EL,ER,TT,TB,BL,BR,LI,-"
REST = [(90, 0, 60), (0, 70, 0), (0, -70, 0), (60, 0, 0), (50, 0, 2), (45, 9, 0), (45, -9, 0), (60, 0, -20)]


def recordings(folder: Path) -> Path:
    """Two recordings of .pos with a head that drifts, a tongue tip and a jaw that move, and a gap."""
    folder.mkdir()
    times = np.arange(250) / 250
    for number in (1, 2):
        positions = np.zeros((250, 9, 3))
        positions[:, :8] = REST
        positions[:, 3, 2] += 5 * np.sin(2 * np.pi * 4 * times)
        positions[:, 7, 2] += 3 * np.cos(2 * np.pi * 2 * times)
        positions[:, :8] += times[:, None, None] * 10  # the head drifts
        positions[100:105, 3] = 0  # lost for 20 ms
        samples.pos(folder / f"{number}.pos", positions)
        samples.textgrid(
            folder / f"{number}.TextGrid", (0, 0.2, "sil"), (0.2, 0.5, "t"), (0.5, 0.8, "iy"), (0.8, 1, "sil")
        )
    return folder


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_folder_of_positions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, out = recordings(tmp_path / "in"), tmp_path / "out"
    words = ["ema", "report", str(folder), "-o", str(out), "--names", NAMES, "--reference", "NA,EL,ER"]
    assert run([*words, "--no-plots", "--json", "--language", "english"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts == {**json.loads((out / "report.json").read_text()), "files": facts["files"]}
    assert [Path(name).name for name in facts["files"]] == [
        "report.json", "phones.csv", "diphones.csv", "sides.csv",
    ]  # fmt: skip
    assert [gap["filled"] for gap in facts["recordings"][0]["gaps"] if gap["sensor"] == "TT"] == [True]
    assert facts["jaw"]["LI"]["reach_mm"] == pytest.approx([0, 0, 6], abs=0.01)
    (pair,) = rows(out / "diphones.csv")
    assert (pair["name"], pair["kind"], pair["examples"]) == ("t iy", "CV", "2")
    assert float(pair["width_mean"]) == pytest.approx(18, abs=1e-3)
    assert float(pair["curvature_mean"]) == pytest.approx(2 * 2 / (9**2 + 2**2), abs=1e-4)
    assert float(pair["speed_TT_mean"]) == pytest.approx(2 * np.pi * 4 * 5, rel=0.05)
    assert {row["name"] for row in rows(out / "phones.csv")} == {"t", "iy"}
    assert {row["axis"] for row in rows(out / "sides.csv")} == {"x", "y", "z"}


def test_pictures_and_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs the extra plots")
    folder = recordings(tmp_path / "in")
    words = [
        "ema",
        "report",
        str(folder),
        "--names",
        NAMES,
        "--rate",
        "100",
        "--quiet",
        "--language",
        "english",
    ]
    for out in ("a", "b"):
        assert run([*words, "-o", str(tmp_path / out)]) == 0
    first = {path.name: path.read_bytes() for path in (tmp_path / "a").iterdir()}
    assert set(first) == {
        *("report.json", "phones.csv", "diphones.csv", "sides.csv"),
        *("recording.png", "places.png", "jaw.png", "speeds.png", "shape.png", "quivers.png"),
    }
    assert first == {path.name: path.read_bytes() for path in (tmp_path / "b").iterdir()}


def test_the_plane_of_the_bite(tmp_path: Path) -> None:
    folder = recordings(tmp_path / "in")
    plate = np.zeros((5, 9, 3))
    plate[:, :3], plate[:, 3:6], plate[:, 6:] = REST[:3], [(70, 0, 5), (40, 20, 5), (40, -20, 5)], (1, 2, 3)
    samples.pos(folder / "bite.pos", plate)
    words = ["ema", "report", str(folder), "-o", str(tmp_path / "out"), "--no-plots", "--language", "english"]
    words += ["--names", NAMES, "--bite-plate", str(folder / "bite.pos"), "--plate", "TT,TB,BL"]
    assert run([*words, "--reference", "NA,EL,ER"]) == 0
    facts = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [one["name"] for one in facts["recordings"]] == ["1", "2"]
    np.testing.assert_allclose(facts["sensors"]["TB"]["mean_mm"], [-20, 0, -3], atol=0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--bite-plate", "1.pos"],
            "--bite-plate needs --reference: sensors on the skull that both recordings have",
        ),
        (
            ["--bite-plate", "1.pos", "--reference", "1,2,3", "--plate", "4,5"],
            "--plate names 2 sensors; give front, left and right",
        ),
        (["--axes", "up"], "'up': give the directions of x, y and z, as left,back,up or forward,left,up"),
        (["--reference", "1,2,99"], "has no sensor 99; it has 1, 2, 3"),
    ],
)
def test_options_that_make_no_sense(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    options: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(recordings(tmp_path / "in"))
    assert run(["ema", "report", ".", "-o", "../out", "--no-plots", *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_recordings_with_other_sensors(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = recordings(tmp_path / "in")
    samples.pos(folder / "2.pos", np.ones((250, 2, 3)))
    assert run(["ema", "report", str(folder), "-o", str(tmp_path / "out"), "--no-plots"]) == 2
    assert "2.pos: has the sensors 1, 2; " in capsys.readouterr().err


def test_recordings_without_samples(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a_bndl.json").write_text("{}")
    samples.ssff(tmp_path / "a.jaw", samples.sensor_columns("jw", np.zeros((0, 3))))
    assert run(["ema", "report", str(tmp_path), "-o", str(tmp_path / "out"), "--no-plots"]) == 2
    assert "a.jaw: has no samples; fetch it again, or remove it" in capsys.readouterr().err


def test_pictures_without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"pictures need Matplotlib: pip install 'phonanim\[plots\]'"):
        figures.check_plots()


def test_the_german_recordings(shared_data: Path, tmp_path: Path, capsys: Any) -> None:
    words = ["ema", "report", str(shared_data / "ema_de"), "-o", str(tmp_path / "out")]
    assert run([*words, "--axes", "left,back,up", "--language", "german", "--no-plots"]) == 0
    told = capsys.readouterr().err
    assert "2 recordings, 8.0 s, 26 phones, 56 pairs of phones" in told
    assert "12 gaps in the sensors: 0 filled, 12 too long and left out" in told
    facts = json.loads((tmp_path / "out" / "report.json").read_text())
    assert 5 < facts["jaw"]["LI"]["reach_mm"][2] < 12
    assert facts["width_curvature_r"] is None


@pytest.mark.parametrize(("name", "axes"), [("mngu0", "left,back,up"), ("mocha", "forward,left,up")])
def test_an_imported_data_set(tmp_path: Path, name: str, axes: str) -> None:
    getattr(dataset_samples, name)(tmp_path / "theirs")
    out = tmp_path / "ours"
    assert run(["corpus", "import", name, str(tmp_path / "theirs"), "-o", str(out), "--quiet"]) == 0
    for path in (out / "motion").glob("*.npy"):
        samples.textgrid(out / "textgrid" / f"{path.stem}.TextGrid", (0, 0.01, "t"), (0.01, 0.02, "iy"))
    words = ["ema", "report", str(out), "-o", str(tmp_path / "report"), "--axes", axes, "--no-plots"]
    assert run([*words, "--language", "english"]) == 0
    facts = json.loads((tmp_path / "report" / "report.json").read_text())
    assert {"TT", "TB", "TD", "LI", "UL", "LL"} <= set(facts["sensors"])
    assert len(rows(tmp_path / "report" / "phones.csv")) == 2
