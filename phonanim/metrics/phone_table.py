"""The phone table: what a mouth shows in the middle of each phone, and the bars it is held to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Table = dict[str, dict[str, float]]

MIDDLE = 0.3  # share of a phone, around its middle, that the table looks at
SIBILANTS = "s z sh ch jh"
LEAST = 1e-3  # mm, so that nothing is divided by zero
CLOSED = 0.5  # mm of lip gap below which lips count as closed


@dataclass(frozen=True)
class Check:
    """One bar of the phone table: `value` is to be at least (`above`) or at most `bar`."""

    name: str
    value: float
    bar: float
    above: bool

    @property
    def passed(self) -> bool:
        """Whether the value is within the bar."""
        return self.value >= self.bar if self.above else self.value <= self.bar


def phone_table(lines: Sequence[tuple[PhoneTrack, Array, Mapping[str, Array]]]) -> Table:
    """Mean of each measure over the middles of each phone; of p b m also `closest`, the mean least gap.

    Each line is a track, its instants (frames,) in seconds and the measures (frames,) by name.
    """
    sums: dict[str, list[dict[str, float]]] = {}
    for track, times, shown in lines:
        period = times[1] - times[0] if len(times) > 1 else 0.0
        for code, begin, end in zip(track.codes, track.bounds[:-1], track.bounds[1:], strict=True):
            middle, half = (begin + end) / 2, MIDDLE / 2 * (end - begin) + 0.5 * period
            near = slice(*np.searchsorted(times, (middle - half, middle + half)))
            whole = slice(*np.searchsorted(times, (begin - 0.5 * period, end + 0.5 * period)))
            if near.stop == near.start:
                continue
            row = {name: float(curve[near].mean()) for name, curve in shown.items()}
            sums.setdefault(INVENTORY.phones[code], []).append(
                row | {"closest": float(shown["lip_gap"][whole].min())}
            )
    return {
        phone: {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
        | {"closures": float(np.mean([row["closest"] <= CLOSED for row in rows])), "count": float(len(rows))}
        for phone, rows in sorted(sums.items(), key=lambda item: INVENTORY.code(item[0]))
    }


def check_table(table: Table) -> list[Check]:
    """The bars that the mouths of natural speech are held to, as far as the table has their phones."""
    found = []
    for name, measure, phones, bar, above, value in BARS:
        if all(phone in table and measure in table[phone] for phone in phones.split()):
            found.append(Check(name, value(table), bar, above))
    return found


def _opening(table: Table, phone: str) -> float:
    """Drop of the jaw from the phone that has it highest, mm."""
    return table[phone]["jaw"] - min(row["jaw"] for row in table.values())


def _most(table: Table, measure: str, phones: str) -> float:
    return max(table[phone][measure] for phone in phones.split())


def _apart(table: Table, measure: str, phone: str, other: str) -> float:
    return table[phone][measure] - table[other][measure]


def _over_sibilants(table: Table) -> float:
    teeth = np.mean([table[phone]["jaw"] for phone in SIBILANTS.split()])
    return table["aa"]["jaw"] / max(float(teeth), LEAST)


# Name, measure, phones, bar, whether it is a least value, and the value.
BARS: tuple[tuple[str, str, str, float, bool, Callable[[Table], float]], ...] = (
    ("lip gap, AA over IY", "lip_gap", "aa iy", 1.3, True, lambda t: t["aa"]["lip_gap"] / t["iy"]["lip_gap"]),
    (
        "jaw, AA over IY",
        "jaw",
        "aa iy",
        2.5,
        True,
        lambda t: _opening(t, "aa") / max(_opening(t, "iy"), LEAST),
    ),
    ("jaw, AA over s z sh ch jh", "jaw", f"aa {SIBILANTS}", 4.0, True, _over_sibilants),
    (
        "UW narrower than IY, mm",
        "lip_width",
        "uw iy",
        7.0,
        True,
        lambda t: _apart(t, "lip_width", "iy", "uw"),
    ),
    (
        "UW further out than IY, mm",
        "protrusion",
        "uw iy",
        4.0,
        True,
        lambda t: _apart(t, "protrusion", "uw", "iy"),
    ),
    (
        "teeth apart at s z sh ch jh, mm",
        "jaw",
        SIBILANTS,
        1.5,
        False,
        lambda t: _most(t, "jaw", SIBILANTS),
    ),
    (
        "lower lip from the teeth at f v, mm",
        "lower_lip_to_teeth",
        "f v",
        1.0,
        False,
        lambda t: _most(t, "lower_lip_to_teeth", "f v"),
    ),
    ("lip gap at p b m, mm", "closest", "p b m", CLOSED, False, lambda t: _most(t, "closest", "p b m")),
    (
        "share of p b m that close",
        "closures",
        "p b m",
        1.0,
        True,
        lambda t: min(t[phone]["closures"] for phone in "pbm"),
    ),
)
