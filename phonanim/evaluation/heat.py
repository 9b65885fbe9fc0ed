"""Heat maps of errors on a corpus: which vertices, controls or channels a model misses (extra `plots`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.files import atomic_path
from phonanim.errors import EvaluationError, MissingExtraError
from phonanim.evaluation.predictions import Motion, Vertices
from phonanim.evaluation.scoring import match_channels, match_instants, without_turns
from phonanim.metrics import absolute_error, distances

Array = NDArray[np.float64]
DOTS = 110  # per inch
PREDICTIONS = "predictions"  # the name of all files of `phonanim evaluate` together
SHOWN = 40  # curves at most, those that move most


@dataclass
class Heat:
    """Sums of errors by model: of each vertex or curve, (n,), over `frames`; `places` (vertices, 2) are seen
    from the front, `names` are those of curves, `spread` (n,) is how much the captured curves move.
    """

    sums: dict[str, Array] = field(default_factory=dict)
    frames: dict[str, int] = field(default_factory=dict)
    places: Array | None = None
    names: tuple[str, ...] = ()
    spread: Array | None = None

    def add(self, motions: Mapping[str, Motion], captured: Motion) -> None:
        """Add the errors of the models on one clip."""
        for name, motion in motions.items():
            if isinstance(captured, Vertices):
                assert isinstance(motion, Vertices)
                error = distances(motion.points, captured.points)
                self.places = captured.points[:, :, :2].mean(axis=0)
            else:
                assert not isinstance(motion, Vertices)
                pairs = zip(motion.values.T, captured.values.T, strict=True)
                error = np.stack([absolute_error(a, b) for a, b in pairs], axis=1)
                self.names, self.spread = captured.channels, captured.values.std(axis=0).astype(np.float64)
            self.sums[name] = self.sums.get(name, np.zeros(error.shape[1])) + error.sum(axis=0)
            self.frames[name] = self.frames.get(name, 0) + len(error)

    def means(self) -> dict[str, Array]:
        """The mean error of each vertex or curve, (n,), by model."""
        return {name: total / self.frames[name] for name, total in self.sums.items()}

    def facts(self) -> dict[str, Any]:
        """Everything as plain numbers, for JSON: errors with four significant digits."""
        return {
            "means": {name: [float(f"{x:.4g}") for x in mean] for name, mean in self.means().items()},
            "places": None if self.places is None else self.places.round(5).tolist(),
            "names": list(self.names),
            "spread": None if self.spread is None else self.spread.round(6).tolist(),
        }

    @classmethod
    def from_facts(cls, facts: Mapping[str, Any]) -> Heat:
        """What `facts` describes, as of one frame."""
        sums = {name: np.array(mean) for name, mean in facts["means"].items()}
        places, spread = (
            None if facts[key] is None else np.array(facts[key]) for key in ("places", "spread")
        )
        return cls(sums, dict.fromkeys(sums, 1), places, tuple(facts["names"]), spread)


def add_matched(heat: Heat, predicted: Motion, captured: Motion) -> None:
    """Add the errors of a prediction at the instants, and of the controls, that both sides have.

    Raises EvaluationError for curves against vertices, and for two meshes.
    """
    predicted, captured, _ = match_instants(predicted, captured)
    if isinstance(predicted, Animation) and isinstance(captured, Animation):
        predicted, captured, _ = match_channels(without_turns(predicted), without_turns(captured))
    elif isinstance(predicted, Animation) or isinstance(captured, Animation):
        raise EvaluationError("a heat map needs curves on both sides, or vertices on both")
    elif predicted.points.shape != captured.points.shape:
        raise EvaluationError(
            f"a heat map needs one mesh: {predicted.points.shape[1]} and {captured.points.shape[1]} vertices"
        )
    heat.add({PREDICTIONS: predicted}, captured)


def check_drawable(option: str = "--heat") -> None:
    """Raise MissingExtraError without Matplotlib."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            f"a map needs Matplotlib: pip install 'phonanim[plots]', or leave out {option}"
        ) from error


def draw_heat(heat: Heat, path: Path, unit: str) -> None:
    """Draw a panel for each model: vertices from the front, or the errors of curves as a table of colours."""
    from matplotlib.figure import Figure

    means = heat.means()
    if heat.places is not None:
        figure = Figure(figsize=(3.2 * len(means) + 1, 3.6), layout="constrained")
        _draw_vertices(figure, means, heat.places, unit)
    else:
        assert heat.spread is not None
        order = np.argsort(-heat.spread, kind="stable")[:SHOWN]
        rows = order[heat.spread[order] > 0] if heat.spread.any() else order
        figure = Figure(figsize=(1.2 * len(means) + 4, 0.2 * len(rows) + 1.2), layout="constrained")
        _draw_curves(figure, means, rows, heat.names, unit)
    with atomic_path(path) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, format="png", metadata={"Software": None})


def _draw_vertices(figure: Any, means: Mapping[str, Array], places: Array, unit: str) -> None:
    most = max(float(np.percentile(mean, 99)) for mean in means.values())
    panels = figure.subplots(1, len(means), squeeze=False)[0]
    for axes, (name, mean) in zip(panels, means.items(), strict=True):
        dots = axes.scatter(*places.T, c=mean, s=3, cmap="viridis_r", vmin=0, vmax=most, linewidths=0)
        axes.set(title=name)
        axes.set_aspect("equal")
        axes.set_axis_off()
    figure.colorbar(dots, ax=list(panels), label=f"mean error of a vertex{unit}", shrink=0.8)


def _draw_curves(
    figure: Any, means: Mapping[str, Array], rows: NDArray[np.intp], names: tuple[str, ...], unit: str
) -> None:
    table = np.stack([mean[rows] for mean in means.values()], axis=1)
    axes = figure.subplots()
    image = axes.imshow(table, aspect="auto", cmap="viridis_r", vmin=0)
    axes.set_xticks(range(len(means)), list(means), rotation=20, ha="right")
    axes.set_yticks(range(len(rows)), [names[row] for row in rows], fontsize="small")
    figure.colorbar(image, ax=axes, label=f"mean absolute error{unit}", shrink=0.8)
