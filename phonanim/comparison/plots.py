"""Drawing of plain numbers for the figures of a comparison: bars, grids, sweeps and small panels.

Each function fills a Matplotlib figure. Bars and errors begin at zero, categories are never joined by lines,
and colours stay apart for colour-blind readers (Okabe and Ito 2008).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
COLOURS = {"phones": "#0072B2", "audio": "#009E73", "both": "#CC79A7", "": "#999999"}
REFERENCE = "#D55E00"
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKS = ("o", "s", "^", "D", "v", "P", "X")
DRIVERS = {"phones": "phone-driven", "audio": "audio-driven", "both": "both", "": "still"}


@dataclass(frozen=True)
class Shown:
    """A model in a figure: name, input ("phones", "audio", "both"; "": none), whether it is the reference."""

    name: str
    driven_by: str
    is_reference: bool = False

    @property
    def colour(self) -> str:
        """The colour of its input, or that of the reference."""
        return REFERENCE if self.is_reference else COLOURS[self.driven_by]


def draw_bars(figure: Any, models: Sequence[Shown], panels: Mapping[str, Array]) -> None:
    """A panel for each measure: (models, 3) value and 95 % interval, as bars from zero."""
    figure.set_size_inches(9, 1.2 + 0.28 * len(models))
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (label, values) in zip(every, panels.items(), strict=True):
        reach = np.stack([values[:, 0] - values[:, 1], values[:, 2] - values[:, 0]])
        axes.barh(
            [model.name for model in models], values[:, 0], xerr=np.maximum(reach, 0), capsize=3,
            color=[model.colour for model in models],
        )  # fmt: skip
        axes.set_xlabel(f"{label} (bar: 95 % interval)" if reach.any() else label)
        axes.set_xlim(left=min(0.0, float(values.min())))
    every[0].set_ylabel("model")
    every[0].invert_yaxis()
    name_inputs(figure, models)


def name_inputs(figure: Any, models: Sequence[Shown]) -> None:
    """A legend of the colours, below the panels."""
    from matplotlib.patches import Patch

    names = {model.colour: DRIVERS[model.driven_by] for model in models if not model.is_reference}
    names |= {
        model.colour: f"{model.name} ({DRIVERS[model.driven_by]})" for model in models if model.is_reference
    }
    handles = [Patch(color=colour, label=name) for colour, name in names.items()]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize="small", frameon=False
    )


def draw_grid(
    figure: Any, rows: Sequence[str], columns: Sequence[str], values: Array, label: str, best: float
) -> None:
    """A table of numbers, (rows, columns), each cell the darker the nearer to `best` from 0; NaN is "–"."""
    figure.set_size_inches(2.6 + 0.72 * len(columns), 1.4 + 0.28 * len(rows))
    axes = figure.subplots()
    shades = axes.imshow(values, cmap="Blues", vmin=0, vmax=best, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        ink = "white" if value > 0.6 * best else "black"
        axes.text(
            column,
            row,
            f"{value:.2f}".replace("-0.00", "0.00").replace("nan", "–"),
            ha="center",
            va="center",
            color=ink,
            fontsize="small",
        )
    axes.set_xticks(range(len(columns)), columns, rotation=30, ha="right", fontsize="small")
    axes.set_yticks(range(len(rows)), rows, fontsize="small")
    axes.set(xlabel="condition", ylabel="model")
    figure.colorbar(shades, ax=axes, label=label, shrink=0.8)


def draw_cost(figure: Any, models: Sequence[Shown], ends: Array, sizes: Array, label: str) -> None:
    """Speed against error, (models, 2), and sizes in MB, (models,); the error from zero."""
    axes = figure.subplots()
    areas = 20 + sizes  # points²
    for model, (speed, error), area in zip(models, ends, areas, strict=True):
        axes.scatter(speed, error, s=area, color=model.colour)
    axes.set_xscale("log")
    axes.set_xlabel("speed of one thread, frames/s (area of a dot: size of the model)")
    axes.set_ylabel(label)
    axes.margins(0.08)
    axes.set_ylim(bottom=0.0)
    name_inputs(figure, models)
    place_names(axes, models, ends, np.sqrt(areas) / 2)


def place_names(axes: Any, models: Sequence[Shown], ends: Array, radii: Array) -> None:
    """Put names next to their dots of some radii in points, as close as possible without covering any."""
    from matplotlib.transforms import Bbox

    axes.figure.canvas.draw()  # positions are known only after drawing
    dots = axes.transData.transform(ends)
    reaches = radii * axes.figure.dpi / 72 + 2
    taken = [Bbox.from_bounds(x - r, y - r, 2 * r, 2 * r) for (x, y), r in zip(dots, reaches, strict=True)]
    for model, end, (x, y), reach in zip(models, ends, dots, reaches, strict=True):
        text = axes.annotate(
            model.name, tuple(end), (0, 0), textcoords="offset pixels", fontsize="small", color=model.colour
        )
        text.set_in_layout(False)
        at = text.get_window_extent()
        places = [
            Bbox.from_bounds(x + dx, y + dy, at.width, at.height)
            for dx, dy in label_offsets(at.width, at.height, reach)
        ]
        free = [box for box in places if not box.count_overlaps(taken) and is_inside(box, axes.bbox)]
        taken.append(free[0] if free else places[0])
        text.set_position((taken[-1].x0 - at.x0, taken[-1].y0 - at.y0))


def is_inside(box: Any, whole: Any) -> bool:
    """Whether a box is within another."""
    return bool(box.x0 > whole.x0 and box.x1 < whole.x1 and box.y0 > whole.y0 and box.y1 < whole.y1)


def label_offsets(width: float, height: float, radius: float) -> list[tuple[float, float]]:
    """Positions of a name relative to its dot, in pixels, the nearest first: right, left, above, below."""
    rings = [radius + 2.0 + 7.0 * ring for ring in range(8)]
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


def draw_sweep(
    figure: Any,
    title: str,
    x_label: str,
    y_label: str,
    panels: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> None:
    """Errors by setting from zero, {panel: {series: {setting: error}}}: lines for numbers, bars for names."""
    every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (heading, series) in zip(every, panels.items(), strict=True):
        settings = list(dict.fromkeys(x for found in series.values() for x in found))
        if all(_is_number(x) for x in settings):
            _lines(axes, series)
            axes.set_xticks([float(x) for x in settings], settings)
        else:
            _columns(axes, settings, series)
        axes.set_xlabel(x_label)
        if len(panels) > 1:
            axes.set_title(heading, fontsize="medium")
    every[0].set_ylim(bottom=0.0)  # common to all panels, so only once all are drawn
    every[0].set_ylabel(y_label)
    figure.suptitle(title, fontsize="medium")
    if list(panels[next(iter(panels))]) != [""]:
        handles, labels = every[0].get_legend_handles_labels()  # below, where no curve runs
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize="small", frameon=False)


def _is_number(text: str) -> bool:
    return text.replace(".", "", 1).isdigit()


def _lines(axes: Any, series: Mapping[str, Mapping[str, float]]) -> None:
    for number, (name, found) in enumerate(series.items()):
        style = {"color": SERIES[number % len(SERIES)], "marker": MARKS[number % len(MARKS)], "markersize": 5}
        axes.plot([float(x) for x in found], list(found.values()), label=name or None, linewidth=1.2, **style)


def _columns(axes: Any, settings: Sequence[str], series: Mapping[str, Mapping[str, float]]) -> None:
    width = 0.8 / len(series)
    for number, (name, found) in enumerate(series.items()):
        at = np.arange(len(settings)) + (number - (len(series) - 1) / 2) * width
        heights = [found.get(x, np.nan) for x in settings]
        bars = axes.bar(at, heights, width, color=SERIES[number % len(SERIES)], label=name or None)
        axes.bar_label(bars, fmt="%.3f", fontsize="small", padding=2)
    axes.set_xticks(range(len(settings)), settings)


def model_panels(figure: Any, models: Sequence[Shown], columns: int = 4) -> Iterable[tuple[Any, Shown]]:
    """A small panel for each model, in rows, with common axes; -> pairs of axes and model."""
    rows = -(-len(models) // columns)
    figure.set_size_inches(2.4 * columns, 0.9 + 1.6 * rows)
    grid = figure.subplots(rows, min(columns, len(models)), sharex=True, sharey=True, squeeze=False).ravel()
    for place in range(len(models), len(grid)):
        grid[place].set_visible(False)
        if place >= columns:  # nothing below shows the ticks of the panel above
            grid[place - columns].tick_params(labelbottom=True)
    for axes, model in zip(grid, models, strict=False):
        axes.set_title(model.name, fontsize="small", color=model.colour)
        yield axes, model
