"""Studies in a real browser: what is clicked is what is downloaded, posted and counted."""

import json
import shutil
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from takes import folders

from phonanim.__main__ import run
from phonanim.study.results import read_results, screen_answers
from phonanim.study.tally import count_answers

pytestmark = pytest.mark.skipif(
    not (shutil.which("chromium") or shutil.which("google-chrome")), reason="needs chromium or google-chrome"
)


def make(tmp_path, *options):
    sources = map(str, folders(tmp_path / "takes"))
    assert run(["study", "make", *sources, "-o", str(tmp_path / "a.html"), "-q", *options]) == 0
    return tmp_path / "a.html"


def take_part(root, page, *options):
    """The answers that the page lets one download."""
    script = [sys.executable, str(root / "scripts" / "check_study.py"), str(page)]
    done = subprocess.run(
        [*script, "-o", str(page.parent / "results"), "--speed", "4", *options],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads((page.parent / "results" / done.stdout.strip().rpartition("/")[2]).read_text("utf-8"))


@pytest.mark.slow
def test_from_the_first_click_to_the_table(tmp_path, root):
    page = make(tmp_path, "--choices", "none", "--ours", "ours")
    good = take_part(root, page, "--participant", "good", "--prefer", "ours")
    take_part(root, page, "--participant", "careless", "--careless")
    assert [answer["kind"] for answer in good["answers"]][:3] == ["practice"] * 3
    assert sorted(answer["kind"] for answer in good["answers"][3:]) == ["control"] * 3 + ["test"] * 2
    assert all(answer["plays"] == {"left": 1, "right": 1} for answer in good["answers"])
    kept, excluded = screen_answers(read_results([tmp_path / "results"]))
    assert [one.name for one in kept] == ["good"]
    assert [one.reason for one in excluded] == ["failed 3 controls"]
    assert [(tally.wins, tally.losses) for tally in count_answers(kept, "ours")] == [(1, 0), (1, 0)]
    assert all((tmp_path / "results" / f"{name}.png").stat().st_size > 5000 for name in ("welcome", "trial"))


@pytest.mark.slow
def test_order_and_sides_are_those_of_the_participant(tmp_path, root):
    page = make(tmp_path, "--practice", "0", "--controls", "0", "--no-rating", "--trials", "4")
    shown = {}
    for number, name in enumerate(["p", "q", "p"]):
        answers = take_part(root, page, "--participant", name)["answers"]
        shown[number] = [(answer["item"], answer["left"], answer["right"]) for answer in answers]
        assert all(answer["rating"] is None for answer in answers)
    assert shown[0] == shown[2] != shown[1]
    assert {left for order in shown.values() for _, left, _ in order} == {"ours", "other"}


def test_answers_are_posted(tmp_path, root):
    received = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            received.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.send_header("Access-Control-Allow-Origin", "*")
            self.end_headers()

        def log_message(self, *args):
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/answers"
        downloaded = take_part(root, make(tmp_path, "--practice", "0", "--post", address, "--trials", "1"))
        server.shutdown()
    assert received == [downloaded]
    assert len(downloaded["answers"]) == 4


@pytest.mark.slow
def test_several_questions_about_a_pair(tmp_path, root):
    few = ["--practice", "0", "--controls", "0", "--trials", "3"]
    asked = ["--question", "Whose lips fit?", "--question", "Who is real?"]
    page = make(tmp_path, *few, *asked)
    take_part(root, page, "--participant", "p", "--prefer", "ours")
    (one,) = read_results([tmp_path / "results"])
    assert one.questions == ("Whose lips fit?", "Who is real?")
    assert all(len(answer.choices) == 2 and answer.rating == 4 for answer in one.answers)
    assert {tally.group for tally in count_answers([one], "ours")} == set(one.questions)
