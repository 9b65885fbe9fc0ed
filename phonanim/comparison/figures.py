"""The figures of a comparison, as SVG or PNG files (extra `plots`): what of the document each one shows."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.comparison import plots
from phonanim.comparison.measures import MEASURES
from phonanim.comparison.overview import KINDS
from phonanim.comparison.run import model_rows, seeded_rows
from phonanim.comparison.scores import measure_value
from phonanim.comparison.tables import interval, measure_heading
from phonanim.core.files import atomic_path
from phonanim.errors import MissingExtraError
from phonanim.face.model import INNER_LIPS, OUTER_LIPS, FaceModel

Document = dict[str, Any]
DOTS = 110  # per inch
SETTINGS = {
    "reach": "input window Kx, frames",
    "width": "output window Ky, frames",
    "clips": "share of the training clips",
}
"""Labels of the settings of sweeps; any other setting has its own name."""


def draw_all(
    document: Document, face: FaceModel, fps: float, captured: Any, variant: str, folder: Path
) -> list[str]:
    """Draw every figure that has data; -> their file names. `captured` (frames,) is the first mode."""
    drawn: dict[str, Callable[[Any], None]] = {
        "bars": lambda figure: _bars(figure, document, variant),
        "sentences": lambda figure: _sentences(figure, document, variant),
        "first_mode": lambda figure: _first_mode(figure, document, captured, fps),
        "first_mode_error": lambda figure: _first_mode_error(figure, document, captured, fps),
        "heat": lambda figure: _heat(figure, document, face),
        "cost": lambda figure: _cost(figure, document, variant),
    }
    if document.get("conditions"):
        drawn["conditions"] = lambda figure: _conditions(figure, document, variant)
    for name, found in document.get("sweeps", {}).items():
        drawn[f"sweep_{name}"] = partial(_sweep, found=found)
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in drawn.items():
        draw_file(draw, folder / f"{name}.png")
    return [f"{name}.png" for name in drawn]


def check_drawable() -> None:
    """Raise MissingExtraError without matplotlib. Call it before the trainings, which take long."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "figures need matplotlib; install it with pip install 'phonanim[plots]'"
        ) from error


def draw_file(draw: Callable[[Any], None], path: Path) -> None:
    """Write one figure, which `draw` fills. Raises MissingExtraError, OutputError."""
    check_drawable()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), dpi=DOTS, layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure)
    with atomic_path(path) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, metadata={"Software": None})


def shown_models(document: Document, names: list[str]) -> list[plots.Shown]:
    """Some models of a document, as a figure shows them."""
    models = document["models"]
    return [plots.Shown(n, models[n]["driven_by"], n == document["reference"]) for n in names]


def _scored(document: Document, variant: str) -> list[str]:
    """Models with test scores."""
    return [n for n in document["models"] if model_rows(document, n, variant, "test/all") is not None]


def _value(document: Document, name: str, variant: str, where: str, measure: str) -> list[float]:
    """A measure and its 95 % interval."""
    rows = (model_rows(document, name, variant, where) or {})[measure]
    by_seed = (seeded_rows(document, name, variant, where) or {})[measure]
    return [measure_value(measure, rows), *interval(document, by_seed, MEASURES[measure].statistic)]


def _bars(figure: Any, document: Document, variant: str) -> None:
    """The error and the lip gap of the table beside them, with their 95 % intervals."""
    models = document["models"]
    names = sorted(_scored(document, variant), key=lambda name: KINDS.index(models[name]["driven_by"]))
    spoken = [name for name in names if model_rows(document, name, variant, "test/speech") is not None]
    where = "speech" if spoken == names else "all"
    headings = {"vertex_error": "all", "aperture_r": where}
    panels = {
        f"{measure_heading(measure)}{' in speech' * (part == 'speech')}": np.array(
            [_value(document, name, variant, f"test/{part}", measure) for name in names]
        )
        for measure, part in headings.items()
    }
    plots.draw_bars(figure, shown_models(document, names), panels)


def _sentences(figure: Any, document: Document, variant: str) -> None:
    """Error of every test sentence, sorted by the reference's (Taylor 2017, supplement, figure 2)."""
    errors = {}
    for name in _scored(document, variant):
        sums = (model_rows(document, name, variant, "test/all") or {})["parameter_mse"]
        errors[name] = sums[:, 0] / sums[:, 1]
    if document["reference"] not in errors:
        return
    known = errors[document["reference"]]
    order = np.argsort(-known, kind="stable")
    at = np.arange(len(order))
    for axes, model in plots.model_panels(figure, shown_models(document, list(errors))):
        axes.bar(at, known[order], 1.0, color="lightgrey")
        axes.plot(at, errors[model.name][order], ".", markersize=3, color=model.colour)
    figure.axes[0].set_ylim(bottom=0.0)  # common to all panels, so only once all are drawn
    figure.supxlabel(
        f"test sentences, sorted by the error of {document['reference']} (grey)", fontsize="medium"
    )
    figure.supylabel(measure_heading("parameter_mse"), fontsize="medium")


def _first_mode(figure: Any, document: Document, captured: Any, fps: float) -> None:
    """The first shape mode over one test clip."""
    seconds, curves = _mode_curves(document, captured, fps)
    for axes, model in plots.model_panels(figure, shown_models(document, list(curves))):
        axes.plot(seconds, captured, color="black", linewidth=0.8)
        axes.plot(seconds, curves[model.name], color=model.colour, linewidth=1.2)
    figure.supxlabel(f"clip {document['folds']['test']['clips'][0]}, s (black: captured)", fontsize="medium")
    figure.supylabel("first shape mode, mm", fontsize="medium")


def _first_mode_error(figure: Any, document: Document, captured: Any, fps: float) -> None:
    """The squared error of the first mode at each frame of that clip (Taylor 2017, supplement, figure 3)."""
    seconds, curves = _mode_curves(document, captured, fps)
    for axes, model in plots.model_panels(figure, shown_models(document, list(curves))):
        axes.fill_between(seconds, (np.array(curves[model.name]) - captured) ** 2, color=model.colour)
    if curves:
        figure.axes[0].set_ylim(bottom=0.0)
    figure.supxlabel(f"clip {document['folds']['test']['clips'][0]}, s", fontsize="medium")
    figure.supylabel("squared error, mm²", fontsize="medium")


def _mode_curves(document: Document, captured: Any, fps: float) -> tuple[Any, dict[str, Any]]:
    """Instants, and the first shape mode of that clip by model, where it has as many frames as captured."""
    found = {name: model["first_mode"] for name, model in document["models"].items()}
    curves = {name: curve for name, curve in found.items() if len(curve) == len(captured)}
    return (np.arange(len(captured)) + 0.5) / fps, curves


def _heat(figure: Any, document: Document, face: FaceModel) -> None:
    """Mean error of every landmark, on the mean face."""
    models = document["models"]
    largest = max(np.percentile(np.array(m["landmark_error"])[face.moving], 99) for m in models.values())
    points = face.mean[face.moving]
    for axes, model in plots.model_panels(figure, shown_models(document, list(models))):
        error = np.array(models[model.name]["landmark_error"])[face.moving]
        dots = axes.scatter(points[:, 0], points[:, 1], c=error, s=9, cmap="viridis_r", vmin=0, vmax=largest)
        for line in (OUTER_LIPS, INNER_LIPS):
            ring = face.mean[face.rows((*line, line[0]))]
            axes.plot(ring[:, 0], ring[:, 1], color="grey", linewidth=0.5)
        axes.set_aspect("equal")
        axes.set_axis_off()
    figure.colorbar(dots, ax=figure.axes, label="mean error of a landmark, mm", shrink=0.7)


def _cost(figure: Any, document: Document, variant: str) -> None:
    """Speed against error."""
    names = _scored(document, variant)
    models = document["models"]
    ends = [
        (models[n]["frames_per_s"], _value(document, n, variant, "test/all", "shape_mse")[0]) for n in names
    ]
    sizes = np.array([models[n]["bytes"] / 1e6 for n in names])
    heading = measure_heading("shape_mse")
    plots.draw_cost(figure, shown_models(document, names), np.array(ends, float), sizes, heading)


def _conditions(figure: Any, document: Document, variant: str) -> None:
    """Lip aperture r on the clean test clips and under each condition."""
    names = _scored(document, variant)
    places = ["test/all", *[f"with {name}/all" for name in document["conditions"]]]
    rows = [[model_rows(document, n, variant, where) for where in places] for n in names]
    values = [
        [measure_value("aperture_r", one["aperture_r"]) if one else np.nan for one in row] for row in rows
    ]
    columns = ["clean", *document["conditions"]]
    plots.draw_grid(figure, names, columns, np.array(values), measure_heading("aperture_r"), 1.0)


def _sweep(figure: Any, found: dict[str, Any]) -> None:
    """A setting against the error on held-out training clips."""
    ways = {"shape_mse": "all frames", "speech_shape_mse": "speech"}
    key = found["series"]
    panels: dict[str, dict[str, dict[str, float]]] = {}
    for way, heading in ways.items():
        if all(way in row for row in found["rows"]):
            panels[heading] = {}
            for row in found["rows"]:
                name = f"{key} {row[key]}" if key else ""
                panels[heading].setdefault(name, {})[str(row[found["x"]])] = row[way]
    label = SETTINGS.get(found["x"], found["x"])
    plots.draw_sweep(figure, found["label"], label, measure_heading("shape_mse"), panels)
