"""Several seeds of every training: their folders, their sums, and intervals that cover them; fresh folds."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_corpus

from phonanim.comparison.pages import generalization_page, scored_text
from phonanim.comparison.plan import read_plan
from phonanim.comparison.run import compare, model_rows, seeded_rows
from phonanim.comparison.tables import interval, interval_text
from phonanim.core.decode import read_toml
from phonanim.corpus.corpus import save_corpus
from phonanim.errors import ModelError
from phonanim.evaluation import statistics as st
from phonanim.regressors import load

PLAN = """
corpus = "corpus"
reference = "net"
folds = ["test", "words"]
words = [["w1"]]
seeds = [3, 8]

[models]
net = "net.toml"
mean = "mean.toml"
"""
NET = """
kind = "dnn"
corpus = "corpus"
[settings]
features = "raw"
hidden = [4]
epochs = 1
standardize = false
"""


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("torch")
    folder = tmp_path_factory.mktemp("seeds")
    save_corpus(made_up_corpus(np.random.default_rng(3)), folder / "corpus")
    (folder / "net.toml").write_text(NET)
    (folder / "mean.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    (folder / "plan.toml").write_text(PLAN)
    return folder


@pytest.fixture(scope="module")
def document(house: Path) -> dict[str, Any]:
    return compare(read_plan(house / "plan.toml"), house / "work", workers=1)


def test_every_recipe_is_trained_once_a_seed_and_fold(house: Path, document: dict[str, Any]) -> None:
    first, second = (load(house / f"work/net/test/seed{seed}").regressor.tensors() for seed in (3, 8))
    assert not np.array_equal(first["weights0"], second["weights0"])
    found = sorted(path.parent.relative_to(house / "work").as_posix() for path in house.rglob("job.json"))
    folds = [
        f"{name}/{fold}/seed{seed}"
        for name in ("mean", "net")
        for fold in ("test", "words1")
        for seed in (3, 8)
    ]
    assert found == folds


def test_sums_are_kept_by_seed_and_averaged_for_a_value(document: dict[str, Any]) -> None:
    by_seed = seeded_rows(document, "net", "raw", "words*/clip")
    averaged = model_rows(document, "net", "raw", "words*/clip")
    assert by_seed is not None
    assert averaged is not None
    rows = by_seed["shape_mse"]
    assert rows.shape[1:] == (2, 2)
    np.testing.assert_allclose(averaged["shape_mse"], rows.mean(axis=1))
    assert not np.allclose(rows[:, 0, 0], rows[:, 1, 0])
    np.testing.assert_array_equal(rows[:, 0, 1], rows[:, 1, 1])  # the same frames
    text = interval_text(document, rows, "shape_mse")
    assert text.startswith(f"{rows[..., 0].sum() / rows[..., 1].sum():.3f} [")
    seconds = rows[:, 0, 1].sum() / 25
    assert scored_text(document, "words*/clip") == (
        f"Scored on {seconds:.0f} s in {len(rows)} clips of made up; every model is trained with 2 seeds, "
        "which the intervals cover."
    )


def test_a_model_of_one_seed_stands_beside_those_of_several(house: Path) -> None:
    plan = replace(read_plan(house / "plan.toml"), one_seed=("mean",))
    document = compare(plan, house / "work", workers=1)
    once, twice = (seeded_rows(document, name, "raw", "test/all") for name in ("mean", "net"))
    assert once is not None
    assert twice is not None
    assert once["shape_mse"].shape[1] == 1
    assert twice["shape_mse"].shape[1] == 2
    averaged = [model_rows(document, name, "raw", "test/all") for name in ("mean", "net")]
    frames = [rows["shape_mse"][:, 1] for rows in averaged if rows is not None]
    np.testing.assert_array_equal(*frames)  # a test that swaps their clips gives both the same weight
    assert scored_text(document, "test/all").endswith(
        "; trained with 2 seeds, which the intervals cover, except `mean`: these once."
    )


def test_correlations_in_new_words_stand_beside_the_size_of_the_motion(
    house: Path, document: dict[str, Any]
) -> None:
    parts = generalization_page(document, read_plan(house / "plan.toml"))
    headers = [part[0] for part in parts if isinstance(part, list)]
    r = [n for n, header in enumerate(headers) if "aperture r" in header and header[0] == "model"]
    assert len(r) == 2  # the clips, and the words alone
    assert all("aperture sd ratio" in headers[n + 2] for n in r)


def test_one_seed_of_none(house: Path) -> None:
    plan = house / "bad.toml"
    plan.write_text('one_seed = ["mean"]\n' + PLAN.replace("seeds = [3, 8]", ""))
    with pytest.raises(ModelError, match=r"bad\.toml: one_seed: there are no seeds"):
        read_plan(plan)


def test_an_interval_covers_the_seeds() -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(5, 1, (40, 1)) + np.array([[-2.0, 0, 2]])
    rows = np.stack([values, np.ones_like(values)], axis=2)
    low, high = interval({"seed": 0}, rows, st.ratio)
    assert low < 3.6
    assert high > 6.4
    alone = interval({"seed": 0}, rows[:, 1:2], st.ratio)
    assert alone[1] - alone[0] < 1
    assert alone == st.bootstrap_interval(rows[:, 1], np.random.default_rng(0), st.ratio)


def test_seeds_that_agree_widen_nothing() -> None:
    values = np.random.default_rng(0).normal(5, 1, (40, 1)).repeat(3, axis=1)
    rows = np.stack([values, np.ones_like(values)], axis=2)
    seeded = st.seeded_interval(rows, np.random.default_rng(0))
    plain = st.bootstrap_interval(rows[:, 0], np.random.default_rng(0))
    np.testing.assert_allclose(seeded, plain, atol=0.03)


def test_intervals_of_nothing() -> None:
    with pytest.raises(ValueError, match="no sentences to draw from"):
        st.seeded_interval(np.zeros((0, 2, 2)), np.random.default_rng(0))
    assert np.isnan(st.seeded_interval(np.zeros((4, 2, 2)), np.random.default_rng(0))).all()


@pytest.mark.parametrize("seeds", ["[1, 1]", "[-1]", "[0.5]"])
def test_seeds_that_cannot_be(seeds: str, house: Path) -> None:
    plan = house / "bad.toml"
    plan.write_text(PLAN.replace("[3, 8]", seeds))
    with pytest.raises(ModelError, match=r"bad\.toml: .*seeds"):
        read_plan(plan)


def test_fresh_folds_share_nothing_with_those_that_chose(root: Path) -> None:
    spec = importlib.util.spec_from_file_location("draw_folds", root / "benchmarks/draw_folds.py")
    assert spec is not None
    assert spec.loader is not None
    draw = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(draw)
    corpus = made_up_corpus(np.random.default_rng(3))
    labels = ["red", "blue", "bin", "soon", "now", "one", "two", "six", "five", *"abcdefghijklmn"]
    words = [
        tuple(replace(word, label=labels[(2 * clip + n) % len(labels)]) for n, word in enumerate(row * 2))
        for clip, row in enumerate(corpus.words)
    ]
    corpus = replace(corpus, words=tuple(words))
    folds = draw.draw_words(corpus, {"now", "a"}, np.random.default_rng(0))
    drawn = [word for fold in folds for word in fold]
    assert len(drawn) == len(set(drawn)) == 20
    assert not {"now", "a"} & set(drawn)
    assert all(
        len(fold[0]) > 1 and fold[4] in draw.DIGITS and all(len(w) == 1 for w in fold[1:4]) for fold in folds
    )


def test_the_plan_of_fresh_folds_was_drawn(root: Path) -> None:
    fresh, old = (read_toml(root / f"benchmarks/{name}.toml") for name in ("fresh", "compare"))
    used = {word for fold in old["words"] for word in fold} | set(old["phones"])
    assert not used & ({word for fold in fresh["words"] for word in fold} | set(fresh["phones"]))
