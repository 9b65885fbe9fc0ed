"""The review of a run: its list, its viewer pages, and whom the server refuses."""

import json
import re
import shutil
import socket
import struct
import threading
import urllib.error
import urllib.request

import pytest

from phonanim.__main__ import run
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.review import delivered_page, list_page, open_review
from phonanim.dubbing.review_server import ReviewServer
from phonanim.dubbing.row import Common
from phonanim.errors import OptionError
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

PHONES = [Interval("AA", 0.5, 0.8), Interval("B", 0.8, 0.9), Interval("IY", 0.9, 1.2)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, root):
    """A run of a table with lines on two rigs, one with sound, and a row without a character."""
    folder = tmp_path_factory.mktemp("run")
    write_textgrid(folder / "a.TextGrid", {"phones": PHONES}, 1.5)
    shutil.copy(root / "examples/line.wav", folder / "a.wav")
    rows = ["id,alignment,rig,character", "<b>one</b>,a.TextGrid,arkit,", "two,a.TextGrid,metahuman,"]
    (folder / "t.csv").write_text("\n".join([*rows, "three,a.TextGrid,vrm,", "four,a.TextGrid,,Zed"]))
    arguments = [str(folder / "t.csv"), "-o", str(folder / "out"), "--format", "npz", "--fps", "10"]
    assert run(["batch", *arguments, "--workers", "1", "-q"]) == 1
    return folder


@pytest.fixture(scope="module")
def review(folder):
    return open_review(folder / "out", read_lines(str(folder / "t.csv"), Common()))


@pytest.fixture
def server(review):
    with ReviewServer(review, "secret") as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server
        server.shutdown()
        thread.join()


def data_of(page):
    return json.loads(re.search(r'type="application/json">(.*?)</script>', page)[1])


def number_of(review, id):
    return [outcome.id for outcome in review.outcomes].index(id)


def test_the_list_has_every_line_and_the_worst_first(review):
    page = list_page(review, review.decisions(), "secret")
    lines = data_of(page)["lines"]
    assert lines[0]["id"] == "four"
    assert lines[0]["status"] == "failed"
    assert "there is no character or rig 'Zed'" in lines[0]["text"]
    assert {line["id"] for line in lines[1:]} == {"<b>one</b>", "two", "three"}
    assert {line["rig"] for line in lines[1:]} == {"arkit", "metahuman", "vrm"}
    assert "length" in lines[1]["checks"]  # the recording is longer
    assert "<b>one" not in page


@pytest.mark.parametrize("id", ["<b>one</b>", "two"])
def test_a_line_plays_with_its_sound_on_any_related_rig(review, id):
    data = data_of(delivered_page(review, number_of(review, id)))
    assert data["audio"].startswith("data:audio/wav;base64,")
    assert [label for label, *_ in data["takes"][0]["phones"] if label in ("AA", "B", "IY")] == [
        "AA",
        "B",
        "IY",
    ]
    assert "jawOpen" in data["takes"][0]["channels"]


def fetch(address, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_the_server_answers_those_with_the_token(server, review):
    status, page = fetch(server.address)
    assert (status, len(data_of(page)["lines"])) == (200, 4)
    line = server.address.replace("/?", f"/line?n={number_of(review, 'three')}&")
    assert data_of(fetch(line)[1])["review"]["notes"][0] == "shown on arkit; the line moves vrm"
    assert "Zed" in fetch(server.address.replace("/?", "/line?n=0&"))[1]


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("/", {}, 403),
        ("/?token=other", {}, 403),
        ("/?token=%C3%A9", {}, 403),
        ("/?token=secret", {"Origin": "http://elsewhere.org"}, 403),
        ("/?token=secret", {"Host": "elsewhere.org"}, 403),
        ("/line?n=4&token=secret", {}, 404),
        ("/list.csv", {}, 403),
        ("/news?after=0", {}, 403),
        ("/correct?token=secret", {}, 404),
        ("/line?n=-1&token=secret", {}, 404),
        ("/line?n=../t.csv&token=secret", {}, 404),
        ("/../t.csv?token=secret", {}, 404),
        ("/out/ledger.jsonl?token=secret", {}, 404),
    ],
)
def test_the_server_refuses(server, path, headers, status):
    assert fetch(f"http://127.0.0.1:{server.server_port}{path}", **headers)[0] == status


def test_what_is_no_address_is_told(server):
    assert server.answer("http://[x", {}).status == 400


def test_a_client_that_leaves_is_no_fault(server, capsys):
    with socket.create_connection(("127.0.0.1", server.server_port)) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # reset when closed
        client.sendall(f"GET /?token={server.token} HTTP/1.1\r\nHost: 127.0.0.1:1\r\n\r\n".encode())
    for error in (ConnectionResetError(), BrokenPipeError(), TimeoutError()):
        try:
            raise error
        except OSError:
            server.handle_error(None, None)
    assert fetch(server.address)[0] == 200
    assert capsys.readouterr().err == ""


def test_a_folder_without_a_run_is_told(tmp_path):
    with pytest.raises(OptionError, match="has no ledger of a run"):
        open_review(tmp_path)
