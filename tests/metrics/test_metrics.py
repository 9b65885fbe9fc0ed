import numpy as np
import pytest
from faces import head_face

from phonanim import metrics
from phonanim.errors import EvaluationError
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

FPS = 50.0
TIMES = np.arange(100) / FPS


def track(*segments):
    names, lengths = zip(*segments, strict=True)
    return PhoneTrack(INVENTORY.codes(names), np.concatenate([[0], np.cumsum(lengths)]), names)


def wave(hertz, amplitude=1.0, late=0.0):
    return amplitude * np.sin(2 * np.pi * hertz * (TIMES - late))


def mesh(*frames):
    """Frames of two vertices that lie on the x axis at the given places."""
    return np.array([[[first, 0, 0], [second, 0, 0]] for first, second in frames], float)


def test_errors_of_arrays_by_hand():
    predicted, captured = np.array([[1.0, 2.0], [0.0, 0.0]]), np.array([[1.0, 0.0], [3.0, 4.0]])
    assert metrics.squared_error(predicted, captured).tolist() == [2.0, 12.5]
    assert metrics.absolute_error(predicted, captured).tolist() == [1.0, 3.5]
    assert metrics.euclidean_error(predicted, captured).tolist() == [2.0, 5.0]


def test_pixels_of_bytes_do_not_wrap_around():
    dark, bright = np.zeros((1, 2, 2, 3), np.uint8), np.full((1, 2, 2, 3), 255, np.uint8)
    assert metrics.squared_error(dark, bright).tolist() == [255.0**2]


@pytest.mark.parametrize(
    "measure", [metrics.squared_error, metrics.absolute_error, metrics.euclidean_error, metrics.distances]
)
def test_errors_name_both_shapes(measure):
    with pytest.raises(
        EvaluationError, match=r"predictions have shape \(2, 3, 3\), the reference \(4, 3, 3\)"
    ):
        measure(np.zeros((2, 3, 3)), np.zeros((4, 3, 3)))


def test_nothing_cannot_be_compared():
    with pytest.raises(EvaluationError, match=r"nothing to compare: both have shape \(0, 3\)"):
        metrics.squared_error(np.zeros((0, 3)), np.zeros((0, 3)))


def test_vertex_errors_by_hand():
    predicted, captured = mesh((0, 3), (1, 0)), mesh((0, 0), (0, 4))
    assert metrics.distances(predicted, captured).tolist() == [[0, 3], [1, 4]]
    assert metrics.mean_vertex_error(predicted, captured).tolist() == [1.5, 2.5]
    assert metrics.lip_vertex_error(predicted, captured, np.array([0, 1])).tolist() == [3.0, 4.0]
    assert metrics.lip_vertex_error(predicted, captured, np.array([0, 1]), squared=True).tolist() == [9, 16]
    assert metrics.lip_vertex_error(predicted, captured, np.array([0])).tolist() == [0.0, 1.0]
    regions = {"first": np.array([0]), "both": np.array([True, True])}
    assert metrics.temporal_mean_vertex_error(predicted, captured, regions) == {"first": 0.5, "both": 2.0}


def test_dynamics_deviation_by_hand():
    still, rest = mesh((0, 0), (0, 0), (0, 0)), np.zeros((2, 3))
    moving = mesh((0, 0), (2, 0), (0, 0))  # offsets 0 2 0 of the first vertex, steps 2 2
    deviation = np.std([0, 2, 0]) / 2
    rows = slice(None)
    assert metrics.dynamics_deviation(still, moving, rest, rows) == pytest.approx(deviation)
    assert metrics.dynamics_deviation(moving, still, rest, rows) == pytest.approx(-deviation)
    squared = metrics.dynamics_deviation(still, moving, rest, rows, "squared offset")
    assert squared == pytest.approx(np.std([0, 4, 0]) / 2)
    assert metrics.dynamics_deviation(still, moving, rest, rows, "step") == 0  # as long a step each time
    with pytest.raises(
        EvaluationError, match="there is no motion 'jump'; use offset, squared offset or step"
    ):
        metrics.dynamics_deviation(still, moving, rest, rows, "jump")


def test_diversity_is_the_mean_over_pairs():
    takes = np.array([mesh((0, 0)), mesh((1, 1)), mesh((4, 4))])
    assert metrics.diversity(takes) == pytest.approx((1 + 4 + 3) / 3)
    with pytest.raises(EvaluationError, match="diversity needs at least two takes of a line, not 1"):
        metrics.diversity(takes[:1])


def test_closures_by_hand():
    said = track(("sil", 0.5), ("p", 0.1), ("aa", 0.4), ("m", 0.2), ("f", 0.8))
    gap = np.full(100, 5.0)
    gap[27], gap[52] = 1.0, -0.5  # within p and within m
    captured = np.full(100, 5.0)
    captured[26] = 0.2
    assert metrics.least_gaps(gap, TIMES, said).tolist() == [1.0, 0.0]
    assert metrics.closure_error(gap, captured, TIMES, said).tolist() == [0.8, 0.0]
    assert metrics.least_gaps(gap, TIMES, said, ("f", "v")).tolist() == [5.0]
    assert metrics.least_gaps(gap, TIMES, said, ("b",)).tolist() == []
    with pytest.raises(EvaluationError, match="lip gaps of 100 and 99 frames at 100 times; they must agree"):
        metrics.closure_error(gap, captured[1:], TIMES, said)


def test_a_closure_between_two_frames_is_that_of_the_nearest():
    said = track(("aa", 0.305), ("p", 0.01), ("aa", 0.685))
    gap = np.arange(10.0)  # at 10 frames per second: p lies between frames 3 and 4
    assert metrics.least_gaps(gap, np.arange(10) / 10, said).tolist() == [3.0]


def test_closures_beyond_the_frames_are_left_out():
    said = track(("aa", 1.0), ("p", 0.1), ("aa", 2.0), ("p", 0.1))
    assert len(metrics.least_gaps(np.ones(100), TIMES, said)) == 1


def test_correlation():
    assert metrics.correlation(wave(3), 2 * wave(3) + 1) == pytest.approx(1)
    assert metrics.correlation(wave(3), -wave(3)) == pytest.approx(-1)
    assert np.isnan(metrics.correlation(wave(3), np.full(100, 0.3)))


@pytest.mark.parametrize("late", [0.0, 0.04, -0.06, 0.013])
def test_lag_finds_a_delay(late):
    found, best = metrics.lag(wave(2, 3.0, late), wave(2), FPS)
    assert found == pytest.approx(late, abs=0.002)
    assert best > 0.98


def test_lag_of_still_or_short_curves_is_not_a_number():
    assert np.isnan(metrics.lag(np.zeros(100), wave(2), FPS)).all()
    assert np.isnan(metrics.lag(np.arange(2.0), np.arange(2.0), FPS)).all()


def test_derivatives_by_hand():
    ramp = np.array([0.0, 1.0, 2.0, 3.0])
    assert metrics.derivative_error(ramp, np.zeros(4), 10) == pytest.approx(10)  # 1 a frame
    assert metrics.derivative_error(ramp**2, np.zeros(4), 10, order=2) == pytest.approx(200)
    assert metrics.derivative_error(ramp, ramp + 5, 10) == 0
    with pytest.raises(EvaluationError, match="2 frames have no derivative of order 2; give 3 or more"):
        metrics.derivative_error(ramp[:2], ramp[:2], 10, order=2)


def test_band_energies_hold_the_power_of_a_sine():
    energies = metrics.band_energies(wave(6, amplitude=4), FPS)
    assert energies.sum() == pytest.approx(8, rel=0.01)
    assert energies[3] == pytest.approx(8, rel=0.01)  # 4 to 8 Hz


def test_log_spectral_distance_measures_size_and_not_timing():
    rng = np.random.default_rng(0)
    curve = rng.normal(size=500)
    assert metrics.log_spectral_distance(curve, curve, FPS) == 0
    assert metrics.log_spectral_distance(10 * curve, curve, FPS) == pytest.approx(20)
    later = metrics.log_spectral_distance(np.roll(curve, 25), curve, FPS)
    assert later < 1 < metrics.log_spectral_distance(np.cumsum(curve), curve, FPS)
    assert np.isnan(metrics.log_spectral_distance(np.ones(500), curve, FPS))
    with pytest.raises(EvaluationError, match="a spectrum needs 4 frames or more, not 3"):
        metrics.band_energies(curve[:3], FPS)


def test_jerk_of_a_cubic():
    assert metrics.jerk(TIMES**3, FPS) == pytest.approx(6)


def test_errors_by_phone_and_by_class():
    said = track(("sil", 0.5), ("p", 0.5), ("aa", 0.5), ("p", 0.5))
    error = np.repeat([1.0, 2.0, 3.0, 6.0], 25)
    rows = {row.name: row for row in metrics.by_phone(error, TIMES, said)}
    assert list(rows) == ["sil", "p", "aa"]
    assert rows["p"] == metrics.PhoneError("p", 4.0, 50, 2)
    classes = {row.name: row for row in metrics.by_class(error, TIMES, said)}
    assert classes["bilabials"] == metrics.PhoneError("bilabials", 4.0, 50, 2)
    assert classes["vowels"].mean == 3.0
    assert "labiodentals" not in classes


def test_tables_of_several_lines_merge_by_frames():
    first = [metrics.PhoneError("p", 1.0, 10, 1), metrics.PhoneError("aa", 2.0, 5, 1)]
    found = metrics.merge_tables([first, [metrics.PhoneError("p", 4.0, 20, 2)]])
    assert found == [metrics.PhoneError("p", 3.0, 30, 3), metrics.PhoneError("aa", 2.0, 5, 1)]


def test_spectra_are_those_of_scipy():
    signal = pytest.importorskip("scipy.signal")
    curve = np.random.default_rng(0).normal(size=230).cumsum()
    density = signal.welch(curve, FPS, "hann", nperseg=50, detrend="constant", scaling="density")[1]
    edges = (0.0, 5.5, 25.0)
    wanted = [density[:6].sum(), density[6:].sum()]  # bins of 1 Hz
    assert metrics.band_energies(curve, FPS, edges) == pytest.approx(wanted)


def test_classes_hold_what_their_names_say():
    members = {
        name: {p for p, m in zip(INVENTORY.phones, mask, strict=True) if m}
        for name, mask in metrics.PHONE_CLASSES.items()
    }
    assert members["bilabials"] == {"p", "b", "m"}
    assert members["labiodentals"] == {"f", "v"}
    assert members["vowels"] | members["consonants"] == set(INVENTORY.phones) - {"sil", "sp"}


def test_lip_gap_and_vertex_error_of_the_reference_face():
    face = head_face()
    apart = face.mean.copy()
    apart[:, 1] -= 2.0 * np.isin(face.indices, [lower for _, lower in _pairs()])
    assert metrics.lip_gap(np.array([apart, face.mean]), face) @ [1, -1] == pytest.approx(2)
    moved = face.mean + 3.0 * np.eye(3)[0]
    assert metrics.vertex_error(moved[None], face.mean[None], face) == pytest.approx(3)


def _pairs():
    from phonanim.face.model import INNER_LIP_PAIRS

    return INNER_LIP_PAIRS
