"""The shipped presets: what each promises to its client, on motion that is known."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from phonanim.core.lexicon import LEXICON
from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.rig import load_rig, rig_names
from phonanim.rig.retarget import retarget
from phonanim.rig.tables import read_visemes
from phonanim.rig.visemes import URGENT, spoken_shapes, vowel_shapes
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

STEPPED = ("azure22", "preston_blair", "rhubarb")


def track(*spoken: tuple[str, float]) -> PhoneTrack:
    """Phones and their lengths in seconds."""
    phones, lengths = zip(*spoken, strict=True)
    bounds = np.concatenate([[0.0], np.cumsum(lengths)])
    return PhoneTrack(INVENTORY.codes(phones), bounds, tuple(phones))


def any_face(modes: int, face_id: str = "") -> FaceModel:
    """A face whose modes move nothing that counts; rigs look at standard deviations alone."""
    face = FaceModel(
        np.zeros((6, 3)), np.eye(18)[:modes].reshape(modes, 6, 3), np.full(modes, 2.0), np.arange(6)
    )
    if face_id:
        face.__dict__["id"] = face_id
    return face


def stepped(name: str, line: PhoneTrack, fps: float) -> list[str]:
    rig = load_rig(name)
    times = np.arange(int(line.duration * fps)) / fps
    values = retarget(np.zeros((len(times), 4)), any_face(4), rig, track=line, times=times)
    assert (values.sum(axis=1) == 1).all()
    assert set(np.unique(values)) <= {0.0, 1.0}
    return [rig.controls[row] for row in values.argmax(axis=1)]


def test_all_presets_are_shipped() -> None:
    wanted = {
        "arkit",
        "metahuman",
        "vrm",
        "oculus15",
        "azure22",
        "preston_blair",
        "rhubarb",
        "mediapipe",
        "face",
    }
    assert wanted <= set(rig_names())


@pytest.mark.parametrize("name", ["vrm", "oculus15", "face", "arkit"])
def test_fitted_presets_are_of_one_face(name: str) -> None:
    assert load_rig(name).face == load_rig("arkit").face


def test_drawn_mouths_follow_the_phones() -> None:
    line = track(("sil", 0.2), ("m", 0.2), ("aa", 0.2), ("sil", 0.2))
    shown = stepped("rhubarb", line, 50.0)
    assert [shown[frame] for frame in (5, 15, 25, 35)] == ["X", "A", "D", "X"]
    assert set(stepped("preston_blair", line, 50.0)) == {"rest", "MBP", "AI"}
    assert set(stepped("azure22", line, 50.0)) == {"viseme_0", "viseme_21", "viseme_2"}


def test_a_diphthong_is_drawn_twice() -> None:
    shown = stepped("rhubarb", track(("ow", 0.4)), 50.0)
    assert (shown[0], shown[-1]) == ("E", "F")
    assert shown.count("E") == pytest.approx(10, abs=1)


def test_a_short_closure_is_not_missed_at_a_low_rate() -> None:
    for offset in np.linspace(0, 0.04, 9):
        line = track(("aa", 0.2 + offset), ("p", 0.03), ("aa", 0.3))
        assert "A" in stepped("rhubarb", line, 24.0)
    assert URGENT > 1


def test_drawn_mouths_need_the_phones() -> None:
    with pytest.raises(RigError, match="rig rhubarb is moved by phones and needs an alignment"):
        retarget(np.zeros((3, 4)), any_face(4), load_rig("rhubarb"))


@pytest.mark.parametrize("name", [*STEPPED, "oculus15"])
def test_every_shape_is_said_and_every_phone_has_one(name: str) -> None:
    rig = load_rig(name)
    assert rig.visemes.of.shape == (41, 2)
    assert set(rig.visemes.of.ravel()) == set(range(len(rig.controls)))


def test_the_tables_of_visemes_are_those_of_rigs() -> None:
    tables = {path.stem for path in (LEXICON / "visemes").glob("*.csv")}
    assert tables == {name for name in rig_names() if load_rig(name).visemes is not None}


def test_halves_of_phones() -> None:
    rig = load_rig("rhubarb")
    bounds, shapes = spoken_shapes(track(("ow", 0.4), ("p", 0.2)), rig.visemes)
    np.testing.assert_allclose(bounds, [0, 0.2, 0.4, 0.5, 0.6])
    assert [rig.controls[row] for row in shapes] == ["E", "F", "A", "A"]


def test_vowel_shapes_of_oculus() -> None:
    rig = load_rig("oculus15")
    free = vowel_shapes(rig.visemes, 15)
    assert {name.removeprefix("viseme_") for name, yes in zip(rig.controls, free, strict=True) if yes} == {
        "aa",
        "E",
        "I",
        "O",
        "U",
    }


def oculus(spoken: PhoneTrack, modes: np.ndarray, times: np.ndarray) -> dict[str, np.ndarray]:
    """Oculus weights on a face that has the landmarks which count."""
    from faces import head_face

    rig, face = load_rig("oculus15"), head_face()
    count = rig.visemes.shapes.shape[1]
    basis = np.linalg.qr(np.random.default_rng(1).normal(size=(face.mean.size, count)))[0].T
    face = FaceModel(face.mean, basis.reshape(count, -1, 3), np.full(count, 5.0), face.indices)
    face.__dict__["id"] = rig.face
    values = retarget(modes * face.std, face, rig, track=spoken, times=times)
    return dict(zip(rig.controls, values.T, strict=True))


def test_oculus_says_what_the_lips_do() -> None:
    rig = load_rig("oculus15")
    times = np.arange(60) / 60.0
    line = track(("sil", 0.5), ("aa", 0.5))
    aa, sil = (rig.visemes.shapes[rig.controls.index(f"viseme_{name}")] for name in ("aa", "sil"))
    modes = np.where(times[:, None] < 0.5, sil, 0.3 * sil + 0.7 * aa)
    weights = oculus(line, modes, times)
    assert weights["viseme_aa"][50] == pytest.approx(0.6, abs=0.15)  # the prior takes its share
    assert weights["viseme_sil"][10] == pytest.approx(1.0, abs=0.05)
    assert weights["viseme_PP"].max() == 0.0  # nobody said p, b or m


def test_oculus_names_consonants_that_the_lips_do_not_show() -> None:
    rig = load_rig("oculus15")
    times = np.arange(60) / 60.0
    sil = rig.visemes.shapes[rig.controls.index("viseme_sil")]
    weights = oculus(track(("sil", 0.4), ("k", 0.2), ("sil", 0.4)), np.tile(sil, (60, 1)), times)
    assert weights["viseme_kk"][30] > 0.15
    assert weights["viseme_kk"][10] == 0.0
    total = sum(weights.values())
    assert (total >= 1 - 1e-5).all()


def test_metahuman_shuts_the_lips_by_their_share_of_the_jaw() -> None:
    arkit, rig = load_rig("arkit"), load_rig("metahuman")
    count = arkit.direct.loads.shape[1]
    face = any_face(count, arkit.face)
    modes = np.random.default_rng(2).normal(0, 2, (300, count))
    one, other = retarget(modes, face, arkit), retarget(modes, face, rig)
    close, jaw = (one[:, arkit.controls.index(name)] for name in ("mouthClose", "jawOpen"))
    together = other[:, rig.controls.index("CTRL_expressions_mouthLipsTogetherDR")]
    np.testing.assert_allclose(together[jaw > 0.01], (close / np.maximum(jaw, 1e-9))[jaw > 0.01], atol=1e-5)
    np.testing.assert_allclose(other[:, rig.controls.index("CTRL_expressions_jawOpen")], jaw)
    assert all(name.startswith("CTRL_expressions_") for name in rig.controls[:-3])
    assert rig.controls[-3:] == ("HeadPitch", "HeadYaw", "HeadRoll")


def test_mediapipe_has_the_scores_in_its_order() -> None:
    arkit, rig = load_rig("arkit"), load_rig("mediapipe")
    count = arkit.direct.loads.shape[1]
    face, modes = any_face(count, arkit.face), np.random.default_rng(3).normal(0, 2, (50, count))
    one, other = retarget(modes, face, arkit), retarget(modes, face, rig)
    assert rig.controls[0] == "_neutral"
    assert "tongueOut" not in rig.controls
    for column, name in enumerate(rig.controls[1:], start=1):
        np.testing.assert_array_equal(other[:, column], one[:, arkit.controls.index(name)])


def test_the_face_rig_is_the_face() -> None:
    rig = load_rig("face")
    count = rig.direct.loads.shape[1]
    modes = np.random.default_rng(4).normal(size=(20, count))
    values = retarget(modes * 2.0, any_face(count, rig.face), rig)
    expected = rig.direct.base + np.maximum(modes @ rig.direct.loads.T, 0) @ rig.direct.weights
    np.testing.assert_allclose(values, expected, atol=1e-3)  # mm
    flat = rig.direct.weights[:count] + rig.direct.weights[count:]
    assert np.abs(flat).max() == 0.0  # both halves of a mode have one slope: the map is linear
    assert len(rig.controls) == 3 * 199


def test_a_table_without_a_phone_is_said(tmp_path: Path) -> None:
    path = tmp_path / "v.csv"
    path.write_text("phone,viseme,end\nsil,x,\n", encoding="utf-8")
    with pytest.raises(RigError, match="has no row for the phone 'dh'; every phone needs a viseme"):
        read_visemes(path, ("x",))
    path.write_text("phon,viseme,end\nsil,x,\n", encoding="utf-8")
    with pytest.raises(RigError, match="needs the columns phone, viseme, end"):
        read_visemes(path, ("x",))


RIG = 'visemes = "v.csv"\n{}[controls]\nx = [0.0, 0.0, 1.0]\n'


@pytest.mark.parametrize(
    ("text", "table", "message"),
    [
        ("", None, r"needs shapes = .*, or stepped = true"),
        ('shapes = "s.csv"\n', "vis,mode1\nx,1\n", r"needs the columns viseme, mode1"),
        ('shapes = "s.csv"\n', "viseme,mode1\ny,1\n", r"names the control 'y'"),
    ],
)
def test_blended_shapes_are_checked(tmp_path: Path, text: str, table: str | None, message: str) -> None:
    phones = "".join(f"{phone},x,\n" for phone in INVENTORY.phones)
    (tmp_path / "v.csv").write_text("phone,viseme,end\n" + phones, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(RIG.format(text), encoding="utf-8")
    if table:
        (tmp_path / "s.csv").write_text(table, encoding="utf-8")
    with pytest.raises(RigError, match=message):
        load_rig(str(tmp_path / "mine.toml"))


def test_shares_are_checked(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("from,to,weight\njawOpen,x,1\n", encoding="utf-8")
    text = 'through = "arkit"\ntable = "t.csv"\n[controls]\nx = [0.0, 0.0, 1.0]\n'
    text += '[shares]\nx = "mouthClose / jawOpn"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(RigError, match=r"\[shares\] x .* has no 'jawOpn'; did you mean 'jawOpen'"):
        load_rig(str(tmp_path / "mine.toml"))


def test_metahuman_weights_are_those_of_its_table() -> None:
    rig = load_rig("metahuman")
    with (LEXICON / "rigs" / "metahuman.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == np.count_nonzero(rig.through.table)
    assert {row["from"] for row in rows} == set(rig.through.rig.controls) - {"mouthClose"}
