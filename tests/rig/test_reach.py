"""What a head's shapes can do at best bounds what its rig does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from phonanim.__main__ import run
from phonanim.articulation import articulate
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.fit_quality import FitQuality, Followed, fit_quality, probe
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.measures import MEASURES
from phonanim.rig.pronounce import mouth_limits, pronounce
from phonanim.rig.reach import reachable_slopes
from phonanim.rig.shown_mouth import shown_mouth


@pytest.fixture(scope="module")
def reference():
    """The articulation of the probe, the rig of the shipped head, and what it shows."""
    track, times = probe()
    mouth, rig, face = articulate(track, times), load_rig("arkit"), load_model("default").face
    seen = shown_mouth(rig, face)
    assert seen is not None
    assert rig.mouth is not None
    return mouth, rig, seen(pronounce(mouth, rig, rig.mouth))


def test_the_shipped_head_reaches_itself(reference):
    mouth, rig, shown = reference
    found = reachable_slopes(mouth, rig, rig.mouth, shown)
    assert found == pytest.approx(dict.fromkeys(shown.keys() & found.keys(), 1.0), abs=0.02)
    assert set(found) == {"lip_gap", "lip_width", "protrusion", "jaw"}


def test_shapes_that_push_less_forward_reach_less(reference):
    mouth, rig, shown = reference
    moved = rig.mouth.moved.copy()
    moved[:, MEASURES.index("protrusion")] *= 0.15
    found = reachable_slopes(mouth, rig, replace(rig.mouth, moved=moved), shown)
    assert 0.1 < found["protrusion"] < 0.5
    assert found["lip_gap"] > 0.98
    whole = fit_quality(rig, load_head(), shipped_landmarks(), load_model("default").face)
    assert whole.reach["protrusion"] > 0.98


def test_what_falls_short_is_said_with_what_the_shapes_allow():
    followed = Followed(0.9, 0.5, 0.6)
    measures = dict.fromkeys(("lip_gap", "lip_width", "protrusion", "jaw"), followed)
    reach = {"lip_gap": 0.7, "lip_width": 0.4}
    gap, width, protrusion, _ = FitQuality(measures, 0.0, reach).short
    assert gap == (
        "lip_gap moves 50% of the reference's way (90% wanted; the best weights of its shapes give 70%)"
    )
    assert width.endswith("(80% wanted; its shapes do not allow more while the lips part as they should)")
    assert protrusion.endswith("(80% wanted)")


def test_a_rig_is_checked_and_drawn_beside_the_shipped_head(tmp_path: Path, capsys, root: Path):
    folder = root / "lexicon" / "rigs"
    rig = (folder / "arkit.toml").read_text("utf-8")
    for name in (
        "arkit.direct.csv",
        "arkit.mouth.csv",
        "arkit.landmarks.csv",
        "arkit.accents.csv",
        "head.glb",
    ):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "arkit.tongue.csv").write_bytes((folder / "arkit.tongue.csv").read_bytes())
    mine = tmp_path / "mine.toml"
    mine.write_text(rig, "utf-8")
    assert run(["rig", "check", str(mine), "--phones", str(tmp_path / "a.png")]) == 0
    said = capsys.readouterr()
    assert "mine.toml: good, 55 controls" in said.out
    assert "lip_gap: r 1.00, slope 1.00, sd ratio 1.00" in said.err
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    drawn = folder / "azure22.toml"
    assert run(["rig", "check", str(drawn), "--phones", str(tmp_path / "b.png")]) == 2
    assert "names no head and no mouth to draw; phonanim rig fit makes both" in capsys.readouterr().err


def test_visemes_of_open_mouths_do_not_round_closed_lips():
    rig = load_rig("oculus15")
    track, times = probe()
    wanted = articulate(track, times)
    low, high, _ = mouth_limits(wanted, rig, rig.mouth)
    names = [one[0] for one in rig.mouth.names]
    closed = wanted.channel("lip_gap") <= 0
    assert closed.any()
    assert (high[closed, names.index("viseme_U")] == low[names.index("viseme_U")]).all()
    assert (high[closed, names.index("viseme_PP")] == 1).all()
    assert high[:, names.index("viseme_U")].max() == 1
