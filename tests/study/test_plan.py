import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from takes import film, folders

from phonanim.__main__ import commands, run
from phonanim.errors import StudyError
from phonanim.study import page, plan, takes
from phonanim.study.page import Wording, write_page
from phonanim.study.plan import plan_trials
from phonanim.study.takes import read_takes, systems_of


def planned(lines, seed=0, **options):
    return plan_trials(lines, np.random.default_rng(seed), **options)


def kinds(trials):
    return [trial.kind for trial in trials]


def pairs(trials):
    return {tuple(take.system for take in trial.takes) for trial in trials if trial.kind == "test"}


def data_of(path):
    return json.loads(re.search(r'id="data">(.*?)</script>', path.read_text("utf-8"), re.DOTALL)[1])


def test_folders_are_systems(tmp_path):
    lines = read_takes(folders(tmp_path))
    assert systems_of(lines) == ("ours", "other")
    assert [line.item for line in lines] == list("abcde")
    assert lines[1].films["other"] == tmp_path / "other" / "b.webm"


def test_a_table_names_systems_and_practice(tmp_path):
    folders(tmp_path)
    kinds_given = {"a": "practice", "b": "", "c": "test"}
    rows = [f"{item},{kind},ours/{item}.webm,other/{item}.webm" for item, kind in kinds_given.items()]
    (tmp_path / "takes.csv").write_text("\n".join(["item,kind,ours,other", rows[0], "", *rows[1:]]))
    lines = read_takes([tmp_path / "takes.csv"])
    assert [(line.item, line.kind) for line in lines] == [("a", "practice"), ("b", "test"), ("c", "test")]
    assert lines[0].films == {"ours": tmp_path / "ours/a.webm", "other": tmp_path / "other/a.webm"}
    assert kinds(planned(lines, controls=2)) == ["practice", "test", "test", "control", "control"]


def refused(tmp_path, *names):
    with pytest.raises(StudyError) as error:
        read_takes([tmp_path / name for name in names])
    return str(error.value).replace(f"{tmp_path}/", "")


def test_takes_that_cannot_be_used(tmp_path):
    folders(tmp_path, items=("a", "b"))
    folders(tmp_path / "again", systems=("ours",))
    (tmp_path / "empty").mkdir()
    assert refused(tmp_path, "ours") == "ours: is one system; a study compares two or more folders"
    assert refused(tmp_path, "ours", "again/ours") == (
        "two folders have the same name; name each after its system"
    )
    assert refused(tmp_path, "ours", "empty") == "empty: has no video (.mp4 .webm)"
    assert refused(tmp_path, "ours", "none") == "none: is not a folder of videos or a table (.csv .tsv)"
    (tmp_path / "other/b.webm").rename(tmp_path / "other/x.webm")
    assert (
        refused(tmp_path, "ours", "other") == "other: has no video b; every folder needs one of the same name"
    )
    (tmp_path / "other/x.webm").rename(tmp_path / "other/a.mp4")
    assert refused(tmp_path, "ours", "other") == "other/a.webm: the folder also has a.mp4; keep one of them"


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "is not an MP4 or WebM video; make it again"),
        (b"\0\0\0\x20ftypisom....vide", "has no audio track; make it with `phonanim animate --audio`"),
        (film().replace(b"A_OPUS", b"A_none"), "has no audio track; make it with `phonanim animate --audio`"),
    ],
)
def test_films_that_cannot_be_used(tmp_path, data, told):
    folders(tmp_path)
    (tmp_path / "other" / "c.webm").write_bytes(data)
    assert refused(tmp_path, "ours", "other") == f"other/c.webm: {told}"


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ("", "takes.csv: needs one column 'item' and one per system; it has "),
        ("item,ours,ours", "takes.csv: needs one column 'item' and one per system; it has item, ours, ours"),
        ("item,kind,ours", "takes.csv: names 1 systems; a study compares two or more"),
        ("item,ours,other", "takes.csv: has no line; give it one row per line"),
        ("item,ours,other\n\na,x.mp4,", "takes.csv row 3: the cell 'other' is empty; fill it in"),
        ("item,kind,x,y\na,odd,x.mp4,y.mp4", "takes.csv row 2: the kind is 'odd'; use one of "
            "test, practice"),
        ("item,ours,other\na,b,c\na,d,e", "takes.csv: the item a is in two rows; name each line once"),
        ("item,ours,other\na,x.avi,y.mp4", "x.avi: browsers play .mp4 and .webm; convert it to one of them"),
        ("item,ours,other\na,x.mp4,y.mp4", "x.mp4: cannot be read: No such file or directory"),
    ],
)  # fmt: skip
def test_tables_that_cannot_be_used(tmp_path, table, told):
    (tmp_path / "takes.csv").write_text(table)
    assert refused(tmp_path, "takes.csv") == told


def test_tables_stand_alone_and_are_text(tmp_path):
    (tmp_path / "takes.csv").write_bytes(b"\xff\xfe\xff")
    assert refused(tmp_path, "takes.csv").startswith("takes.csv: cannot be read as a table: it is not UTF-8")
    told = "takes.csv: a table has all systems; give it alone, or give folders"
    assert refused(tmp_path, "takes.csv", "ours") == told


def test_every_pair_on_every_line_that_is_not_for_practice(tmp_path):
    lines = read_takes(folders(tmp_path, ("x", "y", "z")))
    trials = planned(lines)
    assert kinds(trials) == ["practice"] * 3 + ["test"] * 6 + ["control"] * 3
    assert pairs(trials) == {("x", "y"), ("x", "z"), ("y", "z")}
    assert pairs(planned(lines, ours="y")) == {("y", "x"), ("y", "z")}
    practised = {trial.item for trial in trials if trial.kind == "practice"}
    assert practised.isdisjoint(trial.item for trial in trials if trial.kind == "test")
    assert trials == planned(lines)
    assert {trial.item for trial in planned(lines, seed=1)[:3]} != practised


def test_controls_have_the_sound_of_another_line(tmp_path):
    lines = read_takes(folders(tmp_path))
    for choices, expected, wrong in (("forced", 0, [False, True]), ("none", "none", [True, True])):
        controls = [trial for trial in planned(lines, choices=choices) if trial.kind == "control"]
        for trial in controls:
            assert trial.expected == expected
            assert [take.picture != take.sound for take in trial.takes] == wrong
            assert [take.system == plan.WRONG for take in trial.takes] == wrong
            assert all(take.picture.stem == trial.item for take in trial.takes)
            assert (trial.takes[1].sound.stem == trial.item) is False


def test_plans_that_cannot_be_made(tmp_path):
    lines = read_takes(folders(tmp_path))
    told = (
        "3 lines are too few for 3 practice trials and 3 controls; give more lines, or fewer --practice and"
    )
    with pytest.raises(StudyError, match=told):
        planned(lines[:3])
    with pytest.raises(StudyError, match="there is no system 'mine'; there are ours, other"):
        planned(lines, ours="mine")
    assert kinds(planned(lines[:1], practice=0, controls=0)) == ["test"]


def test_the_page_holds_each_film_once(tmp_path):
    lines = read_takes(folders(tmp_path))
    trials = planned(lines)
    size = write_page(tmp_path / "a.html", trials, Wording(title="</script>{{data}}"))
    data = data_of(tmp_path / "a.html")
    assert size == (tmp_path / "a.html").stat().st_size
    assert len(data["films"]) == len(set(data["films"])) == 10
    assert len(data["trials"]) == len(trials)
    assert data["title"] == "</script>{{data}}"
    text = (tmp_path / "a.html").read_text("utf-8")
    assert text.count("</script>") == 2
    assert "<title>&lt;/script&gt;{{data}}</title>" in text
    assert not re.search(r"""(src|href)\s*=\s*["']""", text)
    again = tmp_path / "b.html"
    write_page(again, trials, Wording(title="</script>{{data}}"))
    assert again.read_bytes() == (tmp_path / "a.html").read_bytes()


def test_pages_that_cannot_be_made(tmp_path, monkeypatch):
    trials = planned(read_takes(folders(tmp_path)))
    with pytest.raises(StudyError, match="--post file:///x: is not a web address; begin it with https://"):
        write_page(tmp_path / "a.html", trials, Wording(post="file:///x"))
    monkeypatch.setattr(page, "MAX_MEGABYTES", 0)
    with pytest.raises(
        StudyError, match="the videos have 0 MB, but a page can have 0: make them smaller, or make two"
    ):
        write_page(tmp_path / "a.html", trials, Wording())
    assert not list(tmp_path.glob("*.html"))


def test_the_scripts_are_those_of_the_folder():
    assert {path.name for path in page.PARTS.glob("*.js")} == set(page.SCRIPTS)
    assert set(takes.TYPES) == {".mp4", ".webm"}


def test_the_command_says_how_many_trials_there_are(tmp_path):
    sources = [str(folder) for folder in folders(tmp_path)]
    arguments = ["study", "make", *sources, "-o", str(tmp_path / "a.html"), "--trials", "1", "--json"]
    told = CliRunner().invoke(commands, arguments)
    assert told.exit_code == 0, told.output
    facts = json.loads(told.stdout)
    assert facts["trials"] == {"practice": 3, "test": 2, "control": 3}
    assert facts["trials_a_participant"] == 7
    assert data_of(tmp_path / "a.html")["limit"] == 1


def test_bad_input_ends_in_one_line(tmp_path, capsys):
    sources = [str(folder) for folder in folders(tmp_path, items=("a",))]
    assert run(["study", "make", *sources, "-o", str(tmp_path / "a.html")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
