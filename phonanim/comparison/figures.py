"""The figures of a comparison, as SVG or PNG files (extra `plots`)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.comparison.run import model_rows
from phonanim.comparison.scores import MEASURES, measure_value
from phonanim.comparison.tables import measure_heading
from phonanim.core.files import atomic_path
from phonanim.errors import MissingExtraError
from phonanim.evaluation.statistics import bootstrap_interval
from phonanim.face.model import INNER_LIPS, OUTER_LIPS, FaceModel

Document = dict[str, Any]
OTHERS = (
    "tab:blue",
    "tab:green",
    "tab:red",
    "tab:purple",
    "tab:brown",
    "tab:pink",
    "tab:olive",
    "tab:cyan",
    "grey",
)
DOTS = 110  # per inch
DRIVERS = {"phones": "tab:blue", "audio": "tab:green", "both": "tab:red"}


def draw_all(
    document: Document, face: FaceModel, fps: float, captured: Any, variant: str, folder: Path
) -> list[str]:
    """Draw every figure that has data; -> their file names. `captured` (frames,) is the first mode."""
    plots: dict[str, Callable[[Any], None]] = {
        "bars": lambda figure: _bars(figure, document, variant),
        "sentences": lambda figure: _sentences(figure, document, variant),
        "first_mode": lambda figure: _first_mode(figure, document, captured, fps),
        "first_mode_error": lambda figure: _first_mode_error(figure, document, captured, fps),
        "heat": lambda figure: _heat(figure, document, face),
        "cost": lambda figure: _cost(figure, document, variant),
    }
    if document.get("conditions"):
        plots["conditions"] = lambda figure: _conditions(figure, document, variant)
    for name, found in document.get("sweeps", {}).items():
        plots[f"sweep_{name}"] = partial(_sweep, found=found)
    folder.mkdir(parents=True, exist_ok=True)
    for name, plot in plots.items():
        _draw(plot, folder / f"{name}.png")
    return [f"{name}.png" for name in plots]


def check_drawable() -> None:
    """Raise MissingExtraError without matplotlib. Call it before the trainings, which take long."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "figures need matplotlib; install it with pip install 'phonanim[plots]'"
        ) from error


def _draw(plot: Callable[[Any], None], path: Path) -> None:
    check_drawable()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    plot(figure)
    with atomic_path(path) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, metadata={"Software": None})


def _bars(figure: Any, document: Document, variant: str) -> None:
    """Errors on the test clips with their 95 % intervals."""
    for axes, measure in zip(figure.subplots(1, 2), ("shape_mse", "aperture_r"), strict=True):
        names, middles, reach = [], [], []
        for name in document["models"]:
            rows = model_rows(document, name, variant, "test/all")
            if rows is None:
                continue
            rng = np.random.default_rng(document["seed"])
            interval = bootstrap_interval(rows[measure], rng, MEASURES[measure].statistic)
            names.append(name)
            middles.append(measure_value(measure, rows[measure]))
            reach.append(np.abs(np.array(interval) - middles[-1]))
        colours = ["tab:orange" if name == document["reference"] else "tab:blue" for name in names]
        axes.barh(names, middles, xerr=np.array(reach).T, color=colours, capsize=3)
        axes.set_xlabel(measure_heading(measure))
        axes.set_xlim(left=min(0.0, *middles))
        axes.invert_yaxis()


def _sentences(figure: Any, document: Document, variant: str) -> None:
    """Error of every test sentence, sorted by the reference's (Taylor 2017, supplement, figure 2)."""
    reference = model_rows(document, document["reference"], variant, "test/all")
    if reference is None:
        return
    sums = reference["parameter_mse"]
    order = np.argsort(-(sums[:, 0] / sums[:, 1]), kind="stable")
    curves = {}
    for name in document["models"]:
        rows = model_rows(document, name, variant, "test/all")
        if rows is not None:
            curves[name] = (rows["parameter_mse"][:, 0] / rows["parameter_mse"][:, 1])[order]
    for axes in _panels(figure, document, np.arange(len(order)), curves):
        axes.set_ylabel(measure_heading("parameter_mse"))
    axes.set_xlabel(f"test sentences, sorted by the error of {document['reference']}")


def _first_mode(figure: Any, document: Document, captured: Any, fps: float) -> None:
    """The first shape mode over one test clip."""
    seconds = (np.arange(len(captured)) + 0.5) / fps
    for axes in _panels(figure, document, seconds, _mode_curves(document, len(seconds)), captured):
        axes.set_ylabel("first shape mode, mm")
    axes.set_xlabel(f"seconds of clip {document['folds']['test']['clips'][0]}")


def _first_mode_error(figure: Any, document: Document, captured: Any, fps: float) -> None:
    """The squared error of the first mode at each frame of that clip (Taylor 2017, supplement, figure 3)."""
    seconds = (np.arange(len(captured)) + 0.5) / fps
    curves = _mode_curves(document, len(seconds))
    errors = {name: (np.array(curve) - captured) ** 2 for name, curve in curves.items()}
    for axes in _panels(figure, document, seconds, errors):
        axes.set_ylabel("squared error of it, mm²")
    axes.set_xlabel(f"seconds of clip {document['folds']['test']['clips'][0]}")


def _mode_curves(document: Document, frames: int) -> dict[str, Any]:
    """The first shape mode of that clip by model, where it has as many frames as were captured."""
    found = {name: model["first_mode"] for name, model in document["models"].items()}
    return {name: curve for name, curve in found.items() if len(curve) == frames}


def _panels(figure: Any, document: Document, x: Any, curves: dict[str, Any], captured: Any = None) -> Any:
    """Curves of phone-driven models above those of audio-driven ones, with the reference in both panels."""
    first = document["reference"]
    hears = {name for name, found in document["models"].items() if found["driven_by"] != "phones"}
    others = [name for name in curves if name != first]
    groups = [
        names for names in ([n for n in others if n not in hears], [n for n in others if n in hears]) if names
    ]
    figure.set_size_inches(9, 3.4 * max(len(groups), 1))
    panels = figure.subplots(max(len(groups), 1), 1, sharex=True, squeeze=False).ravel()
    for axes, names in zip(panels, groups or [[]], strict=True):
        if captured is not None:
            axes.plot(x, captured, color="black", linewidth=2.5, label="captured")
        if first in curves:
            axes.plot(x, curves[first], color="tab:orange", linewidth=2.5, label=first)
        for number, name in enumerate(names):
            axes.plot(x, curves[name], color=OTHERS[number % len(OTHERS)], linewidth=1, label=name)
        axes.legend(fontsize="small", frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return panels


def _heat(figure: Any, document: Document, face: FaceModel) -> None:
    """Mean error of every landmark, on the mean face."""
    models = document["models"]
    columns = min(4, len(models))
    rows = -(-len(models) // columns)
    figure.set_size_inches(2.2 * columns, 1.9 * rows)
    grid = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
    largest = max(np.percentile(np.array(m["landmark_error"])[face.moving], 99) for m in models.values())
    for axes in grid:
        axes.set_axis_off()
    for axes, (name, found) in zip(grid, models.items(), strict=False):
        points, error = face.mean[face.moving], np.array(found["landmark_error"])[face.moving]
        dots = axes.scatter(points[:, 0], points[:, 1], c=error, s=9, cmap="inferno", vmin=0, vmax=largest)
        for line in (OUTER_LIPS, INNER_LIPS):
            ring = face.mean[face.rows((*line, line[0]))]
            axes.plot(ring[:, 0], ring[:, 1], color="grey", linewidth=0.5)
        axes.set_aspect("equal")
        axes.set_title(name, fontsize="small")
    figure.colorbar(dots, ax=grid.tolist(), label="mm", shrink=0.7)


def _cost(figure: Any, document: Document, variant: str) -> None:
    """Speed against error."""
    axes = figure.subplots()
    ends = {}
    for name, found in document["models"].items():
        rows = model_rows(document, name, variant, "test/all")
        if rows is not None:
            ends[name] = found["frames_per_s"], measure_value("shape_mse", rows["shape_mse"])
            axes.scatter(*ends[name], s=20 + found["bytes"] / 1e6, color=_colour(document, name))
    axes.set_xscale("log")
    axes.set_xlabel("frames per second of one thread (the area of a dot is the model's size)")
    axes.set_ylabel(measure_heading("shape_mse"))
    _beside(axes, document, ends)


def _beside(axes: Any, document: Document, ends: dict[str, tuple[float, float]]) -> None:
    """Put names next to their dots, as close as possible without covering another name or a dot."""
    from matplotlib.transforms import Bbox

    axes.margins(0.08)
    axes.figure.canvas.draw()  # positions are known only after drawing
    dots = axes.transData.transform(list(ends.values()))
    taken = [Bbox.from_bounds(x - 6, y - 6, 12, 12) for x, y in dots]
    for (name, end), (x, y) in zip(ends.items(), dots, strict=True):
        colour = _colour(document, name)
        text = axes.annotate(name, end, (0, 0), textcoords="offset pixels", fontsize="small", color=colour)
        text.set_in_layout(False)
        at = text.get_window_extent()
        places = [
            Bbox.from_bounds(x + dx, y + dy, at.width, at.height)
            for dx, dy in label_offsets(at.width, at.height)
        ]
        free = [box for box in places if not box.count_overlaps(taken) and _inside(box, axes.bbox)]
        taken.append(free[0] if free else places[0])
        text.set_position((taken[-1].x0 - at.x0, taken[-1].y0 - at.y0))


def _inside(box: Any, whole: Any) -> bool:
    return bool(box.x0 > whole.x0 and box.x1 < whole.x1 and box.y0 > whole.y0 and box.y1 < whole.y1)


def label_offsets(width: float, height: float) -> list[tuple[float, float]]:
    """Positions of a name relative to its dot, in pixels, the nearest first: right, left, above, below."""
    rings = [8.0 + 7.0 * ring for ring in range(8)]
    return [
        place
        for reach in rings
        for place in (
            (reach, -height / 2),
            (-reach - width, -height / 2),
            (-width / 2, reach),
            (-width / 2, -reach - height),
            (reach * 0.7, reach * 0.7),
            (reach * 0.7, -reach * 0.7 - height),
            (-reach * 0.7 - width, reach * 0.7),
            (-reach * 0.7 - width, -reach * 0.7 - height),
        )
    ]


def _conditions(figure: Any, document: Document, variant: str) -> None:
    """Lip aperture r on the clean test clips and under each condition; a line for each model."""
    axes = figure.subplots()
    names, ends = ["clean", *document["conditions"]], {}
    places = ["test/all", *[f"with {name}/all" for name in document["conditions"]]]
    for name in document["models"]:
        found = [model_rows(document, name, variant, where) for where in places]
        heights = [measure_value("aperture_r", rows["aperture_r"]) for rows in found if rows is not None]
        width = 2.5 if name == document["reference"] else 1.0
        axes.plot(names, heights, "o-", markersize=3, color=_colour(document, name), linewidth=width)
        ends[name] = len(names) - 1.0, heights[-1]
    axes.tick_params(axis="x", rotation=30)
    axes.set_ylabel(measure_heading("aperture_r"))
    _label(axes, document, ends)


def _colour(document: Document, name: str) -> str:
    """A colour by the input of a model; the reference has its own colour."""
    if name == document["reference"]:
        return "tab:orange"
    return DRIVERS[document["models"][name]["driven_by"]]


def _label(axes: Any, document: Document, ends: dict[str, tuple[float, float]]) -> None:
    """Names in a column at the right, each connected to its curve, without overlap."""
    low, high = axes.get_ylim()
    names = sorted(ends, key=lambda name: ends[name][1])
    heights = np.array([(ends[name][1] - low) / (high - low) for name in names])
    for name, height in zip(names, spread_labels(heights, 1 / 22), strict=True):
        axes.annotate(
            name,
            ends[name],
            xytext=(1.06, height),
            textcoords="axes fraction",
            va="center",
            fontsize="small",
            color=_colour(document, name),
            arrowprops={"arrowstyle": "-", "color": "lightgrey", "linewidth": 0.6, "shrinkA": 0},
        )
    axes.set_ylim(low, high)


def spread_labels(heights: NDArray[np.float64], gap: float) -> NDArray[np.float64]:
    """Move rising heights as little as possible so that they are `gap` apart and below 1, (n,) -> (n,)."""
    steps = gap * np.arange(len(heights))
    risen = np.maximum.accumulate(heights - steps) + steps
    room = 1 - gap * np.arange(len(heights))[::-1]
    return np.asarray(np.minimum(risen, room))


def _sweep(figure: Any, found: dict[str, Any]) -> None:
    """A setting against the error on held-out training clips."""
    ways = {"shape_mse": "all frames", "speech_shape_mse": "speech"}
    known = [way for way in ways if all(way in row for row in found["rows"])]
    panels = figure.subplots(1, len(known), sharey=True, squeeze=False)[0]
    series = list(dict.fromkeys(str(row.get(found["series"], "")) for row in found["rows"]))
    for axes, way in zip(panels, known, strict=True):
        for name in series:
            rows = [row for row in found["rows"] if str(row.get(found["series"], "")) == name]
            label = f"{found['series']} = {name}" if name else None
            axes.plot([str(row[found["x"]]) for row in rows], [row[way] for row in rows], "o-", label=label)
        axes.set_xlabel(found["x"])
        axes.set_title(ways[way], fontsize="medium")
    panels[0].set_ylabel(measure_heading("shape_mse"))
    figure.suptitle(found["label"], fontsize="medium")
    if series != [""]:
        panels[0].legend(fontsize="small")
