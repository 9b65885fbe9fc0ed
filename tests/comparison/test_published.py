"""Rows of a published comparison beside a model of one's own."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from speech import made_up_corpus

from phonanim.commands.compare import command
from phonanim.comparison.plan import read_plan
from phonanim.comparison.published import add_published
from phonanim.comparison.report import read_document, with_shown_names
from phonanim.comparison.run import model_rows
from phonanim.comparison.tables import differences_table
from phonanim.corpus.corpus import save_corpus
from phonanim.errors import ModelError

PLAN = 'corpus = "corpus"\nreference = "{0}"\nfolds = ["test"]\n{1}\n[models]\n{0} = "{0}.toml"\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two comparisons of one model each; the second names the sums of the first."""
    pytest.importorskip("sklearn")
    pytest.importorskip("matplotlib")
    made = tmp_path_factory.mktemp("published")
    save_corpus(made_up_corpus(np.random.default_rng(3)), made / "corpus")
    (made / "theirs.toml").write_text('kind = "tree"\ncorpus = "corpus"\n[settings]\nleaf = 4\n')
    (made / "mine.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    (made / "first.toml").write_text(PLAN.format("theirs", ""))
    (made / "second.toml").write_text(PLAN.format("mine", 'published = "first/benchmark/test_sums.json"'))
    for name in ("first", "second"):
        run(made, name)
    return made


def run(folder: Path, name: str, *arguments: str) -> None:
    words = [str(folder / f"{name}.toml"), "-o", str(folder / name), "--workers", "1", "--quiet", *arguments]
    found = CliRunner().invoke(command, words)
    assert found.exit_code == 0, found.output


def test_a_published_model_stands_in_the_tables_untrained(folder: Path) -> None:
    page = (folder / "second/benchmark.md").read_text()
    first = (folder / "first/benchmark.md").read_text()
    row = next(line for line in first.splitlines() if line.startswith("| theirs"))
    assert [line for line in page.splitlines() if line.startswith("| theirs")] == [row]
    assert "| mine |" in page
    assert "From `test_sums.json`, trained and timed elsewhere: `theirs`." in page
    assert not list((folder / "second/models").glob("theirs*"))
    assert "trained and timed elsewhere" in (folder / "second/benchmark/cost.md").read_text()


def test_the_test_between_them_is_that_of_one_comparison(folder: Path) -> None:
    (folder / "both.toml").write_text(PLAN.format("mine", "") + 'theirs = "theirs.toml"\n')
    run(folder, "both")
    apart = with_shown_names(read_document(folder / "second/models"))
    together = with_shown_names(read_document(folder / "both/models"))
    tables = [
        differences_table(found, "raw", "test/speech", ("shape_mse", "aperture_r"))
        for found in (apart, together)
    ]
    assert tables[0] == tables[1]
    assert tables[0][1][0] == "theirs"
    ours, theirs = (model_rows(found, "theirs", "raw", "test/all") for found in (apart, together))
    assert ours
    assert theirs
    np.testing.assert_allclose(ours["shape_mse"], theirs["shape_mse"], rtol=1e-5)


def test_a_report_can_be_written_again_and_published_further(folder: Path) -> None:
    page = (folder / "second/benchmark.md").read_text()
    run(folder, "second", "--report-only")
    assert (folder / "second/benchmark.md").read_text() == page
    found = json.loads((folder / "second/benchmark/test_sums.json").read_text())
    assert list(found["models"]) == ["mine", "theirs"]
    assert list(found["folds"]) == ["test"]


def test_other_clips_are_refused_before_anything_is_trained(folder: Path, tmp_path: Path) -> None:
    corpus = made_up_corpus(np.random.default_rng(3))
    clips = tuple(f"other_{name}" for name in corpus.clips)
    save_corpus(replace(corpus, clips=clips), tmp_path / "corpus")
    (tmp_path / "mine.toml").write_text('kind = "phone_mean"\ncorpus = "corpus"\n')
    sums = (folder / "first/benchmark/test_sums.json").as_posix()
    (tmp_path / "plan.toml").write_text(PLAN.format("mine", f'published = "{sums}"'))
    found = CliRunner().invoke(command, [str(tmp_path / "plan.toml"), "-o", str(tmp_path / "out")])
    assert isinstance(found.exception, ModelError)
    assert re.search(r"test_sums.json: published: its models have other test clips", str(found.exception))
    assert not list((tmp_path / "out").rglob("*.safetensors"))


def test_what_is_no_published_comparison(folder: Path, tmp_path: Path) -> None:
    document = read_document(folder / "second/models")
    with pytest.raises(ModelError, match=r"test_sums.json: published: has a model 'theirs' too; rename it"):
        add_published(document, folder / "first/benchmark/test_sums.json")
    for text in ("{", "[]", '{"folds": {"test": {}}, "models": {"a": {}}}'):
        (tmp_path / "wrong.json").write_text(text)
        with pytest.raises(ModelError, match=r"wrong.json: published: cannot be read as sums"):
            add_published(document, tmp_path / "wrong.json")
    found = json.loads((folder / "first/benchmark/test_sums.json").read_text())
    found["models"] = {"empty": {"scores": {"raw": {}}, "driven_by": "phones"}}
    (tmp_path / "wrong.json").write_text(json.dumps(found))
    with pytest.raises(ModelError, match="a model has no sums of the test clips"):
        add_published(document, tmp_path / "wrong.json")
    assert read_plan(folder / "second.toml").published == folder / "first/benchmark/test_sums.json"
