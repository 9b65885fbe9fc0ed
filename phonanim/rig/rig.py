"""The rig: controls with limits, eight poses, and the maps from the reference face's modes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.exact import ordered_product
from phonanim.rig.measures import MouthMeasures

Array = NDArray[np.float64]

POSED_MODES = 4
SIGMAS = 3.0  # a pose shows a mode this many standard deviations from the mean
# In the order of `Rig.poses`, with the look of the reference face.
POSES = {
    "mode1_minus": "lips pressed together, chin raised",
    "mode1_plus": "mouth wide open",
    "mode2_minus": "mouth narrow, lips together and forward",
    "mode2_plus": "mouth broad, upper lip raised",
    "mode3_minus": "lips together, corners up and back",
    "mode3_plus": "lips apart, corners down and forward",
    "mode4_minus": "mouth broad, upper lip and chin low",
    "mode4_plus": "mouth narrow, upper lip and chin raised",
}
MEAN = "mean"


@dataclass(frozen=True)
class HingeMap:
    """Controls as a sum of hinges: c = base + max(z · loads + offsets, 0) · weights.

    z (frames, modes) are the modes in standard deviations; `loads` is (hinges, modes), `offsets`
    (hinges,), `weights` (hinges, controls), `base` (controls,); `names` name each hinge's input.
    """

    names: tuple[str, ...]
    loads: Array
    offsets: Array
    weights: Array
    base: Array

    def __call__(self, standardized: NDArray[np.floating]) -> NDArray[np.float32]:
        """(frames, modes) standard deviations -> (frames, controls), not yet limited."""
        hinges = ordered_product(standardized.astype(np.float32), self.loads.T.astype(np.float32))
        hinges += self.offsets.astype(np.float32)
        np.maximum(hinges, 0, out=hinges)
        result = ordered_product(hinges, self.weights.astype(np.float32))
        result += self.base.astype(np.float32)
        return result


@dataclass(frozen=True)
class Through:
    """A rig that another rig moves: its controls are the other's times `table` (other's, own).

    `shares` (own, a, b) are controls that take the share a / b of two of the other's.
    """

    rig: Rig
    table: Array
    shares: tuple[tuple[int, int, int], ...] = ()


@dataclass(frozen=True)
class Visemes:
    """A rig whose controls are mouth shapes, chosen by phones.

    `of` (41, 2) is the control for the first and the second half of each phone of the inventory. When
    `stepped`, one shape shows at a time; else they blend, and `shapes` (controls, modes) says where each
    takes the reference face, in standard deviations; silence is the face with its lips closed.
    """

    of: NDArray[np.int64]
    stepped: bool
    shapes: Array


@dataclass(frozen=True)
class Rig:
    """The controls of a character.

    `minimum`, `maximum` and `rest` (closed lips, nothing moves) are (controls,). `mean` (controls,) is
    the character at the reference face's mean and `poses` (8, controls) at -3 and +3 standard
    deviations of modes 1 to 4, in the order of POSES: r_0 and R of Taylor 2017, equation 3. `direct` is
    a finer map, `through` another rig in front, `visemes` the choice by phones. `at_most` pairs (a, b)
    keep control a no larger than b. `speech` names the controls that speech moves. `face` is the id of the
    reference face that the numbers were made for, "" for any. `head` and `landmarks` are the files of its
    mesh, where it has one; `mouth` is the effect of each control on the measures of the mouth, `accents` the
    table of what landmarks cannot show, `tongue` the table of the places where its tongue articulates. The
    controls of a rig that is `articulated` are the channels of articulation themselves.

    Examples:
        >>> import phonanim
        >>> rig = phonanim.load_rig("arkit")
        >>> rig.minimum.shape == rig.maximum.shape == (len(rig.controls),)
        True
    """

    name: str
    title: str
    source: str
    controls: tuple[str, ...]
    minimum: Array
    maximum: Array
    rest: Array
    mean: Array
    poses: Array
    face: str = ""
    speech: tuple[str, ...] = ()
    at_most: tuple[tuple[int, int], ...] = ()
    direct: HingeMap | None = None
    through: Through | None = None
    visemes: Visemes | None = None
    head: Path | None = None
    landmarks: Path | None = None
    mouth: MouthMeasures | None = None
    accents: Path | None = None
    tongue: Path | None = None
    articulated: bool = False

    @property
    def posed(self) -> bool:
        """Whether the rig has its own eight poses."""
        return len(self.poses) > 0

    @property
    def speaks(self) -> bool:
        """Whether articulation moves the rig, or the rig that it goes through."""
        through = self.through is not None and self.through.rig.speaks
        return self.articulated or self.mouth is not None or through


def pose_map(rig: Rig) -> HingeMap:
    """Equations 2 and 3 as hinges: w = max(p / (u sqrt(p_k)), 0), controls = r_0 + (R - r_0) w.

    The hinges lie in the order of `Rig.poses`: u = -3 and +3 for each of the first four modes.
    """
    loads = np.repeat(np.eye(POSED_MODES), 2, axis=0) * np.tile([-1.0, 1.0], POSED_MODES)[:, None] / SIGMAS
    names = tuple(f"mode{k + 1}{sign}" for k in range(POSED_MODES) for sign in "-+")
    return HingeMap(names, loads, np.zeros(len(loads)), rig.poses - rig.mean, rig.mean)
