"""A WebSocket, and a page that shows the moving head: both at one address, for any browser.

`http://HOST:PORT/` is the page, which loads nothing from other hosts. `ws://HOST:PORT/live` sends a frame as
one binary message, little-endian: number (uint32), 4 unused bytes, seconds (float64), values (float32 each).
The first message is JSON text: the rig, frames per second, and the names of the controls. `/live.json` sends
the frames as JSON texts too.
"""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import socket
import struct
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from threading import Event, Thread
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from phonanim.stream.sinks import Address, Stage
from phonanim.stream.sinks._json import frame_text, header_text
from phonanim.stream.sinks._visitors import BACKLOG, most_visitors, visitor_class

SUMMARY = "a WebSocket with a live page: open http://127.0.0.1:8765 in a browser"
ADDRESS = ("127.0.0.1", 8765)
PATH, TEXT_PATH = "/live", "/live.json"
FAREWELL = 0.1  # seconds for clients to close the connection at the end
MOST_WAITING = 1 << 18  # bytes that wait for one client: a few seconds; a slower client is disconnected
MOST_SAID = 1 << 10  # bytes of a message from a client
READY = "ready"  # the only message that counts
HEAD = struct.Struct("<I4xd")
PAGE = Path(__file__).parent.parent / "page"
SCRIPTS = ("three.js", "data.js", "stage.js")  # of the viewer


class Broadcast:
    """A server in a separate thread; every client gets every frame, and a slow client delays nothing.

    Only pages of this address and those of `stage.origins` may connect.
    """

    def __init__(self, stage: Stage, address: Address, page: bytes) -> None:
        from websockets.asyncio.server import broadcast

        self.where = f"http://{address[0]}:{address[1]}/"
        self.header = header_text(stage)
        self.page = page
        self.host = address[0]
        self.ready = Event()  # a page has loaded, and may play its sound
        self.origins = frozenset(origin.rstrip("/") for origin in stage.origins)
        self.broadcast = broadcast
        self.loop = asyncio.new_event_loop()
        self.thread = Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()
        try:
            self.server = asyncio.run_coroutine_threadsafe(self._serve(address), self.loop).result()
        except OSError:
            self._stop()
            raise

    def send(self, number: int, time: float, values: NDArray[np.float32]) -> None:
        """Hand a frame to the server's thread."""
        self.loop.call_soon_threadsafe(self._send, number, time, values.astype("<f4"))

    def close(self) -> None:
        """Close all connections."""
        asyncio.run_coroutine_threadsafe(self._end(), self.loop).result()
        self._stop()

    async def _serve(self, address: Address) -> Any:
        from websockets.asyncio.server import serve

        quiet = logging.getLogger("phonanim.websocket")  # a client that disconnects is not logged
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False
        return await serve(
            self._greet,
            *address,
            process_request=self._answer,
            compression=None,
            logger=quiet,
            close_timeout=FAREWELL,
            max_size=MOST_SAID,
            max_queue=1,
            create_connection=visitor_class(most_visitors()),
            backlog=BACKLOG,
        )

    def wait(self, seconds: float) -> bool:
        """Wait until a page says that it is ready; False when none has after so long."""
        return self.ready.wait(seconds)

    async def _greet(self, connection: Any) -> None:
        await connection.send(self.header)
        async for message in connection:
            if message == READY:
                self.ready.set()

    def _answer(self, connection: Any, request: Any) -> Any:
        """The page, or None for a WebSocket request."""
        if refusal := refuse_origin(request.headers, self.host, self.origins):
            return connection.respond(HTTPStatus.FORBIDDEN, f"{refusal}\n")
        if request.path in (PATH, TEXT_PATH):
            return None
        if request.path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "the page is at /\n")
        response = connection.respond(HTTPStatus.OK, "")
        response.body = self.page
        for name in ("Content-Type", "Content-Length"):
            del response.headers[name]
        response.headers["Content-Type"] = "text/html; charset=utf-8"
        response.headers["Content-Length"] = str(len(self.page))
        return response

    def _send(self, number: int, time: float, values: NDArray[np.float32]) -> None:
        for connection in self.server.connections:
            if connection.transport.get_write_buffer_size() > MOST_WAITING:
                connection.transport.abort()
        texts = {one for one in self.server.connections if one.request and one.request.path == TEXT_PATH}
        if texts:
            self.broadcast(texts, frame_text(number, time, values))
        message = HEAD.pack(number % 2**32, time) + values.tobytes()
        self.broadcast(set(self.server.connections) - texts, message)

    async def _end(self) -> None:
        for connection in self.server.connections:
            if connection.transport.get_write_buffer_size():  # it does not read, so a farewell is lost on it
                connection.transport.abort()
        self.server.close()
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self.server.wait_closed(), FAREWELL)
        for connection in self.server.connections:
            connection.transport.abort()
        rest = asyncio.all_tasks() - {asyncio.current_task()}  # clients that never sent a request
        for task in rest:
            task.cancel()
        await asyncio.gather(*rest, return_exceptions=True)

    def _stop(self) -> None:
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()


def refuse_origin(headers: Mapping[str, str], host: str, origins: frozenset[str]) -> str:
    """The reason to refuse a request, empty if it is allowed: another origin, or an unknown host name.

    `host` is the address of the server; `origins` are further allowed ones. A page that has its name resolve
    to this machine sends that name as the host. Programs other than browsers send no origin.
    """
    asked, origin = headers.get("Host", ""), headers.get("Origin")
    if origin in origins:
        return ""
    known = {
        "localhost",
        host.lower(),
        socket.gethostname().lower(),
        *(urlsplit(o).hostname for o in origins),
    }
    try:
        name, page = urlsplit(f"//{asked}").hostname or "", urlsplit(origin or "").netloc
    except ValueError:
        return "its host or its origin is not an address"
    if name not in known and not _is_address(name):
        return f"the host {asked!r:.80} is not served here; name it with --origin http://HOST:PORT"
    if origin is not None and page != asked:
        return f"pages of {origin!r:.80} may not connect; allow them with --origin {origin:.80}"
    return ""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def open_sink(stage: Stage, address: Address) -> Broadcast:
    """Raises ImportError without websockets, RigError when the head has no target for any control."""
    import websockets.asyncio.server  # noqa: F401  fail before the page is made

    return Broadcast(stage, address, live_page(stage).encode())


def live_page(stage: Stage) -> str:
    """The complete page."""
    from phonanim.core.pages import fill_page, script_data
    from phonanim.exporters.html import sound_address
    from phonanim.rig.head import SHIPPED
    from phonanim.viewer.page import base64_text, character_targets, read_character, read_page_part

    character = stage.character or SHIPPED
    data = {
        "facts": f"{stage.rig} · {stage.fps:g} fps · {len(stage.controls)} controls",
        "channels": stage.controls,
        "rest": stage.rest or [0.0] * len(stage.controls),
        "targets": character_targets(stage.controls, read_character(character)),
        "head": base64_text(character.read_bytes()),
        "audio": sound_address(stage.sound) if stage.sound else None,
        "start": stage.sound_start,
    }
    fields = {
        "title": "phonanim stream",
        "style": read_page_part("style.css") + (PAGE / "live.css").read_text("utf-8"),
        "data": script_data(data),
        "script": "\n".join([*map(read_page_part, SCRIPTS), (PAGE / "live.js").read_text("utf-8")]),
    }
    return fill_page((PAGE / "live.html").read_text("utf-8"), fields, "'self'")
