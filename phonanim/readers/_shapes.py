"""The sets of mouth shapes in which Papagayo and the programs around it write."""

from __future__ import annotations

from collections.abc import Iterable

from phonanim.readers._visemes import NOTE
from phonanim.speech.alignment import Interval

PRESTON_BLAIR = frozenset({"ai", "e", "o", "u", "etc", "l", "wq", "mbp", "fv", "rest"})

# https://github.com/morevnaproject-org/papagayo-ng: the set of Fleming and Dobbs, by the phones each is for.
FLEMING_DOBBS = {
    **{"AA": "aa", "EHSZ": "eh", "IY": "iy", "O": "ao", "OO": "uw", "GK": "k", "NLTDR": "t", "SH": "sh"},
    **{"TH": "th", "FV": "f", "MBP": "m", "REST": "sil"},
}


def shape_phones(shapes: Iterable[Interval]) -> tuple[tuple[Interval, ...], str, tuple[str, ...]]:
    """The shapes as phones, the language of their labels, and the notes on that.

    The 39 phones of CMU, which Papagayo offers as a set too, are phones of English.
    """
    shapes = tuple(shapes)
    names = {shape.label for shape in shapes if shape.label}
    if all(name.lower() in PRESTON_BLAIR for name in names):
        return shapes, "preston_blair", (NOTE,)
    if all(name.upper() in FLEMING_DOBBS for name in names) and names & {"EHSZ", "OO", "GK", "NLTDR"}:
        phones = (Interval(FLEMING_DOBBS[one.label.upper()], one.start, one.end) for one in shapes)
        return tuple(phones), "english", (NOTE,)
    return shapes, "english", ()
