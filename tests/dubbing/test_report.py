import html.parser
import json

from phonanim.dubbing.causes import find_causes
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.report import count_totals, headline, text_summary, worst_first, write_reports


def done(id, *flags):
    facts = {
        "frames": 10,
        "seconds": 2.0,
        "phones": 4,
        "flags": [{"check": name, "severity": severity, "text": f"<{name}>"} for name, severity in flags],
    }
    return Outcome(id, f"row of {id}", {"version": "1"}, {f"{id}.csv": "hash"}, facts)


OUTCOMES = [
    done("good"),
    done("poor", ("speed", 0.2), ("length", 0.3)),
    Outcome("bad & ugly", "row 4", error="x.TextGrid: is empty"),
    done("worse", ("closures", 0.9)),
]


class Cells(html.parser.HTMLParser):
    """The text of every cell."""

    def __init__(self, page):
        super().__init__()
        self.cells, self.inside = [], False
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.inside = tag == "td"

    def handle_data(self, data):
        if self.inside:
            self.cells.append(data)
            self.inside = False


def test_the_worst_come_first():
    assert [outcome.id for outcome in worst_first(OUTCOMES)] == ["bad & ugly", "worse", "poor", "good"]


def test_totals():
    totals = count_totals(OUTCOMES)
    assert totals == {
        **{"lines": 4, "done": 3, "failed": 1, "flagged": 2, "seconds": 6.0, "frames": 30},
        "flags": {"closures": 1, "length": 1, "speed": 1},
        "languages": {},
    }
    assert headline(totals) == (
        "4 lines: 3 done (0.1 min, 30 frames), 1 failed, 2 flagged (closures 1, length 1, speed 1)"
    )


def test_the_page_shows_every_line_as_text(tmp_path):
    write_reports(tmp_path, OUTCOMES, ["the column 'x<y' is not used"])
    page = (tmp_path / "report.html").read_text("utf-8")
    cells = Cells(page).cells
    assert cells[0] == "bad & ugly"
    assert "closures: <closures>" in cells
    assert "the column &#x27;x&lt;y&#x27; is not used" in page
    assert page.count("<tr class=") == 4


def test_the_json_has_no_origins(tmp_path):
    write_reports(tmp_path, OUTCOMES, [])
    report = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert [line["id"] for line in report["lines"]] == ["bad & ugly", "worse", "poor", "good"]
    assert all("origin" not in line for line in report["lines"])


def test_the_summary_stops_after_the_worst():
    many = [done(f"{number:03}", ("speed", 0.5)) for number in range(50)]
    lines = text_summary(count_totals(many), worst_first(many), ["a remark"]).splitlines()
    assert lines[1] == "a remark"
    assert lines[2] == "50 lines: speed, such as 000: <speed>"
    assert lines[3:6] == ["", "the worst lines:", "000: speed: <speed>"]
    assert lines[-1] == "... and 30 more: see report.html"
    assert len(lines) == 3 + 2 + 20 + 1


def test_how_lines_came_to_be_done_is_told_where_it_is_known():
    assert headline(count_totals(OUTCOMES), "1 made, 2 kept").startswith("4 lines: 1 made, 2 kept (0.1 min")


def test_equal_failures_are_one_line_with_their_rows():
    failed = [Outcome(f"l{n}", f"t.csv row {n}", error=f"t.csv row {n}: no rig") for n in (2, 3, 4, 9)]
    own = [Outcome(f"f{n}", f"a/{n}.lab", error=f"/x/{n}.lab: is empty") for n in range(7)]
    summary = text_summary(count_totals(failed), worst_first([*failed, *own]), [])
    assert "4 lines failed: no rig (t.csv rows 2-4, 9)\n" in summary
    assert "7 lines failed: is empty (a/0.lab, a/1.lab, a/2.lab, a/3.lab, a/4.lab and 2 more)\n" in summary
    assert summary.count("no rig") == 1


def test_many_causes_are_cut():
    failed = [Outcome(f"l{n}", f"t.csv row {n}", error=f"t.csv row {n}: no rig {n:02}") for n in range(40)]
    lines = text_summary(count_totals(failed), failed, []).splitlines()
    assert len(lines) == 1 + 30 + 1
    assert lines[-1] == "... and 10 more causes: see report.json"


def test_flags_are_ranked_by_how_likely_they_are_seen():
    lines = [
        done("labels", ("labels", 1.0)),
        done("silence", ("silence", 0.5)),
        done("speed", ("speed", 0.8)),
    ]
    assert [outcome.id for outcome in worst_first(lines)] == ["silence", "speed", "labels"]
    assert [cause.check for cause in find_causes(lines)] == ["silence", "speed", "labels"]


def test_labels_are_grouped_by_what_was_done_with_them():
    first = done("a", ("labels", 0.4))
    first.facts["flags"][0]["text"] = (
        '"zz" at 1.00 s: shown as silence; "qq" at 2.00 s and 3 more: shown as k'
    )
    second = done("b", ("labels", 0.2))
    second.facts["flags"][0]["text"] = '"zz" at 7.50 s: shown as silence'
    causes = {cause.what: cause for cause in find_causes([first, second])}
    assert causes['"zz": shown as silence'].ids == ("a", "b")
    assert causes['"qq": shown as k'].ids == ("a",)
    assert 'such as a: "zz" at 1.00 s' in str(causes['"zz": shown as silence'])
