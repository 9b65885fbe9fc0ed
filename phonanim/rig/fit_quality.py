"""How a fitted head follows the reference head on speech: correlation, slope and spread of each measure.

A correlation is blind to a mouth that mumbles. So the same articulation moves both heads, and the fitted
one's lips and jaw are compared with the shipped head's in millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import articulate
from phonanim.errors import RigError
from phonanim.face.model import FaceModel
from phonanim.metrics import correlation
from phonanim.metrics.phones import phone_middles
from phonanim.rig.head import Head
from phonanim.rig.landmarks import MARK, MeshLandmarks
from phonanim.rig.pronounce import pronounce
from phonanim.rig.reach import reachable_slopes
from phonanim.rig.read import load_rig
from phonanim.rig.rig import Rig
from phonanim.rig.shown_mouth import mouth_on, shown_mouth
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

# Phones of three of the Harvard sentences (IEEE 1969): the birch canoe slid on the smooth planks; glue the
# sheet to the dark blue background; four hours of steady work faced us.
PROBE = (
    "sil dh ah b er ch k ah n uw s l ih d aa n dh ah s m uw dh p l ae ng k s sil g l uw dh ah sh iy t t uw "
    "dh ah d aa r k b l uw b ae k g r aw n d sil f ao r aw er z ah v s t eh d iy w er k f ey s t ah s sil"
)
LONG, SHORT = 0.11, 0.075  # seconds of a vowel, and of any other phone
FPS = 60.0
WANTED = {"lip_gap": 0.9, "lip_width": 0.8, "protrusion": 0.8, "jaw": 0.9}
"""The slope that a fitted head should reach in each measure, where its shapes allow."""
WHILE = {
    "lip_gap": "",
    "lip_width": " while the lips part as they should",
    "protrusion": " while the lips part and narrow as they should",
    "jaw": " while the lips part as they should",
}
LEAST_SLOPE, LEAST_R = 0.3, 0.7  # of the lip gap: a rig below either is not written
MOST_OPEN = 3.0  # mm between the lips at p b m, more than at rest; nor is one above it


@dataclass(frozen=True)
class Followed:
    """`r`, `slope` and `spread` (ratio of standard deviations) of a measure against the reference head's."""

    r: float
    slope: float
    spread: float

    def __str__(self) -> str:
        return f"r {self.r:.2f}, slope {self.slope:.2f}, sd ratio {self.spread:.2f}"


@dataclass(frozen=True)
class FitQuality:
    """What a fitted head shows of the probe: each measure of WANTED, and the lips at p b m, mm above rest.

    `reach` is the slope of each measure that the best weights of its shapes give, where it is known.
    """

    measures: dict[str, Followed]
    open_at_closures: float
    reach: dict[str, float] = field(default_factory=dict)

    @property
    def short(self) -> tuple[str, ...]:
        """What stays below its wanted slope, with the number and what the shapes allow."""
        return tuple(
            f"{name} moves {self.measures[name].slope:.0%} of the reference's way "
            f"({least:.0%} wanted{self._allowed(name)})"
            for name, least in WANTED.items()
            if self.measures[name].slope < least
        )

    def _allowed(self, name: str) -> str:
        """What the shapes of the head allow of a measure."""
        reach = self.reach.get(name)
        if reach is None:
            return ""
        if reach <= self.measures[name].slope:
            return f"; its shapes do not allow more{WHILE[name]}"
        return f"; the best weights of its shapes give {reach:.0%}{WHILE[name]}"


def fit_quality(rig: Rig, head: Head, spots: MeshLandmarks, face: FaceModel) -> FitQuality:
    """How a fitted rig's head follows the shipped head on the probe."""
    track, times = probe()
    mouth, reference = articulate(track, times), load_rig("arkit")
    seen_there = shown_mouth(reference, face)
    assert seen_there is not None
    assert reference.mouth is not None
    assert rig.mouth is not None
    there = seen_there(pronounce(mouth, reference, reference.mouth))
    ours = mouth_on(head, spots, rig.controls, face)
    here = ours(pronounce(mouth, rig, rig.mouth))
    rest = ours(rig.rest[None])["lip_gap"][0]
    middles = np.searchsorted(times, phone_middles(track, ("p", "b", "m")))
    return FitQuality(
        {name: _followed(here[name], there[name]) for name in WANTED},
        float(np.max(here["lip_gap"][middles] - rest)),
        reachable_slopes(mouth, rig, rig.mouth, there),
    )


def check_alive(quality: FitQuality, name: str) -> None:
    """Raise RigError for a rig whose mouth hardly moves, or does not close."""
    gap = quality.measures["lip_gap"]
    if not (gap.slope >= LEAST_SLOPE and gap.r >= LEAST_R):
        raise RigError(
            f"{name}: its lips hardly follow speech ({gap}; a slope of {LEAST_SLOPE:g} and r {LEAST_R:g} are "
            f"needed), so no rig is written; mark its lips: {MARK}"
        )
    if quality.open_at_closures > MOST_OPEN:
        raise RigError(
            f"{name}: its lips stay {quality.open_at_closures:.1f} mm apart at p b m, so no rig is written; "
            f"give it a shape that closes them, or mark its lips: {MARK}"
        )


def probe() -> tuple[PhoneTrack, NDArray[np.float64]]:
    """Phones of natural sentences and the instants (frames,) seconds at which they are looked at."""
    phones = tuple(PROBE.split())
    codes = INVENTORY.codes(phones)
    lengths = np.where(INVENTORY.where(kind="vowel")[codes], LONG, SHORT)
    track = PhoneTrack(codes, np.concatenate([[0.0], np.cumsum(lengths)]), phones)
    return track, np.arange(int(track.duration * FPS)) / FPS


def _followed(curve: NDArray[np.float64], reference: NDArray[np.float64]) -> Followed:
    centred, wanted = curve - curve.mean(), reference - reference.mean()
    if centred.std() == 0:
        return Followed(0.0, 0.0, 0.0)
    slope = float(centred @ wanted / (wanted @ wanted))
    return Followed(correlation(curve, reference), slope, float(curve.std() / reference.std()))
