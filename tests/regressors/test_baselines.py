"""The baselines of the literature: recurrent network, hidden Markov models, dynamic visemes."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator

import numpy as np
import pytest
from speech import made_up_examples, random_track, track_of

from phonanim.errors import MissingExtraError
from phonanim.regressors import Examples, Regressor, hmm, lstm, regressor_class
from phonanim.regressors import dynamic_visemes as dv
from phonanim.regressors._gestures import gesture_bounds, nearest_to_centres, phone_similarity
from phonanim.regressors._hmm import (
    Frames,
    Statistics,
    align_states,
    append_differences,
    divide_evenly,
    grow_tree,
)
from phonanim.regressors._hmm_config import list_questions
from phonanim.regressors._lstm_config import triphones
from phonanim.speech.inventory import INVENTORY


def fitted(kind: str, **settings: object) -> Regressor:
    pytest.importorskip("torch")
    pytest.importorskip("sklearn")
    found = regressor_class(kind)
    data = made_up_examples(np.random.default_rng(5))
    return found.fit(found.config_class(**settings), data, data, np.random.default_rng(1), lambda done: None)


@pytest.fixture(scope="module")
def baselines() -> list[Regressor]:
    return [
        fitted("lstm", units=8, epochs=1),
        fitted("hmm", leaf=5, rate=100.0),
        fitted("dynamic_visemes", clusters=12),
    ]


def test_any_frame_rate_is_the_same_motion(baselines: list[Regressor]) -> None:
    track = random_track(np.random.default_rng(3))
    native = np.arange(int(track.duration * 25)) / 25
    for baseline in baselines:
        slow, fast = (baseline.predict(track, np.arange(len(native) * k) / (25 * k)) for k in (1, 4))
        assert np.allclose(fast[::4], slow, atol=1e-4)
        odd = baseline.predict(track, native[3:6] + 0.0123)
        assert np.allclose(odd[1], baseline.predict(track, native[4:5] + 0.0123)[0], atol=1e-4)


def test_instants_beyond_the_ends_hold(baselines: list[Regressor]) -> None:
    track = track_of("sil 0.2 m 0.1 aa 0.3 sil 0.2")
    for baseline in baselines:
        before, start, after = baseline.predict(track, np.array([-1.0, 0.0, track.duration + 5]))
        assert np.array_equal(before, start)
        assert np.isfinite(after).all()


@pytest.mark.parametrize("bidirectional", [True, False])
@pytest.mark.parametrize("features", ["triphone", "classes"])
def test_the_recurrent_network_runs_as_torch_runs_it(bidirectional: bool, features: str) -> None:
    torch = pytest.importorskip("torch")
    from phonanim.regressors._torch_lstm import Network, export_weights

    torch.manual_seed(2)
    config = lstm.Config(units=20, bidirectional=bidirectional, features=features)
    network = Network(config, 3).eval()
    weights = export_weights(network, np.zeros(3), 1.0)
    assert {n: w.shape for n, w in weights.items()} == lstm.layer_shapes(config, 3)
    signal = np.random.default_rng(0).normal(size=(4, 60, lstm.n_inputs(features))).astype(np.float32)
    with torch.no_grad():
        expected = network(torch.from_numpy(signal)).numpy()
    ours = lstm.Recurrent(config, weights, np.zeros((41, 41), np.int8)).forward(signal)
    assert np.abs(ours - expected).max() < 1e-5


def test_padding_weighs_nothing() -> None:
    pytest.importorskip("torch")
    from phonanim.regressors._torch_lstm import pad_sequences

    data = made_up_examples(np.random.default_rng(1), clips=3)
    signals, targets, weights = pad_sequences(lstm.Config(), data, np.zeros((41, 41), np.int8))
    lengths = [len(times) for times in data.times]
    assert signals.shape[:2] == targets.shape[:2] == weights.shape == (3, max(lengths))
    assert weights.sum(axis=1).tolist() == lengths


def test_triphones() -> None:
    rows = triphones(track_of("sil 0.2 m 0.1 aa 0.4"), np.array([0.25]))
    hot = [*(n * 41 + INVENTORY.code(p) for n, p in enumerate(("sil", "m", "aa")))]
    assert np.flatnonzero(rows[0, :-2]).tolist() == hot
    assert rows[0, -2:] == pytest.approx([0.5, 0.1])


def test_layers_of_another_size() -> None:
    model = fitted("lstm", units=8, epochs=1)
    tensors = model.tensors() | {"recur1": np.zeros((2, 4, 12), np.float32)}
    with pytest.raises(ValueError, match=r"recur1 is \(2, 4, 12\), not \(2, 4, 16\)"):
        lstm.Recurrent.from_tensors(model.config, tensors)


def test_the_trajectory_is_the_likeliest() -> None:
    """Against the same normal equations written out as full matrices."""
    pytest.importorskip("scipy")
    rng = np.random.default_rng(0)
    frames, modes = 12, 2
    means, precisions = rng.normal(size=(frames, 3, modes)), rng.uniform(0.5, 3, (frames, 3, modes))
    found = hmm.likeliest_trajectory(means, precisions)
    for m in range(modes):
        rows, wanted, weights = [], [], []
        for frame, window in itertools.product(range(frames), range(3)):
            if window == 0 or 0 < frame < frames - 1:
                row = np.zeros(frames + 2)
                row[frame : frame + 3] = hmm.WINDOWS[window]
                rows.append(row[1:-1])
                wanted.append(means[frame, window, m])
                weights.append(precisions[frame, window, m])
        w, p = np.array(rows), np.diag(weights)
        assert np.allclose(found[:, m], np.linalg.solve(w.T @ p @ w, w.T @ p @ np.array(wanted)))


@pytest.mark.parametrize("frames", [1, 2, 3, 40])
def test_the_trajectory_of_a_constant(frames: int) -> None:
    pytest.importorskip("scipy")
    means = np.zeros((frames, 3, 2))
    means[:, 0] = (4, -1)
    assert np.allclose(hmm.likeliest_trajectory(means, np.ones_like(means)), (4, -1))


def test_differences() -> None:
    found = append_differences(np.array([[0.0], [1.0], [4.0], [9.0]]))
    assert found[1].tolist() == [1, 2, 2]


def test_states_share_a_phone() -> None:
    means, variances = np.array([[0.02, 0.04, 0.02]]), np.array([[1e-4, 2e-4, 1e-4]])
    assert np.allclose(hmm.divide_durations(means, variances, np.array([0.08])), means)
    longer = hmm.divide_durations(means, variances, np.array([0.16]))
    assert np.allclose(longer, [[0.04, 0.08, 0.04]])
    shorter = hmm.divide_durations(means, variances, np.array([0.001]))
    assert (shorter > 0).all()
    assert shorter.sum() == pytest.approx(0.001)


def test_questions_are_about_all_five_phones() -> None:
    place, members = list_questions()
    assert np.bincount(place).tolist() == [len(place) // 5] * 5
    context = hmm.quinphones(INVENTORY.codes(["m", "aa"]))
    assert [INVENTORY.phones[c] for c in context[0]] == ["sil", "sil", "m", "aa", "sil"]
    asked = hmm.answer_questions(context, place, members)
    is_m = np.flatnonzero((place == 2) & (members.sum(axis=1) == 1) & (members[:, context[0, 2]] == 1))
    assert asked[:, is_m].T.tolist() == [[True, False]]


def test_a_tree_splits_where_it_pays() -> None:
    """Two kinds of models, told apart by question 1; question 0 is noise."""
    asked = np.array([[0, 1], [1, 1], [0, 0], [1, 0]], bool)
    count, mean = np.full(4, 100.0), np.array([[3.0], [3.0], [-3.0], [-3.0]])
    found = Statistics(count, mean * count[:, None], (mean**2 + 1) * count[:, None])
    tree = grow_tree(found, asked, leaf=50, mdl=1.0)
    assert tree.question.tolist() == [1, hmm.LEAF, hmm.LEAF]
    assert tree.means[tree.leaf_of].ravel().tolist() == mean.ravel().tolist()
    assert np.allclose(tree.variances, 1)
    assert len(grow_tree(found, asked, leaf=50, mdl=1000.0).means) == 1
    assert len(grow_tree(found, asked, leaf=201, mdl=1.0).means) == 1


def test_states_are_aligned_with_what_moves() -> None:
    """One phone of two states: three frames at 0, seven at 5."""
    values = np.repeat([0.0, 5.0], [3, 7])[:, None].astype(np.float32)
    frames = Frames(values, np.array([0, 10]), np.zeros((1, 5), np.uint8), np.ones(1))
    assert divide_evenly(np.array([10]), 2).tolist() == [0] * 5 + [1] * 5
    trees = [
        grow_tree(
            Statistics(*(np.array(v, float) for v in ([9], [[9 * m]], [[9 * m * m + 9]]))),
            np.zeros((1, 1), bool),
            1,
            1,
        )
        for m in (0, 5)
    ]
    assert align_states(frames, trees, np.zeros(1, np.int64)).tolist() == [0] * 3 + [1] * 7


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("no", 10**6, "a node points outside its tree"),
        ("question", 10**4, "a node points outside its tree"),
        ("roots", None, "there are 5 trees for 5 states"),
        ("means", None, "a node points to a leaf that does not exist"),
    ],
)
def test_damaged_trees(name: str, value: int | None, message: str) -> None:
    model = fitted("hmm", leaf=5, rate=100.0, alignments=0)
    tensors = {key: tensor.copy() for key, tensor in model.tensors().items()}
    if value is None:
        tensors[name] = tensors[name][:-1]
    else:
        tensors[name][np.flatnonzero(tensors["question"] != hmm.LEAF)[0]] = value
    with pytest.raises(ValueError, match=message):
        hmm.Trees.from_tensors(model.config, tensors)


def test_gestures_end_where_the_mouth_is_slowest() -> None:
    times = np.arange(60) / 25
    target = np.sin(2 * np.pi * times / 0.8)[:, None]  # turns every 0.4 s, first at 0.2 s
    found = times[gesture_bounds(target, times, 0.1, 1.0)]
    assert np.allclose(found[1:-1], 0.2 + 0.4 * np.arange(len(found) - 2), atol=0.021)
    assert np.diff(times[gesture_bounds(target, times, 0.1, 0.25)]).max() <= 0.25
    noise = np.random.default_rng(0).normal(size=(60, 3))
    assert np.diff(times[gesture_bounds(noise, times, 0.16, 0.6)]).min() >= 0.159


def test_the_median_is_the_nearest_gesture() -> None:
    paths = np.array([0.0, 1.0, 5.0, 9.0])[:, None, None]
    labels, centres = np.array([0, 0, 1, 1]), np.array([0.9, 6.0])[:, None, None]
    assert nearest_to_centres(paths, labels, centres).ravel().tolist() == [1, 5]


def test_phones_are_most_like_themselves() -> None:
    alike = phone_similarity()
    assert np.allclose(alike.sum(axis=1), 1)
    assert (alike.argmax(axis=1) == np.arange(41)).all()


def test_units_meet_halfway() -> None:
    paths = np.array([[[0.0], [0.0]], [[2.0], [4.0]]])
    found = dv.play_units(paths, np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 1.0, 1.5, 2.0]))
    assert found.ravel().tolist() == [0, 0.5, 1, 2.5, 4]


def units(rng: np.random.Generator, **settings: float) -> dv.Units:
    """Three made-up units."""
    phones = np.log(rng.dirichlet(np.ones(41), size=(len(dv.PLACES), 3)).swapaxes(1, 2))
    joins = rng.uniform(0, 2, (3, 3))
    config = dv.Config(clusters=3, longest=0.12, **settings)  # type: ignore[arg-type]
    tables = rng.normal(size=(3, 4, 2)), phones, np.array([0.04, 0.08, 0.12]), joins
    return dv.Units(config, *(table.astype(np.float32) for table in tables))


def every_cover(steps: int, longest: int = 3) -> Iterator[tuple[int, ...]]:
    for count in range(1, steps + 1):
        yield from (c for c in itertools.product(range(1, longest + 1), repeat=count) if sum(c) == steps)


def test_the_cheapest_units_are_found() -> None:
    """Against all covers of a short track with all units."""
    model, track = units(np.random.default_rng(4)), track_of("m 0.07 aa 0.09")
    costs = {}
    for cover in every_cover(4):
        for chosen in itertools.product(range(3), repeat=len(cover)):
            starts = np.cumsum([0, *cover])[:-1]
            cost = sum(
                model._against(track, int(at), np.array([n]))[0, unit]
                + model.config.rate * np.log(n * 0.04 / model.durations[unit]) ** 2
                for at, n, unit in zip(starts, cover, chosen, strict=True)
            )
            cost += model.config.join * sum(model.joins[a, b] for a, b in itertools.pairwise(chosen))
            costs[chosen, cover] = cost
    best = min(costs, key=costs.__getitem__)
    found, bounds = model.select(track)
    assert (tuple(found.tolist()), tuple(np.round(np.diff(bounds) / 0.04).astype(int).tolist())) == best


def test_tables_of_other_units() -> None:
    model = units(np.random.default_rng(4))
    tensors = model.tensors() | {"joins": np.zeros((3, 2), np.float32)}
    with pytest.raises(ValueError, match=r"joins is \(3, 2\), not \(3, 3\)"):
        dv.Units.from_tensors(model.config, tensors)


@pytest.mark.parametrize(
    ("kind", "library", "message"),
    [
        ("hmm", "scipy.interpolate", "models of kind hmm need SciPy"),
        ("dynamic_visemes", "sklearn.cluster", "clustered with scikit-learn"),
        ("lstm", "torch", "training needs PyTorch"),
        ("phisanet", "torch", "training needs PyTorch"),
        ("facediffuser", "torch", "training needs PyTorch"),
    ],
)
def test_what_training_needs(kind: str, library: str, message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.delitem(sys.modules, "phonanim.regressors._torch", raising=False)
    data: Examples = made_up_examples(np.random.default_rng(5))
    found = regressor_class(kind)
    with pytest.raises(
        MissingExtraError, match=rf"{message}; install it with pip install 'phonanim\[train\]'"
    ):
        found.fit(found.config_class(), data, data, np.random.default_rng(1), lambda done: None)


def test_a_trajectory_needs_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.linalg", None)
    with pytest.raises(MissingExtraError, match=r"kind hmm need SciPy; .*'phonanim\[train\]'"):
        hmm.likeliest_trajectory(np.zeros((3, 3, 1)), np.ones((3, 3, 1)))
