"""Destinations of frames in real time: one module per protocol, named after it.

Each module is a `SinkModule`. A name that begins with `_` is a helper.
"""

from __future__ import annotations

import socket
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from phonanim.core.plugins import Registry
from phonanim.errors import MissingExtraError, OptionError, OutputError

SINKS = Registry("phonanim.stream.sinks", needs=("SUMMARY", "ADDRESS", "open_sink"), group="phonanim.sinks")

Address = tuple[str, int]


@dataclass(frozen=True)
class Stage:
    """What moves: a rig's controls, so many times a second; `origins` are sites whose pages may connect.

    `rest` are the controls at rest; `character` is the file that pages show, the shipped head when it is
    None; `sound` is the recording that they play in step, from `sound_start` seconds of it on.
    """

    rig: str
    controls: tuple[str, ...]
    fps: float
    origins: tuple[str, ...] = ()
    rest: tuple[float, ...] = ()
    character: Path | None = None
    sound: Path | None = None
    sound_start: float = 0.0


class Sink(Protocol):
    """A destination of frames. `send` never waits for receivers."""

    where: str  # the name of the destination, for messages

    def send(self, number: int, time: float, values: NDArray[np.float32]) -> None:
        """Send frame `number` at `time` seconds with its values (controls,). Raises OSError on failure."""

    def close(self) -> None:
        """Close the destination."""


@runtime_checkable
class Waiting(Protocol):
    """A sink whose receiver has to be ready before it makes sense to begin."""

    where: str

    def wait(self, seconds: float) -> bool:
        """Wait until the receiver is ready; False when it is not after so long."""


class SinkModule(Protocol):
    """What a module of this folder, or a plugin of the group `phonanim.sinks`, offers."""

    SUMMARY: str  # one line of description
    ADDRESS: Address | None  # the default host and port; None without an address

    def open_sink(self, stage: Stage, address: Address | None) -> Sink:
        """Open the destination. Raises OSError when that fails, ImportError when a package is missing."""


def sink_names() -> tuple[str, ...]:
    """Every sink: the stems of this folder's files, and the plugins."""
    return SINKS.names()


def find_sink(name: str) -> SinkModule:
    """The module of a sink. Raises OptionError, which suggests the nearest name."""
    found = SINKS.find(name)
    if found is None:
        near = get_close_matches(name, sink_names(), n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise OptionError(f"there is no sink {name!r}{hint} (known: {', '.join(sink_names())})")
    return cast("SinkModule", found)


def open_named(text: str, stage: Stage) -> Sink:
    """A sink from NAME, NAME=HOST:PORT or NAME=PORT. Raises OptionError, OutputError, MissingExtraError."""
    name, given, place = text.partition("=")
    module = find_sink(name)
    address = module.ADDRESS
    if given and address is None:
        raise OptionError(f"{text}: {name} has no address; write {name}")
    if given and address is not None:
        address = parse_address(place, address, text)
    try:
        opened = module.open_sink(stage, address)
    except ImportError as error:
        raise MissingExtraError(f"{name} needs pip install 'phonanim[stream]' ({error.name})") from error
    except OSError as error:
        raise OutputError(f"{text}: cannot be opened: {error.strerror or error}; choose another") from error
    return opened


def parse_address(text: str, usual: Address, where: str) -> Address:
    """HOST:PORT, or PORT on the default host. Raises OptionError."""
    host, _, port = text.rpartition(":")
    if not port.isdecimal() or not 0 < int(port) < 65536:
        raise OptionError(f"{where}: {text!r} is not an address; write HOST:PORT, e.g. {usual[0]}:{usual[1]}")
    return host.strip("[]") or usual[0], int(port)


@dataclass
class Datagrams:
    """A sink that sends each frame as one UDP packet."""

    where: str
    address: tuple[object, ...]
    socket: socket.socket
    pack: Callable[[int, float, NDArray[np.float32]], bytes]

    def send(self, number: int, time: float, values: NDArray[np.float32]) -> None:
        """Send a frame; a receiver is not required."""
        self.socket.sendto(self.pack(number, time, values), self.address)

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()


def datagrams(
    name: str, address: Address, pack: Callable[[int, float, NDArray[np.float32]], bytes]
) -> Datagrams:
    """A sink to a host and port. Raises OSError when the host does not exist."""
    family, kind, _, _, place = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)[0]
    return Datagrams(f"{name}={address[0]}:{address[1]}", place, socket.socket(family, kind), pack)
