import html.parser
import json

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
    assert lines[2] == "000: speed: <speed>"
    assert lines[-1] == "... and 30 more: see report.html"
    assert len(lines) == 2 + 20 + 1
