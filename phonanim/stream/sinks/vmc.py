"""The Virtual Motion Capture protocol, for players of VRM avatars: blend shapes over OSC.

The messages: /VMC/Ext/OK (loaded), /VMC/Ext/T (seconds), /VMC/Ext/Blend/Val (name, value) for each blend
shape, /VMC/Ext/Blend/Apply at the end, and /VMC/Ext/Bone/Pos for the head while it turns (protocol.vmc.info,
VMC 2.5).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.neck import TURNS, quaternions, turns_of
from phonanim.stream.sinks import Address, Datagrams, Stage, datagrams

SUMMARY = "VMC protocol for VRM avatars: blend shapes by name (--rig vrm, or arkit for perfect sync)"
ADDRESS = ("127.0.0.1", 39539)


def open_sink(stage: Stage, address: Address) -> Datagrams:
    """Raises ImportError without python-osc."""
    from phonanim.stream.sinks._osc import Message, bundle

    turns = bool(set(TURNS) & set(stage.controls))

    def pack(number: int, time: float, values: NDArray[np.float32]) -> bytes:
        shapes = [
            ("/VMC/Ext/Blend/Val", name, value)
            for name, value in zip(stage.controls, values.tolist(), strict=True)
            if name not in TURNS
        ]
        messages: list[Message] = [("/VMC/Ext/OK", 1), ("/VMC/Ext/T", time)]
        if turns:
            messages.append(("/VMC/Ext/Bone/Pos", "Head", 0.0, 0.0, 0.0, *_unity(values, stage.controls)))
        return bundle([*messages, *shapes, ("/VMC/Ext/Blend/Apply",)])

    return datagrams("vmc", address, pack)


def _unity(values: NDArray[np.float32], controls: tuple[str, ...]) -> list[float]:
    """The rotation of the head as Unity's quaternion, xyzw, where x is the character's right."""
    turn = turns_of(values[None], controls)
    rotation = quaternions(np.zeros((1, 3)) if turn is None else turn)[0]
    return list((rotation * [1, -1, -1, 1]).tolist())
