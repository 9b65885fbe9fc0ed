import json

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.errors import StudyError
from phonanim.evaluation.statistics import sign_test
from phonanim.study.analysis import compare_systems, rate_systems
from phonanim.study.results import FORMAT, read_results, screen_answers
from phonanim.study.tally import Tally, count_answers, read_counts

TAYLOR = "examples/taylor2017_judgements.csv"


def rng():
    return np.random.default_rng(0)


def answer(choice="left", **changed):
    plain = {"item": "a", "kind": "test", "left": "ours", "right": "other", "choice": choice}
    return {**plain, "rating": 4, "expected": None, **changed}


def control(choice, rating=4, expected="left"):
    return answer(choice, kind="control", right="wrong", rating=rating, expected=expected)


def saved(folder, name, *answers, **changed):
    document = {"format": FORMAT, "study": "s", "participant": name, "ended": "2026-01-01", "choices": "none"}
    (folder / f"{name}.json").write_text(json.dumps({**document, "answers": answers, **changed}))


# Table 1 and Table 2 of Taylor 2017: won and lost sentences.
PRINTED = {
    ("KB-2k", "HMM"): (39, 11),
    ("KB-2k", "DV"): (50, 0),
    ("KB-2k", "LSTM"): (50, 0),
    ("KB-2k", "DTree"): (38, 12),
    ("novel speakers", "HMM"): (19, 5),
    ("novel speakers", "DV"): (24, 0),
    ("novel speakers", "LSTM"): (24, 0),
    ("novel speakers", "DTree"): (15, 9),
}
# Where the raw judgements do not give what the tables say: lists that are too short, and two that disagree.
DIFFERENT = {
    ("KB-2k", "HMM"): (38, 12),
    ("KB-2k", "DV"): (41, 0),
    ("KB-2k", "LSTM"): (42, 0),
    ("KB-2k", "DTree"): (35, 15),
    ("novel speakers", "LSTM"): (23, 0),
}


def test_the_published_judgements_give_the_published_tables(root):
    found = {(one.group, one.other): one for one in compare_systems(read_counts(root / TAYLOR), rng())}
    counted = {pair: (one.won, one.lost) for pair, one in found.items()}
    assert counted == PRINTED | DIFFERENT
    assert all(one.drawn == 0 and one.judgements == 25 * one.lines for one in found.values())
    # "All results are statistically significant": not the decision tree on novel speakers.
    weak = [pair for pair, one in found.items() if one.p_lines >= 0.05]
    assert weak == [("novel speakers", "DTree")]
    assert sign_test(27, 23) > 0.5  # the comparison with the ground truth, of which no judgements are printed


def test_the_command_prints_the_tables(root, tmp_path, capsys):
    assert run(["study", "analyse", str(root / TAYLOR)]) == 0
    printed = capsys.readouterr().out
    assert "| network vs HMM | 24 | 19 / 5 | 0 | 600 | 0 | 60.5 % |" in printed
    assert "participants" not in printed
    assert run(["study", "analyse", str(root / TAYLOR), "-o", str(tmp_path / "a.md"), "-q"]) == 0
    assert (tmp_path / "a.md").read_text() == printed
    assert run(["study", "analyse", str(root / TAYLOR), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["comparisons"][4]["won"] == 24


def test_a_hand_worked_comparison():
    tallies = [
        Tally("", "x", "y", "a", 3, 1),
        Tally("", "x", "y", "b", 2, 2, 1),
        Tally("", "x", "y", "c", 4, 0),
    ]
    (one,) = compare_systems(tallies, rng())
    assert (one.won, one.lost, one.drawn, one.judgements, one.neither) == (2, 0, 1, 12, 1)
    assert one.preference == 9 / 12
    assert one.p_lines == one.p_holm == 0.5
    assert one.p_judgements == pytest.approx(2 * (1 + 12 + 66 + 220) / 4096)
    assert one.interval[0] == 0.5
    assert one.interval[1] == 1.0


def test_pairs_of_a_group_are_corrected_together():
    tallies = [
        Tally(group, "x", other, str(line), 5, 0) for group in "gh" for other in "yz" for line in range(6)
    ]
    assert {one.p_lines for one in compare_systems(tallies, rng())} == {1 / 32}
    assert {one.p_holm for one in compare_systems(tallies, rng())} == {1 / 16}
    nobody = compare_systems([Tally("", "x", "y", "a", 0, 0, 3)], rng())[0]
    assert np.isnan(nobody.preference)
    assert nobody.p_lines == 1


def test_answers_are_counted_whatever_the_side(tmp_path):
    saved(tmp_path, "p", answer("left"), answer("left", left="other", right="ours"))
    saved(tmp_path, "q", answer("none"), answer("right", item="b", rating=2))
    people = read_results([tmp_path])
    assert count_answers(people, "ours") == (
        Tally("", "ours", "other", "a", 1, 1, 1),
        Tally("", "ours", "other", "b", 0, 1, 0),
    )
    assert count_answers(people)[1] == Tally("", "other", "ours", "b", 1, 0, 0)
    with pytest.raises(StudyError, match="there is no system 'mine'; there are other, ours"):
        count_answers(people, "mine")


def test_practice_and_controls_are_not_counted(tmp_path):
    saved(tmp_path, "p", answer(kind="practice"), control("left"), answer())
    people = read_results([tmp_path / "p.json"])
    assert [(tally.wins, tally.losses) for tally in count_answers(people, "ours")] == [(1, 0)]
    assert sum(one.ratings for one in rate_systems(people, rng())) == 1


def test_ratings_are_those_of_the_chosen(tmp_path):
    for name, stars in (("p", 5), ("q", 3)):
        saved(
            tmp_path, name, answer("left", rating=stars), answer("right", rating=1), answer("none", rating=1)
        )
    other, ours = rate_systems(read_results([tmp_path]), rng(), "ours")
    assert (ours.ours, ours.other, ours.system, ours.ratings, ours.mean) == ("ours", "other", "ours", 2, 4.0)
    assert ours.interval == (3.0, 5.0)
    assert (other.system, other.mean, other.interval) == ("other", 1.0, (1.0, 1.0))


def test_who_does_not_count(tmp_path):
    saved(tmp_path, "good", control("left"), control("none", 1, "none"), answer())
    saved(tmp_path, "careless", control("right"), control("left", 1, "none"), control("none", 3, "none"))
    saved(tmp_path, "left early", answer(), ended=None)
    saved(tmp_path, "again", answer(), participant="good", ended="2026-02-01")
    kept, excluded = screen_answers(read_results([tmp_path]))
    assert [one.name for one in kept] == ["good"]
    assert {(one.name, one.reason) for one in excluded} == {
        ("careless", "failed 3 controls"),
        ("left early", "did not finish"),
        ("good", "answered more than once; the first counts"),
    }
    kept, _ = screen_answers(read_results([tmp_path]), allowed=3)
    assert [one.name for one in kept] == ["careless", "good"]


def test_the_command_names_who_was_left_out(tmp_path, capsys):
    saved(tmp_path, "good", answer())
    saved(tmp_path, "careless", control("right"), answer())
    assert run(["study", "analyse", str(tmp_path), "--ours", "ours"]) == 0
    assert capsys.readouterr().out.endswith("1 participants; left out: 1\n- careless: failed 1 controls\n")
    assert run(["study", "analyse", str(tmp_path / "careless.json")]) == 2
    assert "no answers count: careless failed 1 controls" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[", "cannot be read: it is not JSON: Expecting value"),
        ("[]", "has no answers of a study; its format is not 'phonanim study result 1'"),
        (json.dumps({"format": FORMAT}), r"is damaged \(KeyError\('answers'\)\); ask for it again"),
    ],
)
def test_answers_that_cannot_be_read(tmp_path, text, told):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(StudyError, match=rf"a\.json: {told}"):
        read_results([tmp_path])


def test_answers_that_make_no_sense(tmp_path):
    with pytest.raises(StudyError, match=r"has no answers \(\.json\)"):
        read_results([tmp_path])
    saved(tmp_path, "p", answer("equal"))
    with pytest.raises(StudyError, match="answer 1 chooses 'equal'"):
        read_results([tmp_path])
    saved(tmp_path, "p", answer(rating=6))
    with pytest.raises(StudyError, match="answer 1 gives 6 stars"):
        read_results([tmp_path])
    saved(tmp_path, "p", answer())
    saved(tmp_path, "q", answer(), study="t")
    with pytest.raises(StudyError, match=r"the answers are of several studies \(s, t\); analyse each alone"):
        read_results([tmp_path])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "group,ours\n",
            "cannot be read: it has no column 'other'; its first line needs group,ours,other,item",
        ),
        ("group,ours,other,item,for,against\n", "has no counts; give it one row per line and pair"),
        ("# remark\ngroup,ours,other,item,for,against\n\n,x,y,1,-1,2", "row 4: 'for' and 'against' must be"),
        ("group,ours,other,item,for,against\n,x,y,1,a,2", "row 2: 'for' and 'against' must be whole numbers"),
        ("group,ours,other,item,for,against\n,x,y,1,3", "row 2: 'for' and 'against' must be whole numbers"),
    ],
)
def test_counts_that_cannot_be_read(tmp_path, text, told):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(StudyError, match=rf"a\.csv:? {told}"):
        read_counts(tmp_path / "a.csv")


def test_counts_stand_alone(tmp_path, root, capsys):
    with pytest.raises(StudyError, match=r"a\.csv: cannot be read: .*No such file"):
        read_counts(tmp_path / "a.csv")
    assert run(["study", "analyse", str(root / TAYLOR), str(tmp_path)]) == 2
    assert "counts must be in one CSV file; give it alone" in capsys.readouterr().err
