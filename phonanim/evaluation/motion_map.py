"""Motion maps: how much each vertex, control or channel moves, predicted and captured (extra `plots`).

Mean and standard deviation over time of the motion from frame to frame, as speed, so that files of different
rates can be compared. Source: Stan 2023, figures 16, 17 and 22 to 24, which leave the unit open.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.files import atomic_path
from phonanim.errors import EvaluationError
from phonanim.evaluation.predictions import Motion, Vertices
from phonanim.evaluation.scoring import match_channels, without_turns

Array = NDArray[np.float64]
DOTS = 110  # per inch
SHOWN = 40  # curves at most, those that move most in the reference
SIDES = PREDICTED, REFERENCE = "predictions", "reference"
MEASURES = {"mean": "mean speed", "sd": "standard deviation of the speed"}


@dataclass
class MotionMap:
    """Sums of speeds and of their squares by side, (n,), over `steps` from frame to frame.

    `places` are the mean places of vertices from the front, (vertices, 2), `names` the names of curves.
    """

    sums: dict[str, Array] = field(default_factory=dict)
    squares: dict[str, Array] = field(default_factory=dict)
    steps: dict[str, int] = field(default_factory=dict)
    places: dict[str, Array] = field(default_factory=dict)
    names: tuple[str, ...] = ()

    def add(self, predicted: Motion, captured: Motion) -> None:
        """Add a line. Raises EvaluationError for curves against vertices, and for meshes of two sizes."""
        if isinstance(predicted, Animation) and isinstance(captured, Animation):
            predicted, captured, _ = match_channels(without_turns(predicted), without_turns(captured))
            self.names = captured.channels
        elif isinstance(predicted, Animation) or isinstance(captured, Animation):
            raise EvaluationError("a motion map needs curves on both sides, or vertices on both")
        for side, motion in zip(SIDES, (predicted, captured), strict=True):
            self._add(side, motion)

    def _add(self, side: str, motion: Motion) -> None:
        if isinstance(motion, Vertices):
            speed = np.linalg.norm(np.diff(motion.points, axis=0), axis=2) * motion.fps
            self.places[side] = motion.points[:, :, :2].mean(axis=0)
        else:
            speed = np.abs(np.diff(motion.values.astype(np.float64), axis=0)) * motion.fps
        known = self.sums.get(side, np.zeros(speed.shape[1]))
        if known.shape != speed.shape[1:]:
            what = "vertices" if isinstance(motion, Vertices) else "curves"
            raise EvaluationError(f"a motion map needs one mesh: {len(known)} and {speed.shape[1]} {what}")
        self.sums[side] = known + speed.sum(axis=0)
        self.squares[side] = self.squares.get(side, np.zeros(speed.shape[1])) + (speed**2).sum(axis=0)
        self.steps[side] = self.steps.get(side, 0) + len(speed)

    def measures(self) -> dict[str, dict[str, Array]]:
        """By measure and side: mean and standard deviation of the speed of each vertex or curve, (n,)."""
        mean = {side: total / max(self.steps[side], 1) for side, total in self.sums.items()}
        square = {side: total / max(self.steps[side], 1) for side, total in self.squares.items()}
        spread = {side: np.sqrt(np.maximum(square[side] - mean[side] ** 2, 0)) for side in mean}
        return {"mean": mean, "sd": spread}


def draw_motion(found: MotionMap, path: Path, unit: str) -> None:
    """Draw a column for each side and a row for each measure, or a table of colours for curves."""
    from matplotlib.figure import Figure

    if found.places:
        figure = Figure(figsize=(7.5, 7.2), layout="constrained")
        _draw_vertices(figure, found.measures(), found.places, unit)
    else:
        order = np.argsort(-found.measures()["mean"][REFERENCE], kind="stable")[:SHOWN]
        figure = Figure(figsize=(6.4, 0.2 * len(order) + 1.4), layout="constrained")
        _draw_curves(figure, found.measures(), order, found.names)
    with atomic_path(path) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, format="png", metadata={"Software": None})


def _draw_vertices(
    figure: Any, measures: Mapping[str, Mapping[str, Array]], places: Mapping[str, Array], unit: str
) -> None:
    panels = figure.subplots(len(measures), len(SIDES), squeeze=False)
    for row, (measure, sides) in zip(panels, measures.items(), strict=True):
        most = max(float(np.percentile(values, 99)) for values in sides.values()) or 1.0
        for axes, (side, values) in zip(row, sides.items(), strict=True):
            dots = axes.scatter(*places[side].T, c=values, s=3, cmap="turbo", vmin=0, vmax=most, linewidths=0)
            axes.set(title=side)
            axes.set_aspect("equal")
            axes.set_axis_off()
        figure.colorbar(dots, ax=list(row), label=f"{MEASURES[measure]}, {unit}/s", shrink=0.8)


def _draw_curves(
    figure: Any,
    measures: Mapping[str, Mapping[str, Array]],
    rows: NDArray[np.intp],
    names: tuple[str, ...],
) -> None:
    panels = figure.subplots(1, len(measures), sharey=True)
    for axes, (measure, sides) in zip(panels, measures.items(), strict=True):
        table = np.stack([values[rows] for values in sides.values()], axis=1)
        image = axes.imshow(table, aspect="auto", cmap="turbo", vmin=0)
        axes.set_xticks(range(len(sides)), list(sides), rotation=20, ha="right")
        axes.set_yticks(range(len(rows)), [names[row] for row in rows], fontsize="small")
        figure.colorbar(image, ax=axes, label=f"{MEASURES[measure]}, full weights/s", shrink=0.8)
