"""Lip gaps, and whether the lips close where speech closes them."""

from __future__ import annotations

import numpy as np

from phonanim.errors import EvaluationError
from phonanim.face.model import INNER_LIP_PAIRS, FaceModel
from phonanim.metrics.arrays import Array
from phonanim.metrics.vertices import Shapes
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

BILABIALS = ("p", "b", "m")
LABIODENTALS = ("f", "v")


def lip_gap(shapes: Shapes, face: FaceModel) -> Array:
    """Mean vertical distance of the seven inner-lip pairs, (frames, landmarks, 3) -> (frames,) mm."""
    upper, lower = (face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    return np.asarray((shapes[:, upper, 1] - shapes[:, lower, 1]).mean(axis=1), np.float64)


def least_gaps(gap: Array, times: Array, track: PhoneTrack, phones: tuple[str, ...] = BILABIALS) -> Array:
    """The smallest lip gap during each segment of some phones, (frames,) mm twice -> (segments,) mm.

    g_s = min_t gap_t over the frames in the segment, or the frame nearest to its middle when it contains no
    frame; overlapping lips count as closed (0 mm). `times` (frames,) are seconds, rising. Segments whose
    middle is outside the frames are left out.
    """
    chosen = np.isin(track.codes, INVENTORY.codes(phones))
    spans = np.column_stack([track.bounds[:-1], track.bounds[1:]])[chosen]
    half = (times[-1] - times[0]) / max(len(times) - 1, 1) / 2
    middles = spans.mean(axis=1)
    spans = spans[(middles >= times[0] - half) & (middles <= times[-1] + half)]
    return np.array([max(0.0, _least(gap, times, *span)) for span in spans])


def closure_error(
    predicted: Array,
    captured: Array,
    times: Array,
    track: PhoneTrack,
    phones: tuple[str, ...] = BILABIALS,
) -> Array:
    """How much further open the lips stay than captured lips in each segment, (frames,) mm -> (segments,) mm.

    e_s = max(0, g_s(predicted) - g_s(captured)), with g of `least_gaps`. For p b m it is the remaining gap of
    a missed closure; for f v, where the lip meets the teeth, it is measured against the captured gap. Raises
    EvaluationError when the curves differ in length.
    """
    if not len(predicted) == len(captured) == len(times):
        raise EvaluationError(
            f"lip gaps of {len(predicted)} and {len(captured)} frames at {len(times)} times; they must agree"
        )
    gaps = (least_gaps(gap, times, track, phones) for gap in (predicted, captured))
    return np.asarray(np.maximum(0.0, np.subtract(*gaps)))


def _least(gap: Array, times: Array, begin: float, end: float) -> float:
    inside = (times >= begin) & (times < end)
    inside[np.argmin(np.abs(times - (begin + end) / 2))] = True
    return float(gap[inside].min())
