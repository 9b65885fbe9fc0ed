"""Praat TextGrid in binary form."""

from __future__ import annotations

import struct

from phonanim.readers._trigraphs import decode_trigraphs
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "Praat binary TextGrid"
_MAGIC = b"ooBinaryFile"


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first bytes are those of Praat's binary files."""
    return source.data.startswith(_MAGIC)


def read(source: AlignmentFile) -> Recording:
    """Every interval tier, in file order; point tiers are ignored."""
    data = _Bytes(source.data, len(_MAGIC))
    try:
        if (kind := data.short_text()) != "TextGrid":
            raise source.error(
                f'contains a Praat object of class "{kind}", not a TextGrid; save the TextGrid alone'
            )
        start, end, exists = data.real(), data.real(), data.take(">B")
        count = data.take(">i") if exists else 0
        tiers = [_read_tier(data, number) for number in range(1, int(count) + 1)]
    except (struct.error, UnicodeDecodeError) as error:
        raise source.error("is truncated or damaged; save it again") from error
    return decode_trigraphs(Recording(tuple(tier for tier in tiers if tier), start, end))


def _read_tier(data: _Bytes, number: int) -> Tier | None:
    of_intervals = data.short_text() == "IntervalTier"
    name = data.text()
    data.real(), data.real()
    intervals = []
    for _ in range(int(data.take(">i"))):
        start = data.real()
        end = data.real() if of_intervals else start
        intervals.append(Interval(data.text().strip(), start, end))
    return Tier(name, tuple(intervals), number) if of_intervals else None


class _Bytes:
    """Big-endian numbers and texts, one after the other. Raises struct.error past the end."""

    def __init__(self, data: bytes, position: int) -> None:
        self.data = data
        self.position = position

    def take(self, layout: str) -> float:
        (value,) = struct.unpack_from(layout, self.data, self.position)
        self.position += struct.calcsize(layout)
        return float(value)

    def real(self) -> float:
        return self.take(">d")

    def short_text(self) -> str:
        return self._bytes(int(self.take(">B"))).decode("ascii", "replace")

    def text(self) -> str:
        """Text after its length; a length of 0xFFFF means that a second length and UTF-16 text follow."""
        length = int(self.take(">H"))
        if length != 0xFFFF:
            return self._bytes(length).decode("latin-1")
        return self._bytes(2 * int(self.take(">H"))).decode("utf-16-be")

    def _bytes(self, length: int) -> bytes:
        found = self.data[self.position : self.position + length]
        self.position += length
        if len(found) < length:
            raise struct.error
        return found
