"""The tongue goes to the places of articulation, smoothly, and keeps out of the teeth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from speech import track_of

from phonanim.animation.motion import predict_controls
from phonanim.articulation import articulate
from phonanim.errors import RigError
from phonanim.options import Options
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.head import TONGUE, Head, load_head
from phonanim.rig.tongue import COLUMNS, place_tongue, read_tongue
from phonanim.speech.phones import PhoneTrack

LINE = (
    "sil 0.3 dh 0.08 ae 0.12 t 0.07 th 0.1 ih 0.08 l 0.08 ay 0.15 k 0.08 uw 0.14 s 0.1 aa 0.15 "
    "sh 0.1 iy 0.1 sil 0.3"
)
TIMES = np.arange(120) / 60


def moved(line: str = LINE, rig: str = "arkit_tongue") -> tuple[NDArray[np.float32], tuple[str, ...]]:
    model, shipped, track = load_model("default"), load_rig(rig), track_of(line)
    return predict_controls(track, model, shipped, Options(), len(TIMES)).values, shipped.controls


def within(track: PhoneTrack, number: int) -> int:
    """The frame in the middle of a phone."""
    return round(60 * (track.bounds[number] + track.bounds[number + 1]) / 2)


@pytest.mark.parametrize(
    ("phone", "control"),
    [
        ("th", "tongueTipForward"),
        ("l", "tongueTipUp"),
        ("d", "tongueTipUp"),
        ("g", "tongueBackUp"),
        ("ng", "tongueBackUp"),
        ("iy", "tongueFrontUp"),
        ("w", "tongueBackUp"),
        ("r", "tongueTipBack"),
    ],
)
def test_each_place_moves_its_part_of_the_tongue_most(phone: str, control: str) -> None:
    line = f"sil 0.3 ah 0.1 {phone} 0.2 ah 0.1 sil 0.3"
    values, controls = moved(line)
    now = {name: values[within(track_of(line), 2), controls.index(name)] for name in TONGUE}
    assert max(now, key=now.__getitem__) == control
    assert now[control] > 0.3


def test_the_tip_comes_out_between_the_teeth_and_is_seen() -> None:
    head = load_head()
    values, controls = moved("sil 0.3 ah 0.1 th 0.2 ah 0.1 sil 0.3")
    shape = head.shape(head.weights(values[[0, 30]], controls))
    edges = [shape[:, head.parts[name], 2].max(axis=1) for name in ("teeth_u", "teeth_l", "tongue")]
    incisors = head.vertices[head.parts["teeth_u"]]
    edge = head.parts["teeth_u"].start + incisors[:, 1].argmin()
    assert edges[2][1] > shape[1, edge, 2]
    assert edges[2][0] < shape[0, edge, 2]


def test_the_tongue_glides() -> None:
    values, controls = moved()
    tongue = values[:, [controls.index(name) for name in TONGUE]]
    assert tongue.min() >= 0
    assert tongue.max() <= 1
    assert np.abs(np.diff(tongue, axis=0)).max() < 0.5
    assert (tongue[:10] == 0).all()
    assert (tongue[-10:] == 0).all()


def test_lips_that_shut_leave_the_tongue_where_it_goes_next() -> None:
    values, controls = moved("sil 0.3 b 0.1 l 0.1 ah 0.2 sil 0.3")
    tip = values[:, controls.index("tongueTipUp")]
    assert tip[23] > 0.4  # b ends at frame 24


def test_the_rest_is_what_arkit_does_but_for_dentals() -> None:
    line = "sil 0.3 l 0.1 aa 0.2 k 0.1 uw 0.2 sil 0.3"
    (with_tongue, controls), (plain, names) = moved(line), moved(line, "arkit")
    columns = [controls.index(name) for name in names]
    np.testing.assert_array_equal(with_tongue[:, columns], plain)


def test_it_keeps_out_of_the_teeth_but_on_its_way_between_them() -> None:
    head = load_head()
    values, controls = moved()
    forward = values[:, controls.index("tongueTipForward")]
    still = np.flatnonzero((forward < 0.02) | (forward > 0.95))
    assert (forward > 0.95).any()
    shapes = head.shape(head.weights(values[still[::3]], controls))
    for teeth in ("teeth_u", "teeth_l"):
        assert [crossings(shape, head, teeth) for shape in shapes] == [0] * len(shapes)


def crossings(points: NDArray[np.float64], head: Head, part: str) -> int:
    """How many edges of the tongue pass through triangles of a part."""
    tongue, teeth = (triangles_of(head, name) for name in ("tongue", part))
    edges = np.unique(np.sort(tongue[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    start, end = points[edges[:, 0]][:, None], points[edges[:, 1]][:, None]
    corners = points[teeth]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    before, after = (((end_ - corners[:, 0]) * normal).sum(axis=2) for end_ in (start, end))
    with np.errstate(divide="ignore", invalid="ignore"):
        place = start + (end - start) * (before / (before - after))[..., None]
    inside = before * after < 0
    for k in range(3):
        edge = corners[:, (k + 1) % 3] - corners[:, k]
        inside &= (np.cross(edge, place - corners[:, k]) * normal).sum(axis=2) >= 0
    return int(inside.any(axis=1).sum())


def triangles_of(head: Head, part: str) -> NDArray[np.int64]:
    rows = head.parts[part]
    return head.triangles[((head.triangles >= rows.start) & (head.triangles < rows.stop)).all(axis=1)]


HEADER = ",".join(COLUMNS)


@pytest.mark.parametrize(
    "row",
    ["tip,up,0,0,1,1,1,1", "tip,free,much,0,1,1,1,1", "tap,free,0,0,1,1,1,1", "tip"],
    ids=["use", "amount", "control", "short"],
)
def test_a_row_that_is_amiss_is_named(tmp_path: Path, row: str) -> None:
    path = tmp_path / "mine.tongue.csv"
    path.write_text(f"{HEADER}\ntip,dental,1,0,0,0,0,0\n{row}\n")
    with pytest.raises(
        RigError, match=r"mine.tongue.csv row 3: needs a control of the rig, a use \(jaw, free"
    ):
        read_tongue(path, ("tip",))


def test_numbers_are_finite(tmp_path: Path) -> None:
    path = tmp_path / "mine.tongue.csv"
    path.write_text(f"{HEADER}\ntip,free,0,0,nan,0,0,0\n")
    with pytest.raises(
        RigError, match=r"mine.tongue.csv row 2: needs .*tongue_tip_height is nan; it is a number"
    ):
        read_tongue(path, ("tip",))


def test_a_table_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RigError, match=r"none.csv: cannot be read"):
        read_tongue(tmp_path / "none.csv", ("tip",))


def test_a_rig_without_a_jaw_moves_its_tongue_all_the_same(tmp_path: Path) -> None:
    path = tmp_path / "mine.tongue.csv"
    path.write_text(f"{HEADER}\ntip,dental,0.5,0,0,0,0,0\n")
    values = np.zeros((len(TIMES), 1), np.float32)
    track = track_of("sil 0.5 th 0.2 sil 0.5")
    place_tongue(values, read_tongue(path, ("tip",)), articulate(track, TIMES))
    assert values[36, 0] == pytest.approx(0.5)


def test_a_lower_jaw_asks_more_of_the_tongue() -> None:
    rig = load_rig("arkit_tongue")
    assert rig.tongue is not None
    table = read_tongue(rig.tongue, rig.controls)
    mouth = articulate(track_of("sil 0.4 t 0.2 sil 0.4"), np.array([0.5, 0.5]))
    values = np.zeros((2, len(rig.controls)), np.float32)
    values[:, rig.controls.index("jawOpen")] = 0.02, 0.08
    low, high = place_tongue(values, table, mouth)[:, rig.controls.index("tongueTipUp")]
    assert 0.4 < low < high <= 1


def test_a_short_dental_comes_between_the_teeth() -> None:
    values, controls = moved("sil 0.3 aa 0.15 dh 0.03 aa 0.15 sil 0.3")
    assert values[:, controls.index("tongueTipForward")].max() > 0.9


def test_metahumans_raise_the_tip_and_the_body() -> None:
    values, controls = moved("sil 0.3 ah 0.1 t 0.2 ah 0.1 k 0.2 ah 0.1", "metahuman")
    tip, body = (values[:, controls.index(f"CTRL_expressions_tongue{name}")] for name in ("TipUp", "Up"))
    assert tip[30] > 0.5 > body[30]
    assert body[48] > 0.5 > tip[48]
