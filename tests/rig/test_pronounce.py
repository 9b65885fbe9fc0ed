"""A rig's mouth does what articulation asks for, on the shipped head."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from speech import track_of

from phonanim.animation.motion import predict_controls
from phonanim.articulation import CHANNELS, Articulation, articulate
from phonanim.errors import RigError
from phonanim.options import Options
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.measures import MEASURES, MouthMeasures, read_measures, write_measures
from phonanim.rig.measuring import ARKIT, incisors, measure
from phonanim.rig.pronounce import pronounce
from phonanim.rig.retarget import retarget

Array = NDArray[np.float64]
REST = {"lower_lip_to_teeth": 2.0}
LINE = "sil 0.2 p 0.05 aa 0.1 b 0.03 iy 0.08 f 0.07 s 0.09 ah 0.06 m 0.04 uw 0.1 sh 0.09 v 0.05 sil 0.2"


def mouths(*wanted: dict[str, float]) -> Articulation:
    """An articulation of a frame each; channels that are not named rest."""
    rows = [[(REST | want).get(name, 0.0) for name in CHANNELS] for want in wanted]
    return Articulation(np.array(rows))


def measured(values: NDArray[np.float32], controls: tuple[str, ...]) -> dict[str, Array]:
    """What the shipped head shows, by name (frames,) mm."""
    face, spots = load_model("default").face, shipped_landmarks()
    head = to_face_axes(load_head(), spots, face)
    shape = head.shape(head.weights(values, controls))
    at = {int(number): row for row, number in enumerate(spots.numbers)}
    lips = {number: spots.of(shape)[:, at[number]] for number in (0, 13, 14, 61, 291)}
    edges = incisors(head)
    assert edges is not None
    upper, lower = (shape[:, edge] for edge in edges)
    return {
        "gap": lips[13][:, 1] - lips[14][:, 1],
        "width": lips[291][:, 0] - lips[61][:, 0],
        "protrusion": lips[0][:, 2],
        "jaw": head.vertices[edges[1], 1] - lower[:, 1],
        "teeth": np.maximum(upper[:, 1] - lower[:, 1], 0),
        "lip_to_teeth": np.linalg.norm((lips[14] - upper)[:, 1:], axis=1),
    }


def solved(articulation: Articulation, name: str = "arkit") -> tuple[NDArray[np.float32], tuple[str, ...]]:
    rig = load_rig(name)
    assert rig.mouth is not None
    return pronounce(articulation, rig, rig.mouth), rig.controls


def test_a_mouth_at_rest_moves_nothing() -> None:
    values, _ = solved(mouths({}))
    assert values.max() < 0.02


def test_measures_are_met() -> None:
    wanted = [
        {"jaw": 9.0, "lip_gap": 12.0},
        {"jaw": 3.0, "lip_gap": 7.0, "lip_width": 5.0, "upper_lip": 1.0},
        {"jaw": 1.0, "lip_gap": 6.0, "lip_width": 2.0, "upper_lip": 1.5},
        {"jaw": 2.5, "lip_gap": 3.0, "lip_width": -8.0, "protrusion": 5.0},
    ]
    seen, rest = measured(*solved(mouths(*wanted))), measured(*solved(mouths({})))
    np.testing.assert_allclose(seen["jaw"], [want["jaw"] for want in wanted], atol=0.1)
    np.testing.assert_allclose(seen["gap"], [want["lip_gap"] for want in wanted], atol=0.6)
    assert seen["width"][1] > rest["width"][0] + 3.5
    assert seen["width"][3] < rest["width"][0] - 6.0
    assert seen["protrusion"][3] > rest["protrusion"][0] + 4.0
    assert seen["teeth"][2] <= 1.5


@pytest.mark.parametrize("fps", [24, 25, 30, 60, 120])
def test_contacts_at_any_rate(fps: float) -> None:
    track, rig, model = track_of(LINE), load_rig("arkit"), load_model("default")
    values = predict_controls(track, model, rig, Options(fps=fps), int(track.duration * fps)).values
    seen, times = measured(values, rig.controls), np.arange(len(values)) / fps
    for label, begin, end in zip(track.labels, track.bounds[:-1], track.bounds[1:], strict=True):
        near = (times >= begin - 0.5 / fps) & (times <= end + 0.5 / fps)
        if label.lower() in ("p", "b", "m"):
            assert seen["gap"][near].min() <= 0.5
        if label.lower() in ("f", "v"):
            assert seen["lip_to_teeth"][near].min() <= 1.0
        if label.lower() in ("s", "sh"):
            assert seen["teeth"][near].min() <= 1.5


def test_lips_close_only_as_far_as_the_jaw_opens_them() -> None:
    values, controls = solved(articulate(track_of(LINE), np.arange(0, 1.4, 1 / 60)))
    closing, opening = (values[:, controls.index(name)] for name in ("mouthClose", "jawOpen"))
    assert (closing <= opening + 1e-6).all()
    assert values.min() >= 0
    assert values.max() <= 1


def test_a_frame_is_the_same_in_any_company() -> None:
    whole = articulate(track_of(LINE), np.arange(0, 1.4, 1 / 60))
    values, _ = solved(whole)
    for first in range(0, 60, 20):
        part, _ = solved(Articulation(whole.values[first : first + 20]))
        np.testing.assert_allclose(part, values[first : first + 20], atol=1e-6)


@pytest.mark.parametrize("name", ["vrm", "oculus15"])
def test_rigs_of_mouth_shapes_open_and_close(name: str) -> None:
    track = track_of("sil 0.3 aa 0.2 m 0.1 uw 0.2 sil 0.3")
    rig, times = load_rig(name), np.arange(0, 1.1, 1 / 60)
    modes, face = np.zeros((len(times), 14)), load_model("default").face
    values = retarget(modes, face, rig, "articulation", track, times, True, articulate(track, times))
    said = {label: values[round(60 * middle)] for label, middle in (("aa", 0.4), ("m", 0.55), ("uw", 0.7))}
    names = {"vrm": ("aa", "ou"), "oculus15": ("viseme_aa", "viseme_U")}[name]
    opened, rounded = (rig.controls.index(shape) for shape in names)
    assert said["aa"][opened] > 0.5
    assert said["m"][opened] < 0.2
    assert said["uw"][rounded] > 0.4


def test_metahuman_goes_through_arkit() -> None:
    track, rig = track_of(LINE), load_rig("metahuman")
    values = predict_controls(track, load_model("default"), rig, Options(), 60).values
    assert values[:, rig.controls.index("CTRL_expressions_jawOpen")].max() > 0.2


def test_articulation_is_written_as_it_is() -> None:
    track, rig = track_of(LINE), load_rig("articulation")
    motion = predict_controls(track, load_model("default"), rig, Options(), 60)
    assert motion.articulation is not None
    assert rig.controls == CHANNELS
    np.testing.assert_allclose(
        motion.values, np.clip(motion.articulation.values, rig.minimum, rig.maximum), rtol=1e-6
    )


def test_a_rig_that_does_not_know_its_mouth_says_so() -> None:
    face = load_model("default").face
    wanted = r"rig face does not know the measures of its mouth; use --retarget auto, or phonanim rig fit"
    with pytest.raises(RigError, match=wanted):
        retarget(np.zeros((2, 14)), face, load_rig("face"), "articulation")
    with pytest.raises(
        RigError, match=r"rig arkit is moved by phones and needs an alignment; use --retarget"
    ):
        retarget(np.zeros((2, 14)), face, load_rig("arkit"), "articulation")
    with pytest.raises(RigError, match=r"rig oculus15 is moved by phones and needs an alignment, not motion"):
        retarget(np.zeros((1, 14)), face, load_rig("oculus15"), articulation=mouths({}))


def test_the_shipped_tables_are_what_the_head_does() -> None:
    rig, face = load_rig("arkit"), load_model("default").face
    found = measure(load_head(), shipped_landmarks(), face, ARKIT)
    assert rig.mouth is not None
    assert found.names == rig.mouth.names
    np.testing.assert_allclose(found.moved, rig.mouth.moved, atol=2e-3)
    np.testing.assert_allclose(found.rest, rig.mouth.rest, atol=2e-3)


def test_a_head_without_known_teeth_is_measured_by_its_chin() -> None:
    shipped, face = load_head(), load_model("default").face
    parts = {name.replace("teeth", "part"): rows for name, rows in shipped.parts.items()}
    head = Head(shipped.vertices, shipped.triangles, parts, shipped.targets, shipped.deltas, shipped.colors)
    known, found = (measure(one, shipped_landmarks(), face, ARKIT) for one in (shipped, head))
    jaw = MEASURES.index("jaw")
    assert found.moved[0, jaw] == pytest.approx(known.moved[0, jaw], rel=0.25)
    np.testing.assert_allclose(found.rest, known.rest, atol=0.2)


def test_a_table_comes_back(tmp_path: Path) -> None:
    mouth = load_rig("arkit").mouth
    assert isinstance(mouth, MouthMeasures)
    write_measures(tmp_path / "mine.mouth.csv", mouth)
    again = read_measures(tmp_path / "mine.mouth.csv", load_rig("arkit").controls)
    assert again.names == mouth.names
    np.testing.assert_array_equal(again.uses, mouth.uses)
    np.testing.assert_allclose(again.moved, mouth.moved)


HEADER = ",".join(("controls", "uses", "effort", *MEASURES))
ZEROS = ",0" * (1 + len(MEASURES))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{HEADER}\nrest,{ZEROS}\njaw,free,much\n", r"m.csv row 3: needs controls, uses, effort, jaw, gap"),
        (
            f"{HEADER}\nrest,{ZEROS}\njow,free{ZEROS}\n",
            r"m.csv row 3: names the control 'jow', which the rig",
        ),
        (f"{HEADER}\njaw,free{ZEROS}\n", r"m.csv: its first row must be 'rest', the mouth at rest"),
    ],
    ids=["number", "control", "rest"],
)
def test_a_table_that_is_amiss(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(RigError, match=message):
        read_measures(tmp_path / "m.csv", ("jaw",))


def test_a_table_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"none.csv: cannot be read"):
        read_measures(tmp_path / "none.csv", ("jaw",))


@pytest.mark.parametrize("name", ["vrm", "oculus15"])
def test_weights_of_visemes_add_up_to_one_at_most(name: str) -> None:
    rig, track = load_rig(name), track_of(LINE)
    values = predict_controls(track, load_model("default"), rig, Options(), 80).values
    own = [row for row, control in enumerate(rig.controls) if control != "viseme_sil"]
    assert values[:, own].sum(axis=1).max() <= 1 + 1e-5
    assert values[:, own].sum(axis=1).max() > 0.8


def test_lips_close_on_the_closing_viseme_or_on_none() -> None:
    wanted = mouths({"lip_gap": -0.5, "lip_width": -6.0, "protrusion": 4.0, "jaw": 2.0})
    assert solved(wanted, "vrm")[0].max() == 0


def test_a_round_mouth_is_not_spread() -> None:
    wanted = {"lip_gap": 6.0, "lip_width": 1.0, "protrusion": 4.0, "jaw": 3.0}
    values, controls = solved(mouths(wanted))
    at = {name: values[0, controls.index(name)] for name in controls}
    assert at["mouthStretchLeft"] == at["mouthSmileLeft"] == 0
    assert at["mouthFunnel"] > 0.2


def test_a_mouth_that_opens_at_its_corners_opens_as_far() -> None:
    rig, gaps = load_rig("vrm"), [MEASURES.index(f"gap_{name}") for name in ("inner", "outer", "corner")]
    assert rig.mouth is not None
    moved = rig.mouth.moved.copy()
    moved[:, gaps] = 0.95 * moved[:, [MEASURES.index("gap")]]
    drawn = replace(rig.mouth, moved=moved)
    wanted = articulate(track_of(LINE), np.arange(0, 1.4, 1 / 60))
    shown = [
        pronounce(wanted, rig, mouth) @ mouth.moved[:, MEASURES.index("gap")] for mouth in (rig.mouth, drawn)
    ]
    assert shown[1].max() >= 0.95 * shown[0].max()
