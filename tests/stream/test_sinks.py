"""Where frames go: every sink is opened, sends what it says it sends, and says what is wrong."""

from __future__ import annotations

import json
import os
import socket
import struct
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from phonanim.errors import MissingExtraError, OptionError, OutputError
from phonanim.pipeline import load_cached_rig
from phonanim.rig.head import load_head
from phonanim.rig.neck import TURNS
from phonanim.stream.sinks import Stage, find_sink, open_named, parse_address, sink_names

ARKIT = Stage("arkit", load_cached_rig("arkit").controls, 60.0)
VALUES = np.linspace(0, 1, len(ARKIT.controls)).astype(np.float32)


@pytest.fixture
def receiver() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.settimeout(5)
        yield listening


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def packet(name: str, receiver: socket.socket, stage: Stage = ARKIT) -> bytes:
    """What a sink sends of frame 90."""
    sink = open_named(f"{name}=127.0.0.1:{receiver.getsockname()[1]}", stage)
    sink.send(90, 1.5, VALUES[: len(stage.controls)])
    sink.close()
    return receiver.recv(65536)


@pytest.mark.parametrize("name", sink_names())
def test_every_sink_opens_sends_and_closes(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    if name in ("osc", "vmc"):
        pytest.importorskip("pythonosc")
    if name == "websocket":
        pytest.importorskip("websockets")
    module = find_sink(name)
    assert 10 < len(module.SUMMARY) < 110
    place = "" if module.ADDRESS is None else f"={free_port()}"
    sink = open_named(name + place, ARKIT)
    for number in range(3):
        sink.send(number, number / 60, VALUES)
    sink.close()
    assert name in sink.where or sink.where.startswith("http://127.0.0.1:")


def test_live_link_packets(receiver: socket.socket, shared_data: Path) -> None:
    """Taken apart as PyLiveLinkFace does, and by the names that Apple gives the places."""
    data = packet("livelink", receiver)
    assert struct.unpack("<i", data[:4])[0] == 6
    assert data[4:41].decode("utf-8")[0] == "$"
    length = struct.unpack("!i", data[41:45])[0]
    end = 45 + length
    assert data[45:end].decode() == "phonanim"
    frame, part, fps, denominator, count = struct.unpack("!if2ib", data[end : end + 17])
    assert (frame, part, fps, denominator, count) == (90, 0.0, 60, 1, 61)
    values = struct.unpack("!61f", data[end + 17 :])
    header = json.loads((shared_data / "formats/livelink_header.json").read_text())["livelink_csv_header"]
    order = [name[:1].lower() + name[1:] for name in header[2:]]
    for first, second in (("jawLeft", "jawRight"), ("mouthLeft", "mouthRight")):
        assert order.index(first) == order.index(second) + 1  # in files; packets have left first
        i, j = order.index(second), order.index(first)
        order[i], order[j] = first, second
    sent = dict(zip(ARKIT.controls, VALUES, strict=True))
    sent |= {name: np.radians(sent[name]) for name in TURNS}
    assert values == pytest.approx([sent.get(name, 0.0) for name in order])
    assert (order.index("jawLeft"), order.index("jawOpen"), order.index("tongueOut")) == (15, 17, 51)


def test_live_link_of_broken_rates(receiver: socket.socket) -> None:
    data = packet("livelink", receiver, Stage("arkit", ARKIT.controls, 30000 / 1001))
    assert struct.unpack("!2i", data[-(1 + 8 + 61 * 4) : -(1 + 61 * 4)]) == (30000, 1001)


def test_live_link_needs_controls_of_arkit() -> None:
    with pytest.raises(
        OptionError, match="rig rhubarb has no ARKit control for livelink; choose --rig arkit"
    ):
        open_named("livelink", Stage("rhubarb", ("A", "B"), 60))


def test_osc_bundles(receiver: socket.socket) -> None:
    found = dict(messages(packet("osc", receiver)))
    assert found["/phonanim/frame"] == [90]
    assert found["/phonanim/time"] == [1.5]
    for name, value in zip(ARKIT.controls, VALUES, strict=True):
        assert found[f"/phonanim/{name}"] == pytest.approx([value])


def test_vmc_bundles(receiver: socket.socket) -> None:
    found = messages(packet("vmc", receiver, Stage("vrm", ("aa", "ou"), 60)))
    assert found == [
        ("/VMC/Ext/OK", [1]),
        ("/VMC/Ext/T", [1.5]),
        ("/VMC/Ext/Blend/Val", ["aa", pytest.approx(VALUES[0])]),
        ("/VMC/Ext/Blend/Val", ["ou", pytest.approx(VALUES[1])]),
        ("/VMC/Ext/Blend/Apply", []),
    ]


def messages(data: bytes) -> list[tuple[str, list[object]]]:
    """An OSC 1.0 bundle, taken apart by its specification."""
    assert data[:16] == b"#bundle\0" + struct.pack(">Q", 1)
    found, place = [], 16
    while place < len(data):
        (size,) = struct.unpack(">i", data[place : place + 4])
        found.append(message(data[place + 4 : place + 4 + size]))
        place += 4 + size
    return found


def message(data: bytes) -> tuple[str, list[object]]:
    path, place = text(data, 0)
    kinds, place = text(data, place)
    values: list[object] = []
    for kind in kinds[1:]:
        if kind == "s":
            value, place = text(data, place)
            values.append(value)
        else:
            values.append(struct.unpack(">" + kind, data[place : place + 4])[0])
            place += 4
    return path, values


def text(data: bytes, place: int) -> tuple[str, int]:
    end = data.index(b"\0", place)
    return data[place:end].decode(), (end // 4 + 1) * 4


def test_lines_on_stdout(capfd: pytest.CaptureFixture[str]) -> None:
    sink = open_named("stdout", ARKIT)
    sink.send(3, 0.05, VALUES)
    first, second = map(json.loads, capfd.readouterr().out.splitlines())
    assert first == {"rig": "arkit", "fps": 60.0, "controls": list(ARKIT.controls)}
    assert (second["frame"], second["time"]) == (3, 0.05)
    assert second["values"] == pytest.approx(VALUES.tolist(), abs=1e-5)


def test_the_page_and_the_frames() -> None:
    client = pytest.importorskip("websockets.sync.client")
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/") as page:
        shown = page.read().decode()
    assert "THREE" in shown
    jaw = [ARKIT.controls.index("jawOpen"), 0, load_head().targets.index("jawOpen"), 1]
    assert json.dumps(jaw, separators=(",", ":"))[:-1] in shown
    assert "http://" not in shown.split("<script>")[0]
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"http://127.0.0.1:{port}/secret")
    with client.connect(f"ws://127.0.0.1:{port}/live") as connection:
        assert json.loads(connection.recv(5))["controls"] == list(ARKIT.controls)
        sink.send(7, 0.25, VALUES)
        data = connection.recv(5)
        assert struct.unpack("<I4xd", data[:16]) == (7, 0.25)
        assert np.array_equal(np.frombuffer(data[16:], "<f4"), VALUES)
    sink.send(8, 0.3, VALUES)  # nobody is there
    sink.close()


def test_frames_as_json_beside_binary_ones() -> None:
    client = pytest.importorskip("websockets.sync.client")
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    address = f"ws://127.0.0.1:{port}/live"
    with client.connect(f"{address}.json") as text, client.connect(address) as binary:
        assert text.recv(5) == binary.recv(5)
        sink.send(7, 0.25, VALUES)
        frame = json.loads(text.recv(5))
        assert (frame["frame"], frame["time"]) == (7, 0.25)
        assert frame["values"] == pytest.approx(VALUES.tolist(), abs=1e-5)
        assert struct.unpack("<I4xd", binary.recv(5)[:16]) == (7, 0.25)
    sink.close()


def test_a_visitor_who_never_reads_holds_nothing_up() -> None:
    pytest.importorskip("websockets")
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    with socket.create_connection(("127.0.0.1", port)) as visitor:
        visitor.sendall(b"nonsense\r\n\r\n")
        began = time.monotonic()
        for number in range(200):
            sink.send(number, number / 60, VALUES)
        assert time.monotonic() - began < 1
    sink.close()


def test_a_port_that_is_taken() -> None:
    pytest.importorskip("websockets")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(OutputError, match=rf"websocket={port}: cannot be opened: .*; choose another"):
            open_named(f"websocket={port}", ARKIT)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("livelnk", "there is no sink 'livelnk'; did you mean 'livelink'"),
        ("stdout=3", "stdout=3: stdout has no address; write stdout"),
        ("osc=here", "osc=here: 'here' is not an address; write HOST:PORT, e.g. 127.0.0.1:9000"),
        ("osc=:0", "':0' is not an address"),
        ("osc=host:70000", "'host:70000' is not an address"),
    ],
)
def test_places_that_make_no_sense(place: str, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        open_named(place, ARKIT)


def test_addresses() -> None:
    assert parse_address("80", ("127.0.0.1", 1), "osc") == ("127.0.0.1", 80)
    assert parse_address("[::1]:80", ("127.0.0.1", 1), "osc") == ("::1", 80)


def test_a_host_that_is_not_there() -> None:
    with pytest.raises(OutputError, match=r"livelink=nowhere.invalid:1: cannot be opened: "):
        open_named("livelink=nowhere.invalid:1", ARKIT)


@pytest.mark.parametrize(
    ("name", "module"), [("osc", "pythonosc"), ("vmc", "pythonosc"), ("websocket", "websockets")]
)
def test_what_needs_the_extra(name: str, module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for loaded in [m for m in sys.modules if m.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.delitem(sys.modules, "phonanim.stream.sinks._osc", raising=False)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=rf"{name} needs pip install 'phonanim\[stream\]'"):
        open_named(name, ARKIT)


def test_a_reader_that_left(monkeypatch: pytest.MonkeyPatch) -> None:
    read, write = os.pipe()
    os.close(read)
    monkeypatch.setattr("phonanim.stream.sinks.stdout.STDOUT", write)
    with pytest.raises(OutputError, match="stdout: cannot be opened: Broken pipe"):
        open_named("stdout", ARKIT)
    os.close(write)


@pytest.mark.parametrize(
    ("headers", "refusal"),
    [
        ({"Host": "127.0.0.1:8765"}, ""),
        ({"Host": "localhost:8765", "Origin": "http://localhost:8765"}, ""),
        ({"Host": "192.168.1.5:8765", "Origin": "http://192.168.1.5:8765"}, ""),
        ({"Host": "[::1]:8765"}, ""),
        ({"Host": "127.0.0.1:8765", "Origin": "https://tool.example"}, ""),
        ({"Host": "127.0.0.1:8765", "Origin": "http://evil.example"}, "may not connect; allow them with"),
        ({"Host": "127.0.0.1:8765", "Origin": "null"}, "may not connect"),
        ({"Host": "127.0.0.1:8765", "Origin": "http://127.0.0.1:9000"}, "may not connect"),
        ({"Host": "evil.example:8765", "Origin": "http://evil.example:8765"}, "is not served here; name it"),
        ({"Host": "evil.example:8765"}, "is not served here"),
        ({}, "is not served here"),
        ({"Host": "[::1:8765"}, "is not an address"),
        ({"Host": "127.0.0.1:8765", "Origin": "http://[x"}, "is not an address"),
    ],
)
def test_pages_of_other_sites_may_not_connect(headers: dict[str, str], refusal: str) -> None:
    from phonanim.stream.sinks.websocket import refuse_origin

    found = refuse_origin(headers, "127.0.0.1", frozenset({"https://tool.example"}))
    assert refusal in found
    assert bool(found) == bool(refusal)


def test_a_page_of_another_site_gets_403() -> None:
    pytest.importorskip("websockets")
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    request = urllib.request.Request(f"http://127.0.0.1:{port}/", headers={"Origin": "http://evil.example"})
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(request)
    sink.close()


def test_a_client_that_never_reads_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("websockets")
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    with socket.create_connection(("127.0.0.1", port)) as visitor:
        visitor.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 12)
        visitor.sendall(
            b"GET /live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        while not sink.server.connections:
            time.sleep(0.01)
        connection = next(iter(sink.server.connections))
        frame = np.zeros(1 << 14, np.float32)
        for number in range(20_000):
            sink.send(number, 0.0, frame)
            if number % 100 == 0:
                time.sleep(0.01)
            if connection.transport.is_closing():
                break
        assert connection.transport.is_closing()
    sink.close()


def is_closed(visitor: socket.socket) -> bool:
    """Whether the other side ends a connection, with or without a word."""
    visitor.settimeout(20)
    try:
        while visitor.recv(1 << 16):
            pass
    except ConnectionError:
        pass
    except TimeoutError:
        return False
    return True


def test_a_client_that_says_much_is_disconnected(capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("websockets")
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    with socket.create_connection(("127.0.0.1", port)) as visitor:
        visitor.sendall(
            b"GET /live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        ping = b"\x89\x84" + bytes(4) + b"ping"
        with suppress(ConnectionError):
            visitor.sendall(ping * 20_000)
        assert is_closed(visitor)
    sink.close()
    assert capfd.readouterr().err == ""


def test_more_visitors_than_files_may_be_open_are_turned_away(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("websockets")
    monkeypatch.setattr("phonanim.stream.sinks.websocket.most_visitors", lambda: 3)
    port = free_port()
    sink = open_named(f"websocket={port}", ARKIT)
    visitors = [socket.create_connection(("127.0.0.1", port)) for _ in range(3)]
    with socket.create_connection(("127.0.0.1", port)) as late:
        assert is_closed(late)
    for visitor in visitors:
        visitor.close()
    until = time.monotonic() + 20
    while time.monotonic() < until:
        with suppress(OSError):
            assert b"phonanim" in urllib.request.urlopen(f"http://127.0.0.1:{port}/").read()
            break
    else:
        pytest.fail("nobody is let in when others have left")
    sink.close()
    assert capfd.readouterr().err == ""


def test_there_is_room_for_files_beside_visitors(monkeypatch: pytest.MonkeyPatch) -> None:
    resource = pytest.importorskip("resource")
    from phonanim.stream.sinks._visitors import MOST, most_visitors

    for files, visitors in ((resource.RLIM_INFINITY, MOST), (1 << 20, MOST), (256, 176), (64, 1)):
        monkeypatch.setattr(resource, "getrlimit", lambda _, files=files: (files, files))
        assert most_visitors() == visitors
