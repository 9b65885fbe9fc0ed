from itertools import product

import numpy as np
import pytest

from phonanim.animation.animation import Animation
from phonanim.errors import EvaluationError, OutputError, RigError
from phonanim.evaluation.predictions import (
    Vertices,
    line_name,
    motion_from_array,
    pair_files,
    read_motion,
    read_template,
    resample_motion,
)
from phonanim.exporters import save

PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 2 0
3 0 1 2
"""


def curves(fps=30.0, frames=10, start=0.0):
    values = np.linspace(0, 0.9, frames, dtype=np.float32)[:, None] * [1.0, 0.5]
    return Animation(values.astype(np.float32), ("jawOpen", "mouthPucker"), fps, "arkit", start)


@pytest.mark.parametrize(
    ("shape", "vertices"),
    [
        ((4, 5023, 3), 5023),  # VOCA
        ((4, 15069), 5023),  # FaceFormer, CodeTalker on VOCASET
        ((1, 4, 15069), 5023),
        ((4, 70110), 23370),  # BIWI
        ((4, 6172 * 3), 6172),  # Multiface
    ],
)
def test_vertex_layouts(tmp_path, shape, vertices):
    array = np.arange(np.prod(shape), dtype=np.float32).reshape(shape)
    np.save(tmp_path / "line.npy", array)
    motion = read_motion(tmp_path / "line.npy", fps=25)
    assert isinstance(motion, Vertices)
    assert motion.points.shape == (4, vertices, 3)
    assert motion.points[1, 2].tolist() == array.reshape(4, vertices, 3)[1, 2].tolist()
    assert motion.times.tolist() == [0, 0.04, 0.08, 0.12]


def test_a_template_tells_the_layout_of_another_mesh():
    array = np.zeros((5, 12))
    assert isinstance(motion_from_array(array, "", 30, template=np.zeros((4, 3))), Vertices)
    controls = motion_from_array(array, "", 30)
    assert isinstance(controls, Animation)
    assert controls.channels == tuple(map(str, range(12)))


@pytest.mark.parametrize("suffix", [".npz", ".json", ".csv", ".glb", ".track.json"])
def test_curves_of_every_format(tmp_path, suffix):
    path = tmp_path / f"line{suffix}"
    save(curves(), path)
    motion = read_motion(path)
    assert isinstance(motion, Animation)
    assert motion.channel("jawOpen")[:10] == pytest.approx(curves().channel("jawOpen"), abs=2e-3)
    assert line_name(path) == "line"


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (
            np.zeros((30, 5000)),
            r"shape \(30, 5000\) is not a known layout; known are \(frames, vertices, 3\)",
        ),
        (np.zeros((2, 3, 4, 3)), r"shape \(2, 3, 4, 3\) is not a known layout"),
        (np.array([["a"]]), r"has <U1 of shape \(1, 1\), not the numbers of frames"),
        (np.zeros((0, 5023, 3)), "not the numbers of frames"),
        (np.float64(3), r"has float64 of shape \(\), not the numbers of frames"),
        (np.zeros((2, 5023, 3), complex), "has complex128"),
        (np.zeros(9), r"shape \(9,\) is not a known layout"),
        (np.array([[0.0, 1.0], [2.0, np.nan]]), r"nan in frame 1, value 1 \(1 such\); correct it"),
        (np.full((2, 5023, 3), np.inf), r"inf in frame 0, value 0 \(30138 such\); correct it"),
    ],
)
def test_arrays_that_are_no_motion(array, message):
    with pytest.raises(EvaluationError, match=f"take.npy: .*{message}"):
        motion_from_array(array, "take.npy", 30)


def test_files_that_are_no_arrays(tmp_path):
    (tmp_path / "torn.npy").write_bytes(b"\x93NUMPY")
    with pytest.raises(EvaluationError, match="torn.npy: cannot be read: it has no array of numbers"):
        read_motion(tmp_path / "torn.npy")


def test_curves_that_are_not_finite(tmp_path):
    path = tmp_path / "line.json"
    save(curves(), path)
    path.write_text(path.read_text().replace("0.9", "NaN", 1))
    with pytest.raises(OutputError, match="line.json: .* it has NaN, which is not a number"):
        read_motion(path)


def test_templates(tmp_path):
    points = [[0, 0, 0], [1, 0, 0], [0, 2, 0]]
    np.save(tmp_path / "rest.npy", np.array(points, float))
    (tmp_path / "rest.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    assert all(read_template(path).tolist() == points for path in tmp_path.iterdir())


def test_a_template_as_ply(tmp_path):
    (tmp_path / "rest.ply").write_text(PLY)
    assert read_template(tmp_path / "rest.ply").tolist() == [[0, 0, 0], [1, 0, 0], [0, 2, 0]]
    (tmp_path / "torn.ply").write_text("ply\n")
    with pytest.raises(RigError, match=r"torn.ply: is damaged or not a PLY file"):
        read_template(tmp_path / "torn.ply")


def test_what_is_no_template(tmp_path):
    with pytest.raises(
        EvaluationError, match=r"rest.txt: a template is a .ply, an .obj, an .off or a .npy of vertices"
    ):
        read_template(tmp_path / "rest.txt")
    np.save(tmp_path / "flat.npy", np.zeros(9))
    with pytest.raises(EvaluationError, match=r"a template has shape \(vertices, 3\), this one \(9,\)"):
        read_template(tmp_path / "flat.npy")


def test_other_instants_lie_straight_between_frames():
    motion = resample_motion(curves(fps=10, frames=10, start=1.0), np.array([1.05, 1.15, 1.25]))
    assert motion.values[:, 0] == pytest.approx([0.05, 0.15, 0.25])
    assert (motion.fps, motion.start) == pytest.approx((10, 1.05))
    points = Vertices(np.arange(4.0)[:, None, None] * np.ones((1, 2, 3)), 10)
    assert resample_motion(points, np.array([0.05, 0.25])).points[:, 0, 0] == pytest.approx([0.5, 2.5])


def test_files_of_folders_pair_by_stem(tmp_path):
    for name in ("ours/a.track.json", "ours/b.npy", "ours/c_condition_x.npy", "ours/c_condition_y.npy"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "theirs").mkdir()
    for name in ("a.csv", "a.html", "c.npy", "notes.txt"):
        (tmp_path / "theirs" / name).touch()
    for folder, name in product(("ours", "theirs"), ("report.html", "report.json")):
        (tmp_path / folder / name).touch()
    pairs = pair_files(tmp_path / "ours", tmp_path / "theirs")
    found = [(mine.name, other.name) for mine, other in pairs]
    assert found == [
        ("a.track.json", "a.csv"),
        ("c_condition_x.npy", "c.npy"),
        ("c_condition_y.npy", "c.npy"),
    ]


def test_what_does_not_pair(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    (tmp_path / "one/a.npy").touch()
    with pytest.raises(EvaluationError, match=r"one: no file has the stem of a file in .*two; rename them"):
        pair_files(tmp_path / "one", tmp_path / "two")
    with pytest.raises(EvaluationError, match="give two files or two folders"):
        pair_files(tmp_path / "one/a.npy", tmp_path / "two")
