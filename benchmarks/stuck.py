"""Interrupt a live stream while many clients are connected that never read, and measure how it ends."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HANDSHAKE = (
    "GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
START = 60.0  # seconds that it may take to listen


@dataclass(frozen=True)
class Ending:
    """Seconds from the interrupt to the end, the exit code, the peak of the memory, and what was told."""

    seconds: float
    code: int
    megabytes: float
    told: str


def interrupt_stream(clients: int, silent: int, streaming: float) -> Ending:
    """Stream to `clients` that never read and `silent` ones that never ask, and interrupt it."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = int(free.getsockname()[1])
    command = [
        sys.executable,
        "-m",
        "phonanim",
        "stream",
        "--realtime",
        "--to",
        f"websocket=127.0.0.1:{port}",
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with tempfile.TemporaryFile() as told:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stderr=told,
            env=environment,
            # What runs in the background has its interrupts ignored, and hands that on.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        held: list[socket.socket] = []
        try:
            _wait_for(port)
            held = [
                _connect(port, HANDSHAKE if number < clients else "") for number in range(clients + silent)
            ]
            assert process.stdin
            with suppress(BrokenPipeError):
                process.stdin.write(b'{"phone": "AA1", "start": 0.0, "end": 500.0}\n{"time": 500.0}\n')
                process.stdin.flush()
            time.sleep(streaming)
            began = time.monotonic()
            process.send_signal(signal.SIGINT)
            _, status, usage = os.wait4(process.pid, 0)
            seconds = time.monotonic() - began
        finally:
            process.kill()
            for connection in held:
                connection.close()
        told.seek(0)
        text = told.read().decode("utf-8", "replace")
    return Ending(seconds, os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1024, text)


def _connect(port: int, request: str) -> socket.socket:
    """A connection with the smallest buffer, that sends a request, or nothing, and never reads."""
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
    connection.connect(("127.0.0.1", port))
    connection.sendall(request.format(port=port).encode())
    return connection


def _wait_for(port: int) -> None:
    until = time.monotonic() + START
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return
        except OSError:
            if time.monotonic() > until:
                raise
            time.sleep(0.05)
