"""Errors of meshes and of landmarks, (frames, vertices, 3), in the unit of their coordinates (mm here).

Masks are rows of vertices: phonanim/face/masks.py reads them. In the equations, v and w are a predicted and a
captured vertex, T is the number of frames and V the number of vertices of the mask.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import EvaluationError
from phonanim.face.model import FaceModel
from phonanim.metrics.arrays import Array, difference

Shapes = NDArray[np.floating]
Rows = NDArray[np.integer] | NDArray[np.bool_] | slice
EVERY = slice(None)


def vertex_error(predicted: Shapes, captured: Shapes, face: FaceModel) -> Array:
    """Mean distance between corresponding moving landmarks, (frames, landmarks, 3) -> (frames,) mm."""
    return np.asarray(distances(predicted, captured, face.moving).mean(axis=1), np.float64)


def distances(predicted: Shapes, captured: Shapes, rows: Rows = EVERY) -> Array:
    """Distances |v_tk - w_tk| between corresponding vertices, (frames, vertices, 3) -> (frames, rows) mm.

    Their mean over frames is the heat map of an error. Raises EvaluationError when the shapes differ.
    """
    return np.asarray(np.linalg.norm(difference(predicted[:, rows], captured[:, rows]), axis=2))


def mean_vertex_error(predicted: Shapes, captured: Shapes, rows: Rows = EVERY) -> Array:
    """MVE: mean distance of the vertices per frame, (frames, vertices, 3) -> (frames,) mm.

    e_t = 1/V sum_k |v_tk - w_tk|. FaceDiffuser (2023, section 5.3.3) calls it mean squared vertex error, but
    its published figures are means of distances. Squared, in mm²: `squared_error` x 3.
    """
    return np.asarray(distances(predicted, captured, rows).mean(axis=1))


def lip_vertex_error(predicted: Shapes, captured: Shapes, lips: Rows, squared: bool = False) -> Array:
    """LVE: the largest error of a lip vertex per frame, (frames, vertices, 3) -> (frames,) mm, or mm².

    e_t = max_k |v_tk - w_tk| as Richard et al. define it ("MeshTalk", 2021: the maximal L2 error of all lip
    vertices). `squared` gives the version that the released code of CodeTalker (Xing et al. 2023) and
    FaceDiffuser computes under the same name. The mean over frames is LVE.
    """
    largest = distances(predicted, captured, lips).max(axis=1)
    return np.asarray(largest**2 if squared else largest)


def temporal_mean_vertex_error(
    predicted: Shapes, captured: Shapes, regions: Mapping[str, Rows], squared: bool = False
) -> dict[str, float]:
    """TMVE by region, over frames and the region's vertices, (frames, vertices, 3) -> mm each, or mm².

    1/(S K) sum_j sum_k |v_jk - w_jk|, or the mean of its square with `squared`. Equation 4.29 of Medina 2023
    is for one sample; its 2 can be read as the norm's name or as a square. Weight samples of different
    lengths by frames.
    """
    power = 2 if squared else 1
    return {
        name: float((distances(predicted, captured, rows) ** power).mean()) for name, rows in regions.items()
    }


def dynamics_deviation(
    predicted: Shapes,
    captured: Shapes,
    rest: NDArray[np.floating],
    upper: Rows,
    motion: Literal["offset", "squared offset", "step"] = "offset",
) -> float:
    """FDD: how much more the captured upper face moves than the predicted; 0 is best, below 0 too lively.

    1/V sum_k (sd_t |w_tk - r_k| - sd_t |v_tk - r_k|), with sd over frames and `rest` (vertices, 3) the face
    at rest. "offset", mm: as CodeTalker's paper defines it (Xing et al. 2023). "squared offset", mm²: squared
    lengths, as its released code computes the published figures. "step", mm per frame: the motion is from
    frame to frame, as FaceDiffuser's paper defines it (2023, equation 6). `predicted` and `captured` are
    (frames, vertices, 3); the numbers of frames may differ. Raises EvaluationError for another `motion`.
    """
    return float(
        (_activity(captured, rest, upper, motion) - _activity(predicted, rest, upper, motion)).mean()
    )


def _activity(shapes: Shapes, rest: NDArray[np.floating], rows: Rows, motion: str) -> Array:
    """Standard deviation of each vertex's motion over time, (rows,)."""
    points = np.asarray(shapes[:, rows], np.float64)
    if motion == "step":
        return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=2).std(axis=0))
    lengths = np.linalg.norm(points - rest[rows], axis=2)
    powers = {"offset": 1, "squared offset": 2}
    if motion not in powers:
        raise EvaluationError(f"there is no motion {motion!r}; use offset, squared offset or step")
    return np.asarray((lengths ** powers[motion]).std(axis=0))


def diversity(takes: Shapes, rows: Rows = EVERY) -> float:
    """Mean distance between any two takes of one line, (takes, frames, vertices, 3) -> mm.

    2/(S (S - 1)) sum_{i<j} mean_{t,k} |v^i_tk - v^j_tk| over S takes: several styles, speakers or draws
    (FaceDiffuser 2023, equation 7). 0 for a deterministic method. Raises EvaluationError for fewer than two.
    """
    if len(takes) < 2:
        raise EvaluationError(f"diversity needs at least two takes of a line, not {len(takes)}")
    first, second = np.triu_indices(len(takes), k=1)
    pairs = zip(first, second, strict=True)
    return float(np.mean([distances(takes[i], takes[j], rows).mean() for i, j in pairs]))
