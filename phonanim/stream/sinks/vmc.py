"""The Virtual Motion Capture protocol, which players of VRM avatars receive: blend shapes over OSC.

The messages: /VMC/Ext/OK (loaded), /VMC/Ext/T (seconds), /VMC/Ext/Blend/Val (name, value) for each blend
shape, /VMC/Ext/Blend/Apply at the end (protocol.vmc.info, VMC 2.5).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.stream.sinks import Address, Datagrams, Stage, datagrams

SUMMARY = "VMC protocol for VRM avatars: blend shapes by name (--rig vrm, or arkit for perfect sync)"
ADDRESS = ("127.0.0.1", 39539)


def open_sink(stage: Stage, address: Address) -> Datagrams:
    """Raises ImportError without python-osc."""
    from phonanim.stream.sinks._osc import bundle

    def pack(number: int, time: float, values: NDArray[np.float32]) -> bytes:
        shapes = [
            ("/VMC/Ext/Blend/Val", name, value)
            for name, value in zip(stage.controls, values.tolist(), strict=True)
        ]
        return bundle([("/VMC/Ext/OK", 1), ("/VMC/Ext/T", time), *shapes, ("/VMC/Ext/Blend/Apply",)])

    return datagrams("vmc", address, pack)
