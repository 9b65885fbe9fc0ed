"""What the page of a line asks: corrections are kept and the line is made anew, or nothing is changed."""

import base64
import json
import shutil
import socket
import threading
import urllib.error
import urllib.request

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.animation.correction_file import read_corrections
from phonanim.commands.review import lines_of_run
from phonanim.dubbing.review import open_review
from phonanim.dubbing.review_export import export_review
from phonanim.dubbing.review_line import Desk, act, line_page
from phonanim.dubbing.review_server import ReviewServer
from phonanim.dubbing.review_table import review_csv
from phonanim.errors import ConflictError, OptionError, PhonanimError
from phonanim.exporters import load
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

PHONES = [Interval("AA", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2)]
ROWS = ["id,alignment,rig", "one,a.TextGrid,arkit", "two,a.TextGrid,metahuman", "three,a.TextGrid,vrm"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A run of three rigs, with the options of its command."""
    folder = tmp_path_factory.mktemp("run")
    write_textgrid(folder / "a.TextGrid", {"phones": PHONES}, 1.5)
    (folder / "t.csv").write_text("\n".join(ROWS))
    assert run(command(folder)) == 0
    return folder


def command(folder):
    given = [str(folder / "t.csv"), "-o", str(folder / "out"), "--format", "npz", "--fps", "20"]
    return ["batch", *given, "--jaw", "0.9", "--workers", "1", "-q"]


@pytest.fixture
def desk(made, tmp_path):
    shutil.copytree(made, tmp_path / "run")
    out = tmp_path / "run/out"
    review = open_review(out, lines_of_run(made / "out"))
    return Desk(review, review.decisions())


def opened(desk, id):
    """The number of a line and what its page is given."""
    number = [outcome.id for outcome in desk.review.outcomes].index(id)
    page = line_page(desk, number, False, "secret", "Ann")
    return number, json.loads(page.split('type="application/json">')[1].split("</script>")[0])


def asking(number, data, **changes):
    review = data["review"]
    kept = {name: review[name] for name in ("revision", "settings", "style")}
    asked = {"line": number, "who": "Ann", "what": "test", "drawn": {}, "spoken": data["takes"][0]["phones"]}
    return asked | kept | changes


def curve(data, name):
    take = data["takes"][0] if "takes" in data else data["take"]
    values = np.frombuffer(base64.b64decode(take["curves"]), "<f4").reshape(-1, len(take["channels"]))
    return values[:, take["channels"].index(name)]


def test_the_run_is_known_with_its_options(desk):
    assert {line.options.jaw for line in desk.review.lines.values()} == {0.9}
    assert {line.options.fps for line in desk.review.lines.values()} == {20.0}


@pytest.mark.parametrize("id", ["one", "two", "three"])
def test_a_line_is_made_anew_with_what_is_corrected_and_undone(desk, id):
    number, data = opened(desk, id)
    spoken = [list(phone) for phone in data["takes"][0]["phones"]]
    spoken[1][2] = spoken[2][1] = 0.75
    spoken[2][0] = "P"
    settings = {"jaw": 1.4, "closures": [{"kind": "hold", "start": 1.0, "end": 1.2}]}
    settings["emotions"] = [{"name": "joy", "weight": 0.5, "span": [0.9, 1.2]}]
    drawn = {"browInnerUp": [[0.3, 0.4], [0.6, 0.8]]}
    answer = act(desk, "/correct", asking(number, data, spoken=spoken, settings=settings, drawn=drawn))
    assert answer["take"]["phones"] == spoken
    assert answer["review"]["revision"] == 1
    assert answer["review"]["drawn"] == ["browInnerUp"]
    gap = curve(answer, "lip_gap mm")
    assert gap[20:25].max() < 0
    assert curve(data, "lip_gap mm")[20:25].max() > 1
    if id != "three":  # no table leads from ARKit's brows to VRM's shapes, and the line is shown on ARKit
        assert curve(answer, "browInnerUp")[10] == pytest.approx(0.4 + 0.4 * 2 / 3, abs=0.02)
    path = desk.review.folder / f"{id}.corrections.json"
    kept = read_corrections(path)
    assert kept.settings["jaw"] == 1.4
    assert [phone.label for phone in kept.phones.after][2] == "P"
    again = opened(desk, id)[1]
    assert again["takes"][0]["phones"] == spoken
    assert np.array_equal(curve(again, "jawOpen"), curve(answer, "jawOpen"))
    back = act(desk, "/undo", {"line": number, "revision": 1, "who": "Bob"})
    assert not path.exists()
    assert np.array_equal(curve(back, "jawOpen"), curve(data, "jawOpen"))
    assert [event["kind"] for event in back["review"]["events"]] == ["undo", "corrected"]


def test_the_next_batch_has_it(desk, capsys):
    number, data = opened(desk, "one")
    settings = {"gains": {"jawOpen": 0.5}}
    drawn = {"cheekPuff": [[0.2, 0.5], [1, 0.5]]}
    act(desk, "/correct", asking(number, data, settings=settings, drawn=drawn))
    folder = desk.review.folder.parent
    assert run(command(folder)) == 0
    new = load(folder / "out/one.npz")
    assert new.channel("cheekPuff")[12] == pytest.approx(0.5, abs=0.01)
    assert new.channel("jawOpen").max() < 0.6 * curve(data, "jawOpen").max()
    assert run(["audit", str(folder / "t.csv"), "--outputs", str(folder / "out"), "--workers", "1"]) == 0


def test_gains_are_those_of_the_rig_of_the_line(desk):
    number, data = opened(desk, "three")
    assert "aa" in data["review"]["controls"]
    with pytest.raises(OptionError, match="there is no control 'jawOpen' on the rig vrm"):
        act(desk, "/correct", asking(number, data, settings={"gains": {"jawOpen": 0.5}}))
    act(desk, "/correct", asking(number, data, settings={"gains": {"aa": 0.5}}))
    folder = desk.review.folder.parent
    before = load(folder / "out/three.npz").channel("aa").max()
    assert run(command(folder)) == 0
    assert load(folder / "out/three.npz").channel("aa").max() == pytest.approx(before / 2, rel=0.01)


def test_a_line_is_approved_reopened_and_commented(desk):
    number, data = opened(desk, "one")
    asked = {"line": number, "who": "Ann", "text": ""}
    answer = act(desk, "/decide", {**asked, "revision": 0, "status": "approved"})
    assert answer["review"]["status"] == "approved"
    answer = act(desk, "/decide", {**asked, "revision": 1, "text": "=now(): fine"})
    assert answer["review"]["status"] == "approved"
    # who corrects an approved line opens it again
    answer = act(desk, "/correct", asking(number, data, settings={"jaw": 0.5}, revision=2))
    assert answer["review"]["status"] == ""
    act(desk, "/decide", {**asked, "revision": 3, "status": "rejected", "text": "worse"})
    rows = dict(line.split(",", 1) for line in review_csv(desk).splitlines())
    assert rows["one"].startswith("rejected,Ann,")
    assert "Ann: =now(): fine | Ann: worse,test," in rows["one"]
    assert rows["id"] == "decision,who,at,comments,corrections,status,flags,language,rig,seconds,place"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"spoken": [["AA", 0.5, 0.8], ["B", 0.7, 0.9]]}, "phones follow one another"),
        ({"spoken": [["XQZ", 0.5, 0.8]]}, "XQZ"),
        ({"spoken": [["AA", 0.5, 9.8]]}, "phones follow one another"),
        ({"settings": {"language": "klingonese"}}, "klingonese"),
        ({"settings": {"fps": 5}}, "'fps' is not a setting"),
        ({"settings": {"emotions": [{"name": "envy", "weight": 1}]}}, "there is no emotion 'envy'"),
        ({"settings": {"gains": {"jawOpn": 1}}}, "jawOpn"),
        ({"drawn": {"jawOpn": [[0.1, 0.5], [0.2, 0.5]]}}, "there is no curve 'jawOpn'"),
        ({"drawn": {"jawOpen": [[0.2, 0.5], [0.1, 0.5]]}}, "not in order"),
        ({"revision": -1}, "revision is -1"),
        ({"line": 99}, "line is 99"),
        ({"drawn": None}, "curves"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_kept(desk, changes, message):
    number, data = opened(desk, "one")
    with pytest.raises(PhonanimError, match=message):
        act(desk, "/correct", asking(number, data, **changes))
    assert not (desk.review.folder / "one.corrections.json").exists()
    assert desk.decisions.states() == {}


def test_two_people_do_not_lose_each_others_work(desk):
    number, data = opened(desk, "one")
    act(desk, "/correct", asking(number, data, settings={"jaw": 0.5}))
    with pytest.raises(ConflictError, match="Ann was faster"):
        act(desk, "/correct", asking(number, data, settings={"jaw": 2.0}, who="Bob"))
    assert read_corrections(desk.review.folder / "one.corrections.json").settings == {"jaw": 0.5}


def test_lines_without_their_source_are_decided_on_but_not_corrected(desk):
    review = open_review(desk.review.folder)
    other = Desk(review, review.decisions())
    number, data = opened(desk, "one")
    assert "review" not in opened(other, "one")[1]
    with pytest.raises(OptionError, match="give --source to correct it"):
        act(other, "/correct", asking(number, data))
    assert act(
        other, "/decide", {"line": number, "who": "A", "text": "", "revision": 0, "status": "approved"}
    )


def post(server, path, body, **headers):
    given = {"X-Phonanim-Token": "secret", "Content-Type": "application/json", **headers}
    address = f"http://127.0.0.1:{server.server_port}{path}"
    try:
        with urllib.request.urlopen(urllib.request.Request(address, body, given)) as answer:
            return answer.status, json.loads(answer.read())
    except urllib.error.HTTPError as error:
        return error.code, json.loads(error.read())


def test_the_server_takes_corrections_of_those_with_the_token_alone(desk):
    number, data = opened(desk, "one")
    body = json.dumps(asking(number, data, settings={"jaw": 0.5})).encode()
    with ReviewServer(desk.review, "secret") as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            for headers in (
                {"X-Phonanim-Token": "other"},
                {"X-Phonanim-Token": ""},
                {"Origin": "http://elsewhere.org"},
                {"Origin": "null"},
                {"Host": "elsewhere.org"},
            ):
                assert post(server, "/correct", body, **headers)[0] == 403
            assert post(server, "/list.csv", body)[0] == 404
            assert post(server, "/../correct", body)[0] == 404
            assert post(server, "/correct", b"{")[0] == 400
            assert post(server, "/correct", b"[]")[0] == 400
            assert desk.decisions.states() == {}
            assert post(server, "/correct", body)[1]["review"]["revision"] == 1
            status, answer = post(server, "/correct", body)
            assert status == 409
            assert "was faster" in answer["error"]
            news = urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/news?after=0&token=secret")
            assert json.loads(news.read())["states"] == {"one": {"revision": 1, "status": "", "comments": 0}}
            with socket.create_connection(("127.0.0.1", server.server_port), timeout=20) as client:
                head = f"POST /correct HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\n"
                client.sendall(f"{head}Content-Length: 9000000\r\n\r\n".encode() + bytes(2**16))
                assert b" 403 " in client.recv(100)  # before the rest has come
            large = {"Content-Length": str(2**30)}
            assert post(server, "/correct", b"{}", **large)[0] == 413
        finally:
            server.shutdown()
            thread.join()


def test_a_review_is_sent_as_pages_that_need_no_server(desk, made, tmp_path, capsys):
    number, data = opened(desk, "one")
    act(desk, "/correct", asking(number, data, settings={"jaw": 0.5}))
    act(
        desk,
        "/decide",
        {"line": number, "who": "Ann", "text": "</script>", "revision": 1, "status": "rejected"},
    )
    out, sent = desk.review.folder, tmp_path / "sent"
    assert export_review(desk, sent) == 3
    index = (sent / "index.html").read_text()
    listed = json.loads(index.split('type="application/json">')[1].split("</script>")[0])
    assert listed["fixed"] is True
    assert "token" not in listed
    assert [line["said"] for line in listed["lines"] if line["id"] == "one"] == ["Ann: </script>"]
    page = (sent / "lines" / f"{number}.html").read_text()
    assert '<script src="../head0.js"></script>\n<script src="../viewer.js"></script>' in page
    assert "script-src 'self' file:;" in page
    take = json.loads(page.split('type="application/json">')[1].split("</script>")[0])
    assert curve(take, "jawOpen").max() < 0.7 * curve(data, "jawOpen").max()
    assert sorted(path.name for path in sent.iterdir()) == [
        "head0.js",
        "index.html",
        "lines",
        "review.csv",
        "viewer.js",
    ]
    shutil.copy(made / "out/run.json", out)
    given = ["review", str(made / "out"), "--export"]
    assert run([*given, str(tmp_path / "some"), "--only", "rejected", "-q"]) == 0
    assert not list((tmp_path / "some/lines").iterdir())
    assert run([*given, str(made / "out/sent")]) == 2
    assert "is inside the run" in capsys.readouterr().err


def test_a_line_that_failed_is_corrected_until_it_can_be_made(tmp_path):
    odd = [Interval("PT", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("QQZ", 0.9, 1.2)]
    (tmp_path / "lines").mkdir()
    write_textgrid(tmp_path / "lines/odd.TextGrid", {"phones": odd}, 1.5)
    batch = ["batch", str(tmp_path / "lines"), "-o", str(tmp_path / "out"), "--format", "npz", "-q"]
    assert run([*batch, "--language", "english", "--workers", "1"]) == 1
    review = open_review(tmp_path / "out", lines_of_run(tmp_path / "out"))
    desk = Desk(review, review.decisions())
    number, data = opened(desk, "odd")
    assert 'no phone "PT" in language english' in data["review"]["notes"][0]
    spoken = [list(phone) for phone in data["takes"][0]["phones"]]
    spoken[1][0] = "T"
    answer = act(desk, "/correct", asking(number, data, spoken=spoken))
    assert 'no phone "QQZ"' in answer["review"]["notes"][0]
    spoken[3][0] = "IY"
    answer = act(desk, "/correct", asking(number, data, spoken=spoken, revision=1))
    assert answer["review"]["notes"] == []
    assert run([*batch, "--language", "english", "--workers", "1"]) == 0
    with pytest.raises(OptionError, match='no phone "XQ"'):
        spoken[3][0] = "XQ"
        act(desk, "/correct", asking(number, data, spoken=spoken, revision=2))


def test_a_line_of_an_unknown_language_is_given_one(tmp_path):
    (tmp_path / "lines").mkdir()
    write_textgrid(tmp_path / "lines/a.TextGrid", {"phones": PHONES}, 1.5)
    (tmp_path / "t.csv").write_text("id,alignment,language\na,lines/a.TextGrid,klingonese")
    batch = ["batch", str(tmp_path / "t.csv"), "-o", str(tmp_path / "out"), "--format", "npz", "-q"]
    assert run([*batch, "--workers", "1"]) == 1
    review = open_review(tmp_path / "out", lines_of_run(tmp_path / "out"))
    desk = Desk(review, review.decisions())
    number, data = opened(desk, "a")
    assert "klingonese" in data["review"]["notes"][0]
    answer = act(desk, "/correct", asking(number, data, settings={"language": "english"}))
    assert answer["review"]["notes"] == []
    assert run([*batch, "--workers", "1"]) == 0
