"""Comparisons on corpora of controls, sensors and vertices: folds, the page, and what is wrong in a plan."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from motions import KINDS, made_up_motion
from speech import made_up_corpus

from phonanim.__main__ import run
from phonanim.comparison.measures import mean_r, mean_sd_ratio
from phonanim.comparison.motion_folds import motion_folds, speech_frames, training_part
from phonanim.comparison.motion_scores import clip_sums, curve_names
from phonanim.comparison.plan import read_plan
from phonanim.corpus.motion import load_motion_corpus, save_motion_corpus
from phonanim.evaluation.corpora import STILL
from phonanim.evaluation.statistics import pearson_sums
from phonanim.metrics import correlation, sd_ratio

PLAN = """
corpus = "corpus"
reference = "smooth"
folds = [{folds}]
words = [["w1"], ["w2"]]
phones = ["m"]

[models]
smooth = "smooth.toml"
stepped = "stepped.toml"
"""


def put_plan(folder: Path, folds: str = '"test", "words", "phones"', more: str = "") -> Path:
    (folder / "smooth.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    stepped = 'kind = "phone_mean"\ncorpus = "corpus"\n[settings]\nsmoothing = 0.4\n'
    (folder / "stepped.toml").write_text(stepped)
    (folder / "plan.toml").write_text(PLAN.format(folds=folds) + more)
    return folder / "plan.toml"


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_its_page(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    folder = made_up_motion(kind, tmp_path)
    more = ""
    if kind == "vertices":
        (folder / "lips.txt").write_text("1, 3")
        more = '[masks]\nlips = "lips.txt"\n'
    plan, out = put_plan(folder, more=more), folder / "out"
    assert run(["compare", str(plan), "-o", str(out), "--workers", "1", "--quiet"]) == 0
    page, details = (out / "benchmark.md").read_text(), (out / "benchmark/details.md").read_text()
    assert f"the {kind} of made_up from the same" in page
    assert "s of one speaker (anna), of which" in page
    errors = {"controls": "MCE (L2)", "sensors": "error, mm", "vertices": "MVE | LVE"}
    assert f"| model | driven by | r | sd ratio | {'L1, sum over controls | ' * (kind == 'controls')}" in page
    assert errors[kind] in page
    assert f"| {STILL} |  | – | 0.000" in page
    assert all(heading in details for heading in ("Withheld words", "The withheld words:", "Withheld phones"))
    assert all((out / "benchmark" / f"{name}.png").stat().st_size > 5000 for name in ("bars", "heat"))
    sums = json.loads((out / "models/sums.json").read_text())
    r = {
        name: float(mean_r(np.sum(model["scores"]["raw"]["test/all"]["curves_r"], axis=0)))
        for name, model in sums["models"].items()
        if name != STILL
    }
    assert r["smooth"] > r["stepped"] > 0.3
    tables = json.loads((out / "benchmark/benchmark.json").read_text())
    assert {table["page"] for table in tables} == {"", "details"}
    written = {path: path.read_bytes() for path in out.rglob("*.*") if path.suffix in (".md", ".png")}
    assert run(["compare", str(plan), "-o", str(out), "--report-only", "--quiet"]) == 0
    assert {path: path.read_bytes() for path in written} == written


def test_each_clip_is_left_out(tmp_path: Path) -> None:
    folder = made_up_motion("sensors", tmp_path)
    corpus = load_motion_corpus(folder / "corpus")
    few = replace(corpus, clips=corpus.clips[:3])
    plan = read_plan(put_plan(folder, folds='"clips"'))
    folds = motion_folds(plan, few)
    assert [(fold.train, fold.test) for fold in folds] == [((1, 2), (0,)), ((0, 2), (1,)), ((0, 1), (2,))]
    part = training_part(few, folds[0].train)
    assert [clip.split for clip in part.clips] == ["withheld", "train", "train"]
    save_motion_corpus(few, folder / "corpus")
    pytest.importorskip("matplotlib")
    out = folder / "out"
    assert run(["compare", str(folder / "plan.toml"), "-o", str(out), "--workers", "1", "--quiet"]) == 0
    page = (out / "benchmark.md").read_text()
    assert "anew without each clip in turn" in page
    assert "3 clips allow no interval and no test" in page
    assert "[" not in page.split("| smooth")[1].split("\n")[0]


def test_the_sums_are_those_of_the_curves(tmp_path: Path) -> None:
    corpus = load_motion_corpus(made_up_motion("controls", tmp_path) / "corpus")
    names = curve_names(corpus)
    assert names == ("jawDown", "mouthWide")  # the third never moves
    captured = np.asarray(corpus.frames(0), np.float64)
    predicted = captured * 0.5 + np.random.default_rng(1).normal(0, 0.2, captured.shape)
    where = speech_frames(corpus, 0)
    assert where is not None
    rows = clip_sums(predicted, captured, corpus, 0, where, names, {})
    total = np.sum([row["curves_r"] for row in rows], axis=0)
    pairs = [(predicted[where, n], captured[where, n]) for n in (0, 1)]
    assert mean_r(total) == pytest.approx(np.mean([correlation(*pair) for pair in pairs]), abs=1e-6)
    assert mean_sd_ratio(total) == pytest.approx(np.mean([sd_ratio(*pair) for pair in pairs]), abs=1e-6)
    apart = np.linalg.norm((predicted - captured)[where], axis=1)
    error = np.sum([row["control_l2"] for row in rows], axis=0)
    assert error[0] / error[1] == pytest.approx(apart.mean(), abs=1e-6)


def test_a_curve_that_is_kept_still_counts() -> None:
    curve, still = np.sin(np.arange(50.0)), np.full(50, 0.1234567)
    both = np.concatenate([pearson_sums(curve, curve), pearson_sums(still, curve)])
    assert mean_r(both) == pytest.approx(0.5)
    assert mean_sd_ratio(both) == pytest.approx(0.5)
    unmoved = np.concatenate([pearson_sums(curve, curve), pearson_sums(curve, still)])
    assert mean_r(unmoved) == pytest.approx(1.0)  # nobody captured the second
    assert np.isnan(mean_r(np.concatenate([pearson_sums(still, curve)] * 2)))


def test_long_clips_are_pieces(tmp_path: Path) -> None:
    corpus = load_motion_corpus(made_up_motion("controls", tmp_path) / "corpus")
    long = replace(corpus, fps=1.0)
    frames = np.random.default_rng(0).normal(size=(20, 3))
    rows = clip_sums(frames, frames, long, 0, np.ones(20, bool), ("jawDown",), {})
    assert [row["curves_r"][0] for row in rows] == [7, 7, 6]


@pytest.mark.parametrize(
    ("folds", "more", "message"),
    [
        (
            '"test"',
            "[sweeps.a]\nrecipe = 'smooth.toml'\nx = 'smoothing'\nvalues = [0.1]",
            "sweeps needs a corpus",
        ),
        ('"test"', "[masks]\nlips = 'none.txt'", "none.txt"),
        ('"words"', "", "the report needs 'test'"),
        ('"clips"', "trained = '.'", "models.trained is trained already, and folds = ['clips'] train anew"),
    ],
)
def test_what_a_plan_cannot_have(
    folds: str, more: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = put_plan(made_up_motion("controls", tmp_path), folds, more)
    pytest.importorskip("matplotlib")
    assert run(["compare", str(plan), "-o", str(tmp_path / "out"), "--workers", "1"]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_frames_that_are_no_numbers_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    folder = made_up_motion("controls", tmp_path)
    corpus = load_motion_corpus(folder / "corpus")
    path = corpus.clips[int(corpus.clips_of("test")[1])].motion
    values = np.load(path)
    values[3] = np.nan
    np.save(path, values)
    plan = put_plan(folder, '"test"')
    assert run(["compare", str(plan), "-o", str(folder / "out"), "--workers", "1", "--quiet"]) == 2
    assert f"{path.name}: frame 3 has numbers that are not finite" in capsys.readouterr().err


def test_what_a_corpus_allows(tmp_path: Path) -> None:
    from phonanim.errors import ModelError

    corpus = load_motion_corpus(made_up_motion("controls", tmp_path) / "corpus")
    plan = read_plan(put_plan(tmp_path))
    silent = replace(corpus, clips=tuple(replace(clip, aligned=False) for clip in corpus.clips))
    with pytest.raises(ModelError, match="folds of words and phones need phones"):
        motion_folds(plan, silent)
    with pytest.raises(ModelError, match="no training clip has what the fold words1 withholds"):
        motion_folds(replace(plan, words=(("absent",),)), corpus)
    strangers = corpus.clips_of("test")[:2]
    other = replace(
        corpus,
        clips=tuple(
            replace(clip, split="test_b") if number in strangers else clip
            for number, clip in enumerate(corpus.clips)
        ),
    )
    folds = {fold.name: fold for fold in motion_folds(plan, other)}
    assert folds["unseen speakers"].test == tuple(strangers)
    assert folds["unseen speakers"].model == "test"
    assert not set(strangers) & {*folds["test"].test, *folds["test"].train}
    trained = replace(corpus, clips=tuple(replace(clip, split="train") for clip in corpus.clips))
    with pytest.raises(ModelError, match='has no clips of the split test; use folds = ."clips".'):
        motion_folds(plan, trained)
    with pytest.raises(ModelError, match="has one clip, and none is left"):
        motion_folds(replace(plan, folds=("clips",)), replace(corpus, clips=corpus.clips[:1]))


def test_landmarks_have_no_such_fold(tmp_path: Path) -> None:
    from phonanim.comparison.folds import make_folds
    from phonanim.errors import ModelError

    plan = replace(read_plan(put_plan(made_up_motion("controls", tmp_path))), folds=("clips",))
    with pytest.raises(ModelError, match="leaves out each clip of a corpus of controls"):
        list(make_folds(plan, made_up_corpus(np.random.default_rng(3))))
