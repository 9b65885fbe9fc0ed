"""Live Link Face over UDP, as Epic's iPhone app sends it and Unreal's Live Link receives it.

A packet (after PyLiveLinkFace 0.1, MIT, which decodes the app's packets) has: the version, 6, as a
little-endian integer; then, all big-endian, "$" and a UUID in 36 letters; the length of the subject's name,
and the name; frame number and the fraction of a frame as a float; frames per second and its denominator; a
byte with the number of values, 61, and the values as floats.
"""

from __future__ import annotations

import struct
import uuid
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import OptionError
from phonanim.exporters._livelink import N_ARKIT, columns, turns
from phonanim.stream.sinks import Address, Datagrams, Stage, datagrams

SUMMARY = "Live Link Face over UDP, as the app sends it (rigs with ARKit controls)"
ADDRESS = ("127.0.0.1", 11111)
VERSION = 6
SUBJECT = "phonanim"
# Constant for a subject, so that a receiver recognizes it.
DEVICE = "$" + str(uuid.uuid5(uuid.NAMESPACE_URL, "phonanim")).upper()
SWAPPED = (("jawRight", "jawLeft"), ("mouthRight", "mouthLeft"))  # in packets, left comes before right
LARGEST = 2**31  # frame numbers wrap here


def open_sink(stage: Stage, address: Address) -> Datagrams:
    """Raises OptionError when the rig has no ARKit control."""
    order = packet_order()
    if not set(order[:N_ARKIT]) & set(stage.controls):
        raise OptionError(f"rig {stage.rig} has no ARKit control for livelink; choose --rig arkit")
    places = np.array([order.index(name) for name in stage.controls if name in order])
    taken = np.array([column for column, name in enumerate(stage.controls) if name in order])
    units = np.array([np.pi / 180 if name in turns() else 1.0 for name in stage.controls if name in order])
    rate = Fraction(stage.fps).limit_denominator(1001)
    head = struct.pack("<I", VERSION) + DEVICE.encode() + struct.pack("!i", len(SUBJECT)) + SUBJECT.encode()

    def pack(number: int, time: float, values: NDArray[np.float32]) -> bytes:
        sent = np.zeros(len(order), ">f4")
        sent[places] = values[taken] * units
        clock = struct.pack("!ifii", number % LARGEST, 0.0, rate.numerator, rate.denominator)
        return head + clock + bytes([len(order)]) + sent.tobytes()

    return datagrams("livelink", address, pack)


def packet_order() -> tuple[str, ...]:
    """Control names in the order of a packet: that of the app's files, with left and right swapped twice."""
    order = list(columns())
    for right, left in SWAPPED:
        first, second = order.index(right), order.index(left)
        order[first], order[second] = left, right
    return tuple(order)
