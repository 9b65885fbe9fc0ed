"""Articulation in millimetres -> a rig's controls: the jaw first, then the lips given the jaw.

Bounded least squares of the mouth's measures (phonanim/rig/measures.py), frame by frame, so that no frame
depends on another. Three solutions are blended: free lips, lips that touch along their whole length (p b m),
and a lower lip on the upper teeth (f v). Since controls add up linearly, a blend keeps the constraints that
its solutions keep.

The shipped head is the reference: where its lips go farther than articulation asks (its funnel narrows them
and pushes them forward together), another head is asked to go as far, so that all look alike.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import Articulation
from phonanim.core.exact import ordered_product, sparse_product
from phonanim.core.same import Same
from phonanim.rig.bounded import QUICK, THOROUGH, minimize
from phonanim.rig.measures import MEASURES, USES, MouthMeasures
from phonanim.rig.read import load_rig
from phonanim.rig.rig import Rig

Array = NDArray[np.float64]

BLOCK = 4096  # frames per block, so that their data fit in the cache
TOUCHING = 1.2  # mm of lip gap below which the solution for closed lips begins to blend in
TUCKING = 1.5  # mm from lower lip to teeth below which the solution for contact blends in
SHARED = 4.0  # mm² of a control's square: controls with the same effect share the motion
DRAWN = 0.3  # pull of a control to its ceiling, as a share of the pull of the mouth's measures
PRESSED = 0.25  # value of the controls that press lips together, where they press by PRESSING
PRESSING = 0.8  # mm of lip gap below contact
# Share of the middle's gap at the four gaps: when the jaw parts the lips, and in a round mouth.
PROFILE, ROUND = np.array([1.0, 0.87, 0.67, 0.43]), np.array([1.0, 0.85, 0.4, 0.0])
USUAL = 0.05  # share by which the profiles of heads such as the shipped one differ
NARROW, FORWARD = -6.0, 4.0  # mm of width and of protrusion, from rest, at which a mouth is round
SPREADING = 5.0  # mm of width at full weight of a control that a round mouth does not use
ROUNDING = 0.5  # of roundness, the last part of it, in which it goes
LEAST = 1e-6  # mm, so that nothing is divided by zero
CONTACT = 0.3  # mm from lower lip to teeth at which they meet
GAPS = ("gap", "gap_inner", "gap_outer", "gap_corner")
CHANNEL_OF = {"jaw": "jaw", "width": "lip_width", "protrusion": "protrusion", "upper_lip": "upper_lip"}
# Weight of a millimetre of each measure, in the order of MEASURES.
WEIGHTS = {
    "free": (4.0, 4.0, 1.0, 1.5, 3.0, 1.5, 2.0, 0.8, 0.0, 0.0),
    "closed": (4.0, 12.0, 12.0, 12.0, 12.0, 1.0, 1.0, 0.5, 0.0, 0.0),
    "tucked": (4.0, 0.0, 0.0, 0.0, 0.0, 0.7, 0.3, 1.5, 4.0, 4.0),
}
# The same where no control moves the jaw alone. What opens the lips then opens the teeth with them, and what
# rounds and what opens share a sum: without more weight on the width, round mouths stay broad.
AMONG_OTHERS = {"jaw": 1.5, "width": 2.2, "protrusion": 1.5}
REFERENCE, SAME = "arkit", 0.01  # the rig of the shipped head; mm, by which tables of the same head differ
LIP_ON_TEETH = (0.3, 0.6)  # mm up and forward from the incisors' edge, of the lower lip's rim when they meet


def pronounce(
    articulation: Articulation, rig: Rig, measures: MouthMeasures, near: Array | None = None
) -> NDArray[np.float32]:
    """Controls that produce this articulation, (frames, channels) mm -> (frames, controls).

    `near` (frames, controls) is an upper limit of controls, and pulls them to it; inf where free.
    """
    values = np.empty((len(articulation.values), len(rig.controls)), np.float32)
    mouth = _mouth(Same(rig), Same(measures))
    ceiling = np.full((len(values), len(measures.names)), np.inf) if near is None else near[:, mouth.lead]
    for start in range(0, len(values), BLOCK):
        block = slice(start, start + BLOCK)
        part = Articulation(articulation.values[block], articulation.channels)
        if mouth.follows:
            part = _asked(part, _reference())
        values[block] = rig.rest + sparse_product(_blended(part, mouth, ceiling[block]), mouth.spread)
    return values


def _asked(articulation: Articulation, reference: _Mouth) -> Articulation:
    """The same, where the lips of the reference go farther than asked, as far as they go."""
    free = np.full((len(articulation.values), len(reference.measures.names)), np.inf)
    shown = ordered_product(_blended(articulation, reference, free), reference.measures.moved)
    values = articulation.values.copy()
    for name in ("width", "protrusion"):
        own = values[:, articulation.channels.index(CHANNEL_OF[name])]
        there = shown[:, MEASURES.index(name)]
        own[:] = np.maximum(np.maximum(own, there), 0) + np.minimum(np.minimum(own, there), 0)
    return Articulation(values, articulation.channels)


@lru_cache(maxsize=1)
def _reference() -> _Mouth:
    """The mouth of the shipped head."""
    rig = load_rig(REFERENCE)
    assert rig.mouth is not None
    return replace(_Mouth.of(rig, rig.mouth), follows=False)


@lru_cache(maxsize=16)
def _mouth(rig: Same[Rig], measures: Same[MouthMeasures]) -> _Mouth:
    """The mouth of a rig, which is prepared once for many lines."""
    found = _Mouth.of(rig.value, measures.value)
    return replace(found, follows=not _same(found.measures, _reference().measures))


def _same(one: MouthMeasures, other: MouthMeasures) -> bool:
    """Whether two tables are of the same head and the same shapes, but for rounding."""
    return (
        one.names == other.names
        and np.allclose(one.moved, other.moved, atol=SAME)
        and np.allclose(one.rest, other.rest, atol=SAME)
    )


Limits = tuple[Array, Array, tuple[tuple[int, int], ...]]


def mouth_limits(articulation: Articulation, rig: Rig, measures: MouthMeasures) -> Limits:
    """Least and greatest weights of what moves a mouth, (unknowns,) and (frames, unknowns).

    Beside them are pairs of which the first stays below the second. Each control is used as `pronounce` uses
    it: what spreads not in round mouths, what presses not in open ones, and visemes of open mouths not in
    closed ones.
    """
    mouth = _mouth(Same(rig), Same(measures))
    touching, tucked = _contacts(articulation)
    used = {name: measures.uses[:, USES.index(name)].astype(float) for name in USES}
    share = ((1 - touching) * (1 - tucked))[:, None] * used["free"]
    share += ((1 - touching) * tucked)[:, None] * used["tucked"]
    share += touching[:, None] * np.maximum(used["closed"], used["pressed"])
    high = mouth.minimum + share * (mouth.maximum - mouth.minimum)
    return mouth.minimum, _unspread(high, mouth.minimum, articulation, measures), mouth.under


def _unspread(high: Array, low: Array, articulation: Articulation, measures: MouthMeasures) -> Array:
    """Upper limits (frames, unknowns), those of what spreads the lips lowered to `low` in round mouths."""
    spreading = measures.moved[:, MEASURES.index("width")] > SPREADING
    left = np.clip((1 - _roundness(articulation)) / ROUNDING, 0, 1)[:, None]
    return np.where(spreading, np.maximum(low, high * left), high)


@dataclass(frozen=True)
class _Mouth:
    """The unknowns: `spread` (unknowns, controls) converts them to controls, `lead` (unknowns,) is the first
    control of each.

    `under` are pairs (a, b) of unknowns with a at most b: lips may close only as far as the jaw opens them.
    `jaw` is that jaw, which is set first; None where the jaw is one measure among others.
    `follows` is False for the shipped head, which other heads follow.
    """

    measures: MouthMeasures
    spread: Array
    lead: NDArray[np.int64]
    minimum: Array
    maximum: Array
    jaw: int | None
    under: tuple[tuple[int, int], ...]
    follows: bool = True

    @classmethod
    def of(cls, rig: Rig, measures: MouthMeasures) -> _Mouth:
        spread = np.array([np.isin(rig.controls, names) for names in measures.names], np.float64)
        lead = np.array([rig.controls.index(names[0]) for names in measures.names])
        rows = {control: row for row, names in enumerate(measures.names) for control in names}
        pairs = [(rows.get(rig.controls[a]), rows.get(rig.controls[b])) for a, b in rig.at_most]
        under = tuple((a, b) for a, b in pairs if a is not None and b is not None)
        return cls(
            measures,
            spread,
            lead,
            (rig.minimum - rig.rest)[lead],
            (rig.maximum - rig.rest)[lead],
            under[0][1] if under else None,
            under,
        )

    @cached_property
    def uses(self) -> dict[str, _Use]:
        """What is needed for each solution."""
        return {use: _Use.of(self, use) for use in WEIGHTS}


class _Use(NamedTuple):
    """One solution's unknowns, `moving` (unknowns,), the weight of each measure, and the weighted measures at
    full weight, `seen` (unknowns, measures), with their products, `gram`.
    """

    moving: NDArray[np.int64]
    weights: Array
    seen: Array
    gram: Array

    @classmethod
    def of(cls, mouth: _Mouth, use: str) -> _Use:
        used = mouth.measures.uses[:, USES.index(use)]
        moving = np.flatnonzero(used & (np.arange(len(used)) != mouth.jaw))
        weights = _weights(mouth, use)
        seen = mouth.measures.moved[moving] * weights
        return cls(moving, weights, seen, ordered_product(seen, seen.T))


def _blended(articulation: Articulation, mouth: _Mouth, ceiling: Array) -> Array:
    """The three solutions blended, (frames, channels) -> (frames, unknowns)."""
    touching, tucked = _contacts(articulation)
    values = _solved(articulation, mouth, ceiling, "free")
    for use, share in (("tucked", tucked), ("closed", touching)):
        near = np.flatnonzero(share > 0)
        part = Articulation(articulation.values[near], articulation.channels)
        values[near] += share[near, None] * (_solved(part, mouth, ceiling[near], use) - values[near])
    return values


def _contacts(articulation: Articulation) -> tuple[Array, Array]:
    """The shares of the solutions for lips that touch and for a lip on the teeth, (frames,) each."""
    gap, teeth = articulation.channel("lip_gap"), articulation.channel("lower_lip_to_teeth")
    return np.clip(1 - gap / TOUCHING, 0, 1), np.clip((TUCKING - teeth) / (TUCKING - CONTACT), 0, 1)


def _solved(articulation: Articulation, mouth: _Mouth, ceiling: Array, use: str) -> Array:
    """One solution, (frames, channels) -> (frames, unknowns)."""
    measures, (moving, weights, seen, gram) = mouth.measures, mouth.uses[use]
    wanted = _wanted(articulation, measures, use)
    fixed = np.zeros((len(wanted), len(measures.names)))
    if mouth.jaw is not None:
        jaw = wanted[:, MEASURES.index("jaw")] / measures.moved[mouth.jaw, MEASURES.index("jaw")]
        fixed[:, mouth.jaw] = np.clip(jaw, mouth.minimum[mouth.jaw], mouth.maximum[mouth.jaw])
    if use == "closed":
        fixed += _pressing(articulation, measures, ceiling)
    low, high = mouth.minimum + fixed, np.minimum(mouth.maximum + fixed, ceiling)
    if use == "free":
        high = _unspread(high, low, articulation, measures)
    for a, b in mouth.under:
        high[:, a] = np.minimum(high[:, a], fixed[:, b])
    drawn = np.isfinite(ceiling[:, moving]).T
    own = DRAWN * (seen**2).sum(axis=1) * drawn.any(axis=1)
    fixed[:, moving] = (
        minimize(
            gram + np.diag(SHARED + own),
            ordered_product(seen, ((wanted - ordered_product(fixed, measures.moved)) * weights).T)
            + own[:, None] * np.where(drawn, ceiling[:, moving].T, 0),
            measures.effort[moving],
            (low - fixed)[:, moving].T,
            (high - fixed)[:, moving].T,
            measures.uses[moving, USES.index("shared")],
            THOROUGH if mouth.follows else QUICK,
        ).T
        + fixed[:, moving]
    )
    return fixed


def _weights(mouth: _Mouth, use: str) -> Array:
    """Weight of a millimetre of each measure, (measures,)."""
    weights = np.array(WEIGHTS[use])
    if mouth.jaw is None:
        for name, weight in AMONG_OTHERS.items() if use == "free" else [("jaw", AMONG_OTHERS["jaw"])]:
            weights[MEASURES.index(name)] = weight
    return weights


def _pressing(articulation: Articulation, measures: MouthMeasures, ceiling: Array) -> Array:
    """Controls that press closed lips together, (frames, unknowns).

    A viseme that closes the lips shows as far as its phones are near, and no further than lips that press.
    """
    pressing = np.clip(-articulation.channel("lip_gap") / PRESSING, 0, 1)
    pressed, shared = (measures.uses[:, USES.index(use)] for use in ("pressed", "shared"))
    gap = MEASURES.index("gap")
    needed = (measures.rest[gap] + PRESSING) / np.maximum(-measures.moved[:, gap], LEAST)
    viseme = np.minimum(np.minimum(ceiling, needed.clip(0, 1)), 1.0)
    return np.where(pressed, np.where(shared, viseme, PRESSED * pressing[:, None]), 0.0)


def _wanted(articulation: Articulation, measures: MouthMeasures, use: str) -> Array:
    """The measures to reach from rest, (frames, channels) -> (frames, measures) mm."""
    wanted = np.zeros((len(articulation.values), len(MEASURES)))
    gap = np.maximum(articulation.channel("lip_gap"), 0) if use == "free" else 0 * articulation.channel("jaw")
    narrow = _roundness(articulation)[:, None]
    columns = [MEASURES.index(name) for name in GAPS]
    profile, rounded = _profiles(measures)
    wanted[:, columns] = gap[:, None] * (profile + narrow * (rounded - profile))
    for name, channel in CHANNEL_OF.items():
        wanted[:, MEASURES.index(name)] = articulation.channel(channel)
    wanted[:, MEASURES.index("lower_lip_up")], wanted[:, MEASURES.index("lower_lip_forward")] = LIP_ON_TEETH
    return wanted - measures.rest


def _profiles(measures: MouthMeasures) -> tuple[Array, Array]:
    """Shares of the middle's gap at the four gaps, in a mouth that opens and in a round one, (4,) each.

    A drawn mouth may open at its corners as far as in the middle: the profile is that of the shape that opens
    this head's lips farthest.
    """
    gaps = measures.moved[:, [MEASURES.index(name) for name in GAPS]]
    opener = gaps[gaps[:, 0].argmax()]
    own = np.clip(opener / max(float(opener[0]), LEAST), 0, 1)
    if np.abs(own - PROFILE).max() < USUAL:
        return PROFILE, ROUND
    return own, np.clip(ROUND + own - PROFILE, 0, 1)


def _roundness(articulation: Articulation) -> Array:
    """How round a mouth is asked for, 0 to 1, (frames,): narrow, or lips that stand out."""
    narrow, forward = (
        articulation.channel(name) / most for name, most in (("lip_width", NARROW), ("protrusion", FORWARD))
    )
    return np.clip(np.maximum(narrow, forward), 0, 1)
