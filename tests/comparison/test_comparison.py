"""The comparison on a small made-up corpus: every fold, table and figure, and what is wrong in a plan."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from speech import made_up_corpus, sound_of, write_wav

from phonanim.__main__ import run as main
from phonanim.aligners.pocketsphinx import SpeechAlignment
from phonanim.comparison import overview, tables, tools
from phonanim.comparison.fit import is_cached
from phonanim.comparison.folds import make_folds
from phonanim.comparison.pages import generalization_page
from phonanim.comparison.plan import read_plan
from phonanim.comparison.report import read_document, render, with_shown_names
from phonanim.comparison.run import _jobs, compare, model_rows
from phonanim.comparison.scores import MEASURES, clip_scores, measure_value
from phonanim.corpus.corpus import load_corpus, save_corpus
from phonanim.errors import AlignmentError, ModelError
from phonanim.evaluation.statistics import pearson_sums, pooled_sd_ratio, pooled_slope
from phonanim.face.fit import fit_face
from phonanim.media.audio import Sound
from phonanim.speech.alignment import Interval

PLAN = """
corpus = "corpus"
reference = "tree"
folds = ["test", "words", "phones"]
words = [["w1"], ["w2"]]
phones = ["m"]

[models]
tree = "tree.toml"
mean = "mean.toml"

[conditions."aligned anew"]

[conditions."babble, 3 dB"]
noise = "babble"
snr = 3

[conditions.higher]
voice = 4

[sweeps.leaf]
recipe = "tree.toml"
x = "leaf"
values = [2, 40]

[sweeps.box]
recipe = "mean.toml"
x = "smoothing"
values = [0.04, 0.2]

[sweeps.amount]
x = "clips"
values = [0.3, 1.0]
series = "model"
of = ["tree", "mean"]
label = "Amount of data"

[notes]
test = "A note about the test clips."
"""


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    pytest.importorskip("sklearn")
    folder = tmp_path_factory.mktemp("comparison")
    corpus = made_up_corpus(np.random.default_rng(3))
    corpus = replace(corpus, audio=tuple(folder / path for path in corpus.audio))
    for track, path in zip(corpus.tracks, corpus.audio, strict=True):
        write_wav(path, sound_of(track))
    save_corpus(corpus, folder / "corpus")
    (folder / "tree.toml").write_text('kind = "tree"\ncorpus = "corpus"\n[settings]\nleaf = 4\n')
    (folder / "mean.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    (folder / "plan.toml").write_text(PLAN)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("phonanim.aligners.pocketsphinx.align_sound", made_up_alignment)
        yield folder


def made_up_alignment(sound: Sound, text: str | None, name: str) -> SpeechAlignment:
    """Two phones in any sound, but none in that of one clip."""
    if name == "clip20":
        raise AlignmentError(f"{name}: the text cannot be found in the audio")
    phones = Interval("M", 0.1, 0.4), Interval("AA", 0.4, sound.duration - 0.1)
    return SpeechAlignment((), phones, sound.duration)


def command(house: Path, *arguments: str) -> None:
    from phonanim.commands.compare import command as run

    found = CliRunner().invoke(run, [str(house / "plan.toml"), "-o", str(house / "out"), *arguments])
    assert found.exit_code == 0, found.output


@pytest.fixture(scope="module")
def report(house: Path) -> str:
    pytest.importorskip("matplotlib")
    command(house, "--workers", "1", "--quiet")
    return whole_report(house)


def whole_report(house: Path) -> str:
    """The page and the long tables behind it, in the order of its links."""
    page = house / "out/benchmark.md"
    linked = re.findall(r"\((benchmark/\w+\.md)\)", page.read_text())
    return "\n".join(path.read_text() for path in (page, *(house / "out" / name for name in linked)))


@pytest.mark.slow
def test_the_report_holds_every_table_and_figure(house: Path, report: str) -> None:
    for heading in ("Test clips", "Withheld words", "Withheld phones", "Amount of data", "Speed"):
        assert f"# {heading}" in report
    assert "Noise, another voice, an automatic aligner" in report
    assert "| babble, 3 dB | 1 of 6 |" in report
    assert re.search(r"\| tree \| 0\.\d\d \[0\.\d\d, \d\.\d\d\] \|", report.partition("How far it moves")[2])
    assert re.search(
        r"The 16 trainings of this comparison, .* about \d+ (s|minutes) with two workers", report
    )
    assert "A note about the test clips." in report
    pictures = [line.partition("(")[2].rstrip(")") for line in report.splitlines() if line.startswith("![")]
    assert len(pictures) > 7
    for name in pictures:
        assert (house / "out/benchmark" / Path(name).name).stat().st_size > 5000
    assert "**" in report


def test_the_first_page_is_short_and_has_one_table(house: Path, report: str) -> None:
    page = (house / "out/benchmark.md").read_text()
    header, _, *rows = [line for line in page.splitlines() if line.startswith("|")]
    assert header.startswith(
        "| model | driven by | aperture r | sd ratio | width r | sd ratio | vertex error"
    )
    assert [row.split(" | ")[0] for row in rows] == ["| tree", "| mean"]
    assert re.search(r"on the same \d+ others: \d+ s, of which \d+ s are speech\.", page)
    assert len(page) < 3000
    listed = json.loads((house / "out/benchmark/benchmark.json").read_text())
    assert listed[0]["rows"][0][0] == "model"
    assert {table["page"] for table in listed} >= {
        "",
        "test",
        "generalization",
        "conditions",
        "sweeps",
        "cost",
    }
    assert (house / "out/models/sums.json").stat().st_size > (
        house / "out/benchmark/benchmark.json"
    ).stat().st_size


@pytest.mark.slow
def test_a_second_run_trains_nothing_and_says_the_same(house: Path, report: str) -> None:
    models = {p: p.stat().st_mtime_ns for p in (house / "out/models").rglob("*.safetensors")}
    assert models
    command(house, "--workers", "1", "--quiet")
    assert models == {p: p.stat().st_mtime_ns for p in (house / "out/models").rglob("*.safetensors")}
    again = whole_report(house)
    assert without_speed(again) == without_speed(report)
    command(house, "--report-only", "--quiet")
    assert whole_report(house) == again


def without_speed(report: str) -> str:
    return report.partition("# Speed")[0]


def test_a_changed_recipe_is_trained_again(house: Path, report: str) -> None:
    plan = read_plan(house / "plan.toml")
    corpus = load_corpus(plan.corpus)
    job = next(iter(_jobs(plan, next(iter(make_folds(plan, corpus))), house / "out/models")))
    assert is_cached(job)
    text = job.recipe.read_text()
    job.recipe.write_text(text.replace("leaf = 4", "leaf = 5"))
    try:
        assert not is_cached(job)
    finally:
        job.recipe.write_text(text)


def test_no_fold_learns_from_what_it_is_measured_on(house: Path) -> None:
    plan = read_plan(house / "plan.toml")
    corpus = load_corpus(plan.corpus)
    found = list(make_folds(plan, corpus))
    assert [fold.name for fold in found] == ["test", "words1", "words2", "phones"]
    for fold in found:
        assert not set(fold.train.tolist()) & set(fold.test.tolist())
        assert all(corpus.split[clip] == "train" for clip in fold.train)
    assert all("w1" not in [w.label for w in corpus.words[clip]] for clip in found[1].train)
    assert all("m" not in corpus.tracks[clip].labels for clip in found[3].train)


def test_models_are_scored_under_every_condition(house: Path, report: str) -> None:
    document = read_document(house / "out/models")
    for measure in ("shape_mse", "aperture_r"):
        for table in (tables.losses_table, tables.conditions_difference_table):
            header, *rows = table(document, "raw", "all", measure)
            assert header[1:] == ["aligned anew", "babble, 3 dB", "higher"]
            assert all(re.fullmatch(r"[+-][\d.]+( %)?, [\d.()]+", cell) for row in rows for cell in row[1:])
    clean, *_ = tables.conditions_table(document, "raw", "all", "aperture_r")[1][1:]
    alike = (
        model_rows(document, "tree", "raw", "test/all"),
        model_rows(document, "tree", "raw", "with higher/all"),
    )
    assert alike[0] is not None
    assert alike[1] is not None
    assert clean.strip("*").startswith(f"{measure_value('aperture_r', alike[0]['aperture_r']):.3f}")
    assert (alike[0]["shape_mse"][:, 1] == alike[1]["shape_mse"][:, 1]).all()  # on the same frames
    assert (alike[0]["pbm_gap"][:, 1] == alike[1]["pbm_gap"][:, 1]).all()  # at the same closures
    document["models"]["tree"]["scores"]["raw"]["with higher/all"] = document["models"]["tree"]["scores"][
        "raw"
    ]["test/all"]
    assert tables.losses_table(document, "raw", "all", "shape_mse")[1][3] == "same"


def test_what_is_absent_from_a_table_is_named(house: Path, report: str) -> None:
    document = read_document(house / "out/models")
    assert "Not trained again" not in report
    scores = document["models"]["mean"]["scores"]["raw"]
    document["models"]["mean"]["scores"]["raw"] = {k: v for k, v in scores.items() if "phones" not in k}
    parts = generalization_page(document, read_plan(house / "plan.toml"))
    assert [part for part in parts if isinstance(part, str) and part.startswith("Not")] == [
        "Not trained again for this: `mean`."
    ]


def test_a_trained_model_may_be_compared_as_it_is(house: Path, report: str, tmp_path: Path) -> None:
    text = PLAN.partition("[sweeps")[0].replace("tree.toml", str(house / "out/models/tree/test"))
    (tmp_path / "plan.toml").write_text(
        text.replace('"corpus"', f'"{house}/corpus"').replace("mean.toml", str(house / "mean.toml"))
    )
    document = compare(read_plan(tmp_path / "plan.toml"), tmp_path / "work", 1)
    whole = json.loads((house / "out/models/sums.json").read_text())
    scores = document["models"]["tree"]["scores"]["raw"]
    assert scores == {
        k: v for k, v in whole["models"]["tree"]["scores"]["raw"].items() if k.startswith(("test/", "with "))
    }
    assert model_rows(document, "tree", "raw", "words*/clip") is None
    assert [row[0] for row in tables.values_table(document, "raw", "words*/clip", ("shape_mse",))] == [
        "model",
        "mean",
    ]


def test_scores_by_hand() -> None:
    """A lower lip held 2 mm too low: what every measure makes of it."""
    corpus = made_up_corpus(np.random.default_rng(1))
    face = fit_face(corpus.landmarks, corpus.indices)
    captured = corpus.landmarks[corpus.rows([0])].astype(np.float64)
    lower = face.rows((14, 17, 87, 88, 178, 317, 318, 402))
    wrong = captured.copy()
    wrong[:, lower, 1] -= 2.0
    where = np.ones(len(captured), bool)
    rows = clip_scores(wrong, captured, face, corpus.tracks[0], corpus.fps, where)
    moving = int(face.moving.sum())
    found = {name: measure_value(name, sums[None]) for name, sums in rows.items()}
    assert found["vertex_error"] == pytest.approx(2.0 * 8 / moving)
    assert found["shape_mse"] == pytest.approx(4.0 * 8 / (3 * moving))
    assert found["lip_error"] == pytest.approx(2.0)
    assert found["speed_error"] == pytest.approx(0.0, abs=1e-9)
    assert found["aperture_r"] == pytest.approx(1.0)
    assert set(rows) < set(MEASURES)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("reference = ", "referense = "), "there is no key 'referense'; did you mean 'reference'"),
        (('reference = "tree"', ""), "lacks 'reference'"),
        (('reference = "tree"', 'reference = "oak"'), "reference 'oak' is not one of its models"),
        (('"phones"]', '"fones"]'), "there is no 'fones'; use test, words, phones, ema"),
        (('mean = "mean.toml"', 'mean = "meen.toml"'), r"models.mean: .*meen.toml does not exist"),
        (('x = "leaf"', 'y = "leaf"'), r"sweeps.leaf: there is no key 'y'"),
        (('series = "model"', ""), 'sweeps.amount: needs a recipe, or series = "model" and models in `of`'),
        (("[models]", "[models"), "cannot be read: it is not TOML"),
        (('"babble"', '"babel"'), "conditions.babble, 3 dB: there is no noise 'babel'; use white, babble"),
        (("snr = 3", ""), "conditions.babble, 3 dB: noise needs snr .*; give both or neither"),
        (("voice = 4", "noises = 4"), "conditions.higher: there is no key 'noises'"),
        (("voice = 4", 'voice = "up"'), "conditions.higher: voice is 'up'; take a number"),
        (
            ("conditions.higher", 'conditions."a/b"'),
            "conditions: 'a/b' must contain none of . / |; rename it",
        ),
        (('folds = ["test", ', "folds = ["), "folds: the report needs 'test'; add it"),
        (
            ('words = [["w1"], ["w2"]]', 'words = ["w1"]'),
            r"words is \['w1'\]; take a list, each a list, each a text",
        ),
        (('mean = "mean.toml"', "mean = 3"), "models is .*; take a table, each value a path in quotes"),
        (('corpus = "corpus"', "corpus = 3"), "corpus is 3; take a path in quotes"),
        (("values = [2, 40]", ""), "sweeps.leaf: lacks 'values'; see benchmarks/compare.toml"),
        (("values = [2, 40]", "values = 2"), "sweeps.leaf: values is 2; take a list"),
    ],
)
def test_what_is_wrong_in_a_plan(house: Path, change: tuple[str, str], message: str) -> None:
    path = house / "wrong.toml"
    path.write_text(PLAN.replace(*change))
    with pytest.raises(ModelError, match=message):
        read_plan(path)


def test_a_model_may_be_named(house: Path, root: Path) -> None:
    path = house / "named.toml"
    path.write_text('corpus = "corpus"\nreference = "shipped"\n[models]\nshipped = "default"\n')
    assert read_plan(path).models == {"shipped": root / "phonanim/models/default"}


def test_reports_call_models_as_readers_know_them() -> None:
    document = {"reference": "default", "models": {"default": 1, "tree": 2, "procedural": 3}, "seed": 0}
    shown = with_shown_names(document)
    assert list(shown["models"].items()) == [("phonanim", 1), ("tree", 2), ("dominance (Cohen-Massaro)", 3)]
    assert shown["reference"] == "phonanim"
    assert shown["seed"] == 0


def test_links_of_a_page_in_a_folder_go_up() -> None:
    text = render(["## Title", "See [a](a.md#b) and [c](https://d.org/e.md).", "### Part"])
    assert text.startswith("# Title\n\nSee [a](../a.md#b) and [c](https://d.org/e.md).\n\n## Part\n")


def test_the_ratio_of_deviations_comes_from_sums() -> None:
    curve = np.random.default_rng(0).normal(size=90)
    sums = np.array([pearson_sums(0.5 * part + 3, part) for part in np.split(curve, 3)])
    assert pooled_sd_ratio(sums.sum(axis=0)) == pytest.approx(0.5)
    assert pooled_slope(sums.sum(axis=0)) == pytest.approx(0.5)
    flipped = pearson_sums(-2 * curve, curve)
    assert (pooled_sd_ratio(flipped), pooled_slope(flipped)) == (pytest.approx(2), pytest.approx(-2))


def test_other_tools(tmp_path: Path) -> None:
    clips = {f"clip{n}": {"vertex_error_mm": 1.0 + 0.01 * n, "aperture_r": None} for n in range(12)}
    worse = {name: {**c, "vertex_error_mm": c["vertex_error_mm"] + 0.5} for name, c in clips.items()}
    path = tmp_path / "tools.json"
    path.write_text(json.dumps({"phonanim default": clips, "other": worse}))
    rows = tools.tools_table(tools.read_tools(path), seed=0)
    column = rows[0].index("vertex error, mm")
    assert [row[0] for row in rows] == ["tool", "phonanim, with articulation", "other"]
    assert rows[1][column].startswith("1.055 [1.0")
    assert rows[2][column].startswith("1.555 [")
    assert float(rows[2][column].partition("p ")[2]) < 0.01
    assert rows[1][1] == ""
    path.write_text('{"other": {}}')
    with pytest.raises(ModelError, match=r"has no row 'phonanim default'; make it with benchmarks/tools.py"):
        tools.read_tools(path)
    with pytest.raises(ModelError, match="nothing.json: cannot be read"):
        tools.read_tools(tmp_path / "nothing.json")


def test_a_tool_on_the_first_page_has_size_and_legibility_beside_r() -> None:
    measured = {"aperture_r_speech": 0.8, "aperture_sd_ratio_speech": 0.25, "visemes_right": 0.757}
    clips = {str(n): dict.fromkeys(tools.COLUMNS) | measured for n in range(6)}
    header, row = tools.tools_table({tools.OURS: clips}, seed=0)
    shown = overview._tool_row(header, row)
    assert shown[:4] == ["phonanim, with articulation, on the head", "", "0.800 [0.800, 0.800]", "0.25"]
    assert shown[4:] == ["", "", "", "76% [76%, 76%]", ""]
    assert len(shown) == len(overview.HEADER)


def test_a_report_of_nothing(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"sums.json: cannot be read as a comparison .*; run it first"):
        read_document(tmp_path)
    (tmp_path / "sums.json").write_text('{"models": {}}')
    with pytest.raises(ModelError, match=r"was written by an older version; run the comparison again"):
        read_document(tmp_path)


def test_without_matplotlib_nothing_is_trained(
    house: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["compare", str(house / "plan.toml"), "-o", str(tmp_path / "out")]) == 2
    assert "figures need matplotlib; install it with pip install 'phonanim[plots]'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
