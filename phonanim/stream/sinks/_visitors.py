"""Connections to the WebSocket: so many that the process can still open files, and none that says much."""

from __future__ import annotations

import logging
import time
from contextlib import suppress
from typing import Any

MOST = 1000  # connections
BACKLOG = 16  # connections that the system accepts at once
KEPT = 64  # files that the process may still open
MOST_SAID = 1 << 16  # bytes from a client, with those of its request
SAID_EACH_SECOND = 100.0  # more bytes for each second, for answers to pings


def most_visitors() -> int:
    """The number of connections that leaves room for files."""
    with suppress(ImportError):
        import resource

        files = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        if files != resource.RLIM_INFINITY:
            return max(1, min(MOST, files - KEPT - BACKLOG))
    return MOST


def visitor_class(most: int) -> type[Any]:
    """A connection that is closed at once when there are `most`, and when a client says too much."""
    from websockets.asyncio.server import ServerConnection

    quiet = logging.getLogger("asyncio")  # it warns about connections that were closed
    if not any(isinstance(handler, logging.NullHandler) for handler in quiet.handlers):
        quiet.addHandler(logging.NullHandler())

    class Visitor(ServerConnection):
        count = 0  # of all that are open
        said = 0

        def connection_made(self, transport: Any) -> None:
            """Count it."""
            self.began = time.monotonic()
            Visitor.count += 1
            super().connection_made(transport)
            if Visitor.count > most:
                transport.abort()

        def connection_lost(self, exc: Exception | None) -> None:
            """Count it no more."""
            Visitor.count -= 1
            super().connection_lost(exc)

        def data_received(self, data: bytes) -> None:
            """Take what a client says, within limits."""
            self.said += len(data)
            if self.said > MOST_SAID + SAID_EACH_SECOND * (time.monotonic() - self.began):
                self.transport.abort()
            else:
                super().data_received(data)

    return Visitor
