"""Several questions about a pair: on the page, in the answers, and in the analysis."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from takes import folders

from phonanim.__main__ import run
from phonanim.errors import StudyError
from phonanim.study.analysis import compare_systems
from phonanim.study.page import Wording, write_page
from phonanim.study.plan import plan_trials
from phonanim.study.results import FORMAT, read_results
from phonanim.study.takes import read_takes
from phonanim.study.tally import count_answers

ASKED = ["Whose lips fit?", "Who is more real?", "Whose mood fits?"]


def answer(item: str, *choices: str, **changed: Any) -> dict[str, Any]:
    plain = {"item": item, "kind": "test", "left": "ours", "right": "other", "rating": 4, "expected": None}
    return {**plain, "choice": choices[0], "choices": list(choices), **changed}


def saved(folder: Path, name: str, *answers: dict[str, Any], **changed: Any) -> Path:
    document = {"format": FORMAT, "study": "s", "participant": name, "ended": "2026-01-01", "choices": "none"}
    path = folder / f"{name}.json"
    path.write_text(json.dumps({**document, "questions": ASKED, "answers": answers, **changed}))
    return path


def test_the_page_has_every_question(tmp_path: Path) -> None:
    options = [part for text in ASKED for part in ("--question", text)]
    sources = [str(folder) for folder in folders(tmp_path / "takes")]
    assert run(["study", "make", *sources, "-o", str(tmp_path / "a.html"), "-q", *options]) == 0
    page = (tmp_path / "a.html").read_text("utf-8")
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])  # type: ignore[index]
    assert data["questions"] == ASKED


def test_each_question_is_counted_and_corrected_alone(tmp_path: Path) -> None:
    for person in ("a", "b", "c"):
        rows = [answer(f"line{n}", "left", "right" if person != "c" else "left", "none") for n in range(8)]
        saved(tmp_path, person, *rows)
    tallies = count_answers(read_results([tmp_path]), "ours")
    found = {one.group: one for one in compare_systems(tallies, np.random.default_rng(0))}
    assert list(found) == ASKED
    assert [(found[text].won, found[text].lost) for text in ASKED] == [(8, 0), (0, 8), (0, 0)]
    assert found[ASKED[1]].preference == pytest.approx(1 / 3)
    assert found[ASKED[2]].neither == 24
    assert found[ASKED[0]].p_holm == found[ASKED[0]].p_lines  # one pair, so nothing to correct for


def test_the_report_has_a_table_for_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    saved(tmp_path, "a", *(answer(f"line{n}", "left", "right", "left") for n in range(4)))
    assert run(["study", "analyse", str(tmp_path), "--ours", "ours"]) == 0
    out = capsys.readouterr().out
    assert [out.count(f"**{text}**") for text in ASKED] == [1, 1, 1]
    assert out.count("| ours vs other | 4 |") == 3


def test_answers_of_one_question_are_as_before(tmp_path: Path) -> None:
    old = answer("line", "left")
    del old["choices"]
    path = saved(tmp_path, "a", old)
    document = json.loads(path.read_text())
    del document["questions"]
    path.write_text(json.dumps(document))
    (one,) = read_results([path])
    assert one.questions == ()
    assert [tally.group for tally in count_answers([one])] == [""]


@pytest.mark.parametrize("choices", [("left",), ("left", "right", "left", "left"), ("left", "up", "left")])
def test_answers_that_do_not_fit_the_questions(choices: tuple[str, ...], tmp_path: Path) -> None:
    path = saved(tmp_path, "a", answer("line", *choices))
    with pytest.raises(StudyError, match=r"a\.json: is damaged"):
        read_results([path])


def test_questions_must_differ(tmp_path: Path) -> None:
    trials = plan_trials(read_takes(folders(tmp_path / "takes")), np.random.default_rng(0))
    for questions in (("One?", "One?"), ("One?", " ")):
        with pytest.raises(StudyError, match="--question: each must be another text"):
            write_page(tmp_path / "a.html", trials, Wording(questions=questions))
