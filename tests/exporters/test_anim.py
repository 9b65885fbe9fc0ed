import csv
import re

import numpy as np
import pytest
from animations import line, metahuman, only

from phonanim.errors import OutputError
from phonanim.exporters import load, save
from phonanim.pipeline import animate


def curves_of(path):
    """Name, node and keys of every curve in a Maya file."""
    text = path.read_text()
    found = re.findall(r"anim (\S+) \S+ (\S+) 0 0 \d+;.*?keys \{\n(.*?)\n  \}", text, re.DOTALL)
    return {
        name: (node, np.array([row.split()[:2] for row in rows.split("\n")], float))
        for name, node, rows in found
    }


def test_a_key_per_frame(tmp_path):
    save(line(), tmp_path / "a.anim", node="face_bs")
    curves = curves_of(tmp_path / "a.anim")
    assert tuple(curves) == line().channels
    node, keys = curves["jawOpen"]
    assert node == "face_bs"
    np.testing.assert_allclose(keys[:, 0], np.arange(61), atol=1e-6)
    np.testing.assert_allclose(keys[:, 1], line().channel("jawOpen"), atol=1e-6)
    text = (tmp_path / "a.anim").read_text()
    assert text.startswith("animVersion 1.1;\n")
    assert "timeUnit ntscf;" in text
    assert "endTime 60;" in text
    assert text.count("{") == text.count("}") == 2 * len(line().channels)


@pytest.mark.parametrize(("fps", "unit", "second"), [(25, "pal", 25), (24, "film", 24), (90, "ntscf", 60)])
def test_time_is_counted_in_the_unit_that_is_named(tmp_path, fps, unit, second):
    save(line(frames=fps + 1, fps=fps), tmp_path / "a.anim")
    assert f"timeUnit {unit};" in (tmp_path / "a.anim").read_text()
    assert curves_of(tmp_path / "a.anim")["jawOpen"][1][-1, 0] == pytest.approx(second)


def test_few_keys(tmp_path):
    save(line(), tmp_path / "a.anim", keys=0.02)
    for name, (_, keys) in curves_of(tmp_path / "a.anim").items():
        met = np.interp(np.arange(61), keys[:, 0], keys[:, 1])
        np.testing.assert_allclose(met, line().channel(name), atol=0.02 + 1e-6)
    save(only(line(), jawOpen=0.5), tmp_path / "a.anim", keys=0.02)
    assert all(len(keys) == 1 for _, keys in curves_of(tmp_path / "a.anim").values())


def test_a_metahuman_is_told_that_its_head_turns(tmp_path, line_without_sound):
    for life, switch in ((1.0, "1.000000"), (0.0, "0.000000")):
        path = tmp_path / "a.metahuman.csv"
        take = animate(line_without_sound, rig="metahuman", life=life, fps=25)
        save(take, path)
        rows = {row[0]: row[1:] for row in csv.reader(path.open())}
        assert set(rows["HeadControlSwitch"]) == {switch}
        np.testing.assert_allclose(np.array(rows["HeadYaw"], float), take.channel("HeadYaw"), atol=1e-6)
        assert (np.ptp(take.channel("HeadPitch")) > 1) == bool(life)
        assert load(path).channels == take.channels


def test_curve_tables(tmp_path):
    path = tmp_path / "a.metahuman.csv"
    save(metahuman(), path)
    rows = [row.split(",") for row in path.read_text().splitlines()]
    assert rows[0][:3] == ["---", "0.000000", "0.016667"]
    assert [row[0] for row in rows[1:]] == list(metahuman().channels)
    again = load(path)
    assert again.fps == pytest.approx(60, rel=1e-5)
    assert again.channels == metahuman().channels
    np.testing.assert_allclose(again.values, metahuman().values, atol=1e-6)


def test_curve_tables_that_are_none(tmp_path):
    path = tmp_path / "a.metahuman.csv"
    with pytest.raises(
        OutputError, match=r"the rig arkit has no CTRL_expressions_ curve; choose --rig metahuman"
    ):
        save(line(), path)
    for text in ("", "---,0,1,5\na,1,2,3\n", "---,0,1\na,1\n", "---,0,1\na,1,nan\n", "---,0,x\n"):
        path.write_text(text)
        with pytest.raises(OutputError, match=r"a\.metahuman\.csv: is not a Curve Table with a row of times"):
            load(path)
