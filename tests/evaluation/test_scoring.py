from dataclasses import replace

import numpy as np
import pytest
from animations import speaking

from phonanim.animation.animation import Animation
from phonanim.articulation import CHANNELS, articulate
from phonanim.errors import EvaluationError
from phonanim.evaluation.predictions import Vertices
from phonanim.evaluation.scoring import score, takes_diversity
from phonanim.evaluation.surfaces import Settings, make_surface
from phonanim.metrics import correlation
from phonanim.rig.head import load_head
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

SAID = PhoneTrack(
    INVENTORY.codes(("sil", "aa", "p", "aa", "f")), np.array([0, 0.2, 0.8, 1, 1.5, 2]), ("",) * 5
)


def mesh(fps=30.0, vertices=50, seed=0):
    points = np.random.default_rng(seed).normal(size=(60, vertices, 3)).cumsum(axis=0)
    return Vertices(points, fps)


def test_the_same_motion_has_no_error():
    scores = score(speaking(), speaking(), Settings(track=SAID))
    for name, value in scores.measures.items():
        if "intensity" in name:
            continue
        if name.endswith(("_mse", "_mm2", "_mm_s")) or name.startswith(("tmve", "fdd", "lve")):
            assert value == pytest.approx(0, abs=1e-9), name
        if "_r" in name and not name.endswith("ratio"):
            assert value == pytest.approx(1), name
    assert scores.measures["aperture_lag_ms"] == pytest.approx(0)
    assert scores.measures["aperture_jerk_ratio"] == pytest.approx(1)
    assert scores.notes == ()
    assert {row.name for row in scores.phones} == {"sil", "aa", "p", "f"}


def test_arkit_curves_are_scored_in_millimetres_on_the_head():
    closed = replace(speaking(), values=np.zeros((60, 2), np.float32))
    scores = score(closed, speaking(), Settings())
    head = load_head()
    opened = head.deltas[head.targets.index("jawOpen")]
    assert scores.measures["lve_mm"] > 0.3 * 1000 * np.linalg.norm(opened, axis=1).max() / 2
    assert scores.measures["tmve_jaw_mm"] > 10 * scores.measures["tmve_upper_mm"]
    assert scores.measures["control_mse"] == pytest.approx((speaking().values ** 2).mean())
    assert np.isnan(scores.measures["aperture_r"])


def test_the_head_as_vertices_scores_as_its_controls_do():
    ours, theirs = speaking(late=0.05), speaking()
    by_controls = score(ours, theirs, Settings()).measures
    points = [
        Vertices(load_head().shape(load_head().weights(a.values, a.channels)), 30) for a in (ours, theirs)
    ]
    by_vertices = score(*points, Settings(unit="m")).measures
    assert by_vertices == pytest.approx(
        {name: by_controls[name] for name in by_vertices}, abs=1e-6, nan_ok=True
    )


def test_landmarks_are_known_by_their_number():
    points = shipped_landmarks().of(
        load_head().shape(load_head().weights(speaking().values, speaking().channels))
    )
    scores = score(Vertices(points, 30), Vertices(points, 30), Settings())
    assert scores.measures["aperture_r"] == pytest.approx(1)
    assert scores.measures["tmve_lips_mm"] == 0
    assert "coordinates taken as m" in scores.notes[0]


def test_a_delay_is_reported():
    measures = score(speaking(late=0.1), speaking(), Settings()).measures
    assert measures["aperture_lag_ms"] == pytest.approx(100, abs=5)
    assert measures["aperture_r_without_lag"] > 0.999 > measures["aperture_r"]


def test_other_rates_and_lengths_are_told():
    scores = score(speaking(fps=60, seconds=1.5), speaking(), Settings())
    assert scores.frames == 46
    assert scores.measures["control_mae"] < 1e-3
    assert scores.notes == (
        "predictions at 60 fps, resampled at the reference's 30",
        "predictions 0.000 to 1.483 s, reference 0.000 to 1.967 s: scored from 0.000 to 1.500 s",
    )


def test_too_little_in_common():
    late = replace(speaking(), start=1.9)
    with pytest.raises(EvaluationError, match=r"from 1.9 to .* share 3 frames; 4 are needed"):
        score(late, speaking(), Settings())


def test_controls_go_by_name():
    theirs = speaking()
    ours = Animation(theirs.values[:, ::-1], ("mouth_pucker", "JawOpen"), 30, "arkit")
    assert score(ours, theirs, Settings()).measures["control_mse"] == 0
    lacking = score(speaking(channels=("jawOpen", "eyeBlink_L")), theirs, Settings())
    assert lacking.notes == (
        "controls that the predictions lack count as zero: mouthPucker",
        "controls that the reference lacks are left out: eyeBlink_L",
    )
    assert lacking.measures["control_mse"] == pytest.approx((theirs.values[:, 1] ** 2).mean() / 2)


def test_controls_that_do_not_match():
    with pytest.raises(
        EvaluationError, match="no control in common: the predictions have a, b, the reference jawOpen"
    ):
        score(speaking(channels=("a", "b")), speaking(), Settings())
    bare = [Animation(np.zeros((60, n), np.float32), tuple(map(str, range(n))), 30, "") for n in (3, 4)]
    with pytest.raises(
        EvaluationError, match=r"have shape \(60, 3\), the reference \(60, 4\); controls without names"
    ):
        score(*bare, Settings())


def test_vertices_by_hand():
    theirs = mesh()
    ours = replace(theirs, points=theirs.points + np.array([2.0, 0, 0]))
    own = Settings(masks={"lips": np.arange(5)}, lips=(0, 1, 2, 3), unit="mm", track=SAID)
    measures = score(ours, theirs, own).measures
    assert measures["mve_mm"] == measures["lve_mm"] == measures["tmve_lips_mm"] == pytest.approx(2)
    assert measures["lve_squared_mm2"] == pytest.approx(4)
    assert measures["vertex_mse_mm2"] == pytest.approx(4 / 3)
    assert measures["aperture_r"] == pytest.approx(1)
    apart = np.linalg.norm(theirs.points[:, 0] - theirs.points[:, 1], axis=1)
    assert measures["pbm_least_gap_mm"] == pytest.approx(apart[24:30].min())  # p: 0.8 to 1 s
    assert "fdd_mm" not in measures


@pytest.mark.parametrize(("unit", "scale"), [("m", 1000), ("cm", 10), ("mm", 1)])
def test_units(unit, scale):
    theirs = mesh()
    ours = replace(theirs, points=theirs.points + np.array([1.0, 0, 0]))
    assert score(ours, theirs, Settings(unit=unit)).measures["mve_mm"] == pytest.approx(scale)


def test_the_unit_is_found_by_size():
    head = Vertices(np.tile(load_head().vertices, (6, 1, 1)), 30)
    for factor, unit in ((1, "m"), (100, "cm"), (1000, "mm")):
        notes = make_surface(replace(head, points=head.points * factor), Settings()).notes
        assert f"coordinates taken as {unit}" in notes[0]


def test_templates_take_each_side_from_its_own_rest():
    theirs, person = mesh(), np.random.default_rng(1).normal(size=(50, 3)) * 30
    rest = np.zeros((50, 3))
    ours = replace(theirs, points=theirs.points + person)
    plain = score(ours, theirs, Settings(unit="mm"))
    assert plain.measures["mve_mm"] > 20
    assert "the mean faces are" in plain.notes[0]
    own = score(ours, theirs, Settings(unit="mm", template=person, reference_template=rest))
    assert own.measures["mve_mm"] == pytest.approx(0, abs=1e-9)
    assert own.notes == ()


def test_fdd_needs_the_subjects_own_face_at_rest():
    points = np.random.default_rng(0).normal(size=(60, 50, 3))
    theirs, upper = Vertices(points, 30), {"upper": np.arange(9)}
    ours = replace(theirs, points=0.5 * points)
    without = score(ours, theirs, Settings(unit="mm", masks=upper))
    assert {"fdd_mm", "fdd_squared_mm2"}.isdisjoint(without.measures)
    assert without.measures["fdd_step_mm"] > 0
    assert "as the face at rest is unknown; give each subject's own" in without.notes[0]
    right = score(ours, theirs, Settings(unit="mm", masks=upper, template=np.zeros((50, 3))))
    assert right.measures["fdd_squared_mm2"] == pytest.approx(
        0.75 * (points[:, :9] ** 2).sum(axis=2).std(axis=0).mean()
    )
    stranger = score(ours, theirs, Settings(unit="mm", masks=upper, template=np.full((50, 3), 3.0)))
    assert "fdd_mm" not in stranger.measures
    assert "upper face is 5.3 mm from the reference's, so it is another subject's" in stranger.notes[0]


def test_masks_of_controls_without_a_mesh_are_columns():
    names = tuple(map(str, range(6)))
    values = np.random.default_rng(0).normal(size=(60, 6)).astype(np.float32)
    ours, theirs = (Animation(v, names, 30, "") for v in (values + 1, values))
    masks = {"lips": np.array([0, 1]), "upper": np.array([2]), "nose": np.array([3, 4, 5])}
    measures = score(ours, theirs, Settings(masks=masks)).measures
    assert measures["control_mae"] == pytest.approx(1)
    assert measures["control_l1_medina"] == pytest.approx(6)
    assert measures["lce"] == pytest.approx(2**0.5)
    assert measures["control_l2_nose"] == pytest.approx(3**0.5)
    assert measures["c_fdd"] == pytest.approx(0, abs=1e-6)
    assert measures["c_fdd_energy"] == pytest.approx(
        (values[:, 2] ** 2).std() - ((values[:, 2] + 1) ** 2).std()
    )
    assert "lce" not in score(ours, theirs, Settings()).measures
    with pytest.raises(EvaluationError, match="mask lips has control 6, but the last control is 5"):
        score(ours, theirs, Settings(masks={"lips": np.array([6])}))
    found = takes_diversity([ours, theirs], Settings(masks=masks))
    assert found["control_diversity_nose"] == pytest.approx(1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"template": np.zeros((4, 3))}, r"the template has shape \(4, 3\), a frame \(50, 3\)"),
        ({"lips": (1, 2)}, r"lip vertices \(1, 2\): four below 50 are needed"),
        ({"lips": (1, 2, 3, 50)}, "four below 50 are needed: upper, lower, right corner, left"),
        ({"masks": {"lips": np.array([50])}}, "mask lips has vertex 50, but the last vertex is 49"),
    ],
)
def test_settings_that_do_not_fit(change, message):
    with pytest.raises(EvaluationError, match=message):
        score(mesh(), mesh(), Settings(unit="mm", **change))


def test_different_meshes():
    with pytest.raises(
        EvaluationError, match=r"shape \(60, 50, 3\), the reference \(60, 40, 3\) .* different meshes"
    ):
        score(mesh(), mesh(vertices=40), Settings())
    with pytest.raises(
        EvaluationError, match="controls can be compared only with vertices of the package's head"
    ):
        score(speaking(channels=("a", "b")), mesh(), Settings())


def test_spread_of_takes():
    takes = [speaking(), speaking(), speaking(late=0.1)]
    still = takes_diversity(takes[:2], Settings())
    assert still["diversity_mm"] == still["control_diversity"] == 0
    lips = Settings(masks={"lips": np.arange(9)})
    assert takes_diversity(takes, lips)["diversity_lips_mm"] != takes_diversity(takes, lips)["diversity_mm"]
    assert takes_diversity(takes, Settings())["diversity_mm"] > 0.1
    assert "diversity_mm" not in takes_diversity([speaking(channels=("a", "b"))] * 2, Settings())


def test_lips_of_the_head_are_those_of_its_landmarks():
    lips = make_surface(speaking(), Settings()).lips
    assert correlation(lips["aperture"], speaking().channel("jawOpen")) > 0.95
    assert lips["aperture"].max() > 5
    assert 40 < lips["width"].mean() < 60


def test_articulation_is_scored_against_captured_lips_of_another_mesh():
    times = np.arange(60) / 30
    moved = articulate(SAID, times)
    take = Animation(moved.values.astype(np.float32), CHANNELS, 30, "articulation")
    points = shipped_landmarks().of(
        load_head().shape(load_head().weights(speaking().values, speaking().channels))
    )
    scores = score(take, Vertices(points, 30), Settings(track=SAID))
    assert {"articulation_lip_gap_r", "articulation_lip_width_rmse_mm"} <= set(scores.measures)
    assert "articulation_jaw_r" not in scores.measures
    assert score(take, take, Settings(track=SAID)).measures["articulation_jaw_slope"] == pytest.approx(1)
    late = replace(take, values=take.values[::2], fps=15)
    assert score(late, take, Settings()).measures["articulation_jaw_r"] > 0.8


def test_a_few_names_in_common_are_not_the_head():
    names = ("mouth_dimple_l", *(f"control_{number}" for number in range(9)))
    values = np.random.default_rng(4).random((30, 10)).astype(np.float32)
    other = Animation(values, names, 30.0, "mine")
    scores = score(other, other.with_values(values[::-1].copy()), Settings())
    assert scores.measures["control_mse"] > 0
    assert not [name for name in scores.measures if "mm" in name or name.startswith("aperture")]
