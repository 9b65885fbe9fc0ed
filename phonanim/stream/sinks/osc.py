"""Open Sound Control over UDP: one bundle per frame, one message per control."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.stream.sinks import Address, Datagrams, Stage, datagrams

SUMMARY = "Open Sound Control: /phonanim/frame, /phonanim/time, and /phonanim/<control> for each control"
ADDRESS = ("127.0.0.1", 9000)


def open_sink(stage: Stage, address: Address) -> Datagrams:
    """Raises ImportError without python-osc."""
    from phonanim.stream.sinks._osc import bundle

    paths = [f"/phonanim/{name}" for name in stage.controls]

    def pack(number: int, time: float, values: NDArray[np.float32]) -> bytes:
        controls = zip(paths, values.tolist(), strict=True)
        return bundle([("/phonanim/frame", number), ("/phonanim/time", time), *controls])

    return datagrams("osc", address, pack)
