"""What landmarks cannot show is added while the phone lasts, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from speech import track_of

from phonanim.errors import RigError
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.accents import add_accents, read_accents
from phonanim.rig.retarget import retarget
from phonanim.speech.inventory import INVENTORY

TRACK = track_of("sil 0.5 f 0.1 aa 0.3 uw 0.1 sil 0.5")
TIMES = np.arange(90) / 60


def test_accents_last_as_long_as_their_phone() -> None:
    table = np.zeros((41, 2), np.float32)
    table[INVENTORY.code("f"), 0] = 0.5
    found = add_accents(np.zeros((90, 2), np.float32), table, TRACK, TIMES)
    assert found[33, 0] == pytest.approx(0.5)  # 0.55 s, the middle of f
    assert found[:20].max() == 0
    assert found[45:].max() == 0
    assert found[:, 1].max() == 0
    assert np.abs(np.diff(found[:, 0])).max() < 0.2


def test_the_shipped_rig_tucks_the_lip_under_the_teeth_and_rounds() -> None:
    model, rig = load_model("default"), load_rig("arkit")
    modes = model.predict(TRACK, 60, 90)
    plain = retarget(modes, model.face, rig, "auto", TRACK, TIMES, accents=False)
    whole = retarget(modes, model.face, rig, "auto", TRACK, TIMES)
    lower, pucker = (rig.controls.index(name) for name in ("mouthRollLower", "mouthPucker"))
    assert whole[33, lower] > plain[33, lower] + 0.3
    assert whole[57, pucker] > plain[57, pucker] + 0.1
    assert np.array_equal(whole[:15], plain[:15])
    assert (whole <= rig.maximum.astype(np.float32)).all()


def test_rigs_that_go_through_another_have_its_accents() -> None:
    model, rig = load_model("default"), load_rig("metahuman")
    modes = model.predict(TRACK, 60, 90)
    plain = retarget(modes, model.face, rig, "auto", TRACK, TIMES, accents=False)
    assert not np.array_equal(retarget(modes, model.face, rig, "auto", TRACK, TIMES), plain)


@pytest.mark.parametrize(
    "row",
    ["q,jawOpen,0.3", "f,jawOpne,0.3", "f,jawOpen,much", "f"],
    ids=["phone", "control", "amount", "short"],
)
def test_a_row_that_is_amiss_is_named(tmp_path: Path, row: str) -> None:
    path = tmp_path / "mine.accents.csv"
    path.write_text(f"phones,control,amount\nv,jawOpen,0.1\n{row}\n")
    with pytest.raises(RigError, match="mine.accents.csv row 3: needs phones, a control of the rig and"):
        read_accents(path, ("jawOpen",))


def test_a_table_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"none.csv: cannot be read"):
        read_accents(tmp_path / "none.csv", ("jawOpen",))
