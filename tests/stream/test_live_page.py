"""The live page: its character, its sound, the way to rest, and a stream that waits for it."""

import asyncio
import json
import shutil
import socket
import threading

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.commands import _live_page
from phonanim.commands._live_page import sound_in_step
from phonanim.errors import RigError, StreamError
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig
from phonanim.rig.head import SHIPPED
from phonanim.stream.engine import PhoneStream
from phonanim.stream.play import Player
from phonanim.stream.sinks import Stage, open_named
from phonanim.stream.sinks.websocket import live_page

RIG = load_cached_rig("arkit")


def page_data(stage):
    page = live_page(stage)
    return json.loads(page.split('type="application/json">')[1].split("</script>")[0])


def test_the_page_shows_the_character_and_plays_its_sound(root, tmp_path):
    other = tmp_path / "other.glb"
    shutil.copy(SHIPPED, other)
    other.write_bytes(other.read_bytes())
    rest = tuple(float(value) for value in RIG.rest)
    stage = Stage("arkit", RIG.controls, 60.0, (), rest, other, root / "examples/line.wav", 1.5)
    data = page_data(stage)
    assert data["audio"].startswith("data:audio/wav;base64,")
    assert (data["start"], tuple(data["rest"])) == (1.5, rest)
    assert data["targets"]
    silent = page_data(Stage("arkit", RIG.controls, 60.0))
    assert silent["audio"] is None
    assert silent["head"] == data["head"]


def test_a_character_that_nothing_moves_is_one_line(root, tmp_path, capsys):
    (tmp_path / "broken.glb").write_bytes(b"glTF")
    with pytest.raises(RigError, match="broken.glb"):
        live_page(Stage("arkit", RIG.controls, 60.0, character=tmp_path / "broken.glb"))
    given = ["stream", str(root / "examples/line.TextGrid"), "--character", str(SHIPPED)]
    assert run(given) == 2
    assert "add it, or --view" in capsys.readouterr().err


def test_the_sound_is_that_beside_the_alignment(root, tmp_path):
    line = root / "examples/line.TextGrid"
    assert sound_in_step(str(line), False, None, Options()) == (root / "examples/line.wav", 0.0)
    assert sound_in_step(str(line), False, None, Options(offset=1.0))[1] == 1.0
    assert sound_in_step("-", False, None, Options()) == (None, 0.0)
    shutil.copy(line, tmp_path)
    assert sound_in_step(str(tmp_path / "line.TextGrid"), False, None, Options()) == (None, 0.0)


class Kept:
    """A sink that keeps what it is sent."""

    where = "kept"

    def __init__(self):
        self.frames = []

    def send(self, number, time, values):
        self.frames.append((number, values.copy()))

    def close(self):
        pass


def test_a_stream_that_is_interrupted_goes_to_rest():
    sink = Kept()
    player = Player(PhoneStream(Options(fps=20.0)), [sink], 20.0, say=print)
    player.go_to_rest()
    assert sink.frames == []
    wide = RIG.rest.astype(np.float32) + np.float32(0.5)
    player.send(7, wide)
    player.go_to_rest()
    numbers, values = zip(*sink.frames, strict=True)
    assert numbers == tuple(range(7, 13))
    np.testing.assert_allclose(values[-1], RIG.rest, atol=1e-6)
    assert (np.diff([np.abs(row - RIG.rest).max() for row in values]) < 0).all()


def test_a_stream_waits_until_a_page_is_ready(monkeypatch):
    client = pytest.importorskip("websockets.asyncio.client")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
    sink = open_named(f"websocket={port}", Stage("arkit", RIG.controls, 60.0))
    opened = []

    async def visit(*words):
        async with client.connect(f"ws://127.0.0.1:{port}/live") as page:
            await page.recv()
            for word in words:
                await page.send(word)
            await asyncio.sleep(0.2)

    def browser(address):
        opened.append(address)
        threading.Thread(target=lambda: asyncio.run(visit("hello", "ready"))).start()

    try:
        asyncio.run(visit("hello"))
        assert not sink.wait(0.1)
        monkeypatch.setattr("webbrowser.open", browser)
        _live_page.wait_for_page([Kept(), sink], _live_page.Console(quiet=True))
        assert opened == [sink.where]
        sink.ready.clear()
        monkeypatch.setattr("webbrowser.open", opened.append)
        monkeypatch.setattr(_live_page, "PATIENCE", 0.1)
        with pytest.raises(StreamError, match="no page was ready within 0.1 s"):
            _live_page.wait_for_page([sink], _live_page.Console(quiet=True))
    finally:
        sink.close()
