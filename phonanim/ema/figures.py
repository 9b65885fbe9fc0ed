"""The pictures of a report (extra `plots`)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.core.files import atomic_path
from phonanim.ema.articulation import sensor_label
from phonanim.ema.examples import MIDSAGITTAL, phone_stretches
from phonanim.ema.measures import VIEWS
from phonanim.ema.report import Report
from phonanim.errors import MissingExtraError

DOTS = 100  # per inch
MOST = 30  # bars in a chart
QUIVERS = 6  # pairs of phones with arrows
SPARE = 2.0  # mm around the arrows of a quiver
DRAWN = 4000  # points in a scatter plot, so that a long recording does not make a large picture
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")  # Okabe and Ito 2008
STROKES = ("-", "--")
AXES = ("forward, mm", "left, mm", "up, mm")


def check_plots() -> None:
    """Raise MissingExtraError where Matplotlib is not installed."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "pictures need Matplotlib: pip install 'phonanim[plots]', or leave them out with --no-plots"
        ) from error


def draw_report(report: Report, output: Path) -> list[str]:
    """Draw every picture that has data; -> their names. Raises MissingExtraError, OutputError."""
    check_plots()
    pictures: dict[str, Callable[[Any, Report], None]] = {"recording": _recording, "places": _places}
    if report.motions:
        pictures["quivers"] = _quivers
    if report.jaws:
        pictures["jaw"] = _jaw
    if any(_speed(report) in row.means for row in report.diphones):
        pictures["speeds"] = _speeds
    if any(np.isfinite(row.means.get("curvature", np.nan)) for row in report.diphones):
        pictures["shape"] = _shape
    for name, draw in pictures.items():
        _draw(draw, report, output / f"{name}.png")
    return [f"{name}.png" for name in pictures]


def _draw(draw: Callable[[Any, Report], None], report: Report, path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4), layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure, report)
    with atomic_path(path) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, metadata={"Software": None})


def _recording(figure: Any, report: Report) -> None:
    """Heights of the sensors over the first recording, with its phones."""
    figure.set_size_inches(10.5, 4.2)
    axes, articulation = figure.subplots(), report.first.articulation
    for place, name in enumerate(articulation.names):
        style = {"color": COLOURS[place % len(COLOURS)], "linestyle": STROKES[place // len(COLOURS) % 2]}
        height = articulation.positions[:, place, 2]
        axes.plot(articulation.times, height, linewidth=1.2, label=sensor_label(name), **style)
    spoken = phone_stretches(report.first.track)
    for phone in spoken:
        axes.axvline(phone.start, color="lightgrey", linewidth=0.5, zorder=0)
        middle = (phone.start + phone.end) / 2
        axes.text(middle, 1.01, phone.name, ha="center", fontsize=6, transform=axes.get_xaxis_transform())
    if spoken:
        axes.set_xlim(spoken[0].start - 0.1, spoken[-1].end + 0.1)
    axes.set(xlabel="time, s", ylabel="height of the sensor, mm")
    axes.set_title(report.first.name, fontsize="small", pad=14)
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))


def _places(figure: Any, report: Report) -> None:
    """The positions of every sensor, from the side: the lips on the left."""
    axes = figure.subplots()
    for name, places in report.places.items():
        cloud = places[:: -(-len(places) // DRAWN)]
        axes.plot(-cloud[:, 0], cloud[:, 2], ".", markersize=1.5, label=name)
    axes.set(xlabel="backward, mm", ylabel=AXES[2], aspect="equal")
    axes.legend(fontsize="small", markerscale=6, loc="center left", bbox_to_anchor=(1, 0.5))


def _quivers(figure: Any, report: Report) -> None:
    """How the sensors move in the most frequent pairs of phones, from the side (Medina 2023, figure 2.3).

    An arrow for each example, from the middle of the first phone to that of the second, and their mean.
    """
    frequent = sorted(report.motions, key=lambda name: (-len(report.motions[name]), name))[:QUIVERS]
    ends = np.concatenate([report.motions[name].reshape(-1, 3)[:, (0, 2)] for name in frequent]) * (-1, 1)
    low, high = np.nanmin(ends, axis=0) - SPARE, np.nanmax(ends, axis=0) + SPARE
    tall = high[1] - low[1] > high[0] - low[0]
    figure.set_size_inches(8, 5.2 if tall else 4.6)
    rows = 1 if tall else 2
    columns = -(-len(frequent) // rows)
    every = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    names = [sensor_label(name) for name in report.first.articulation.names]
    for axes, pair in zip(every, frequent, strict=False):
        motions = np.ma.masked_invalid(report.motions[pair][..., (0, 2)] * (-1, 1))
        for place, name in enumerate(names):
            colour, one = f"C{place % 10}", motions[:, :, place]
            for paths, width, shade in ((one, 0.01, 0.4), (one.mean(axis=0)[None], 0.025, 1.0)):
                axes.quiver(
                    *paths[:, 0].T, *(paths[:, 1] - paths[:, 0]).T,
                    angles="xy", scale_units="xy", scale=1, units="inches", width=width, color=colour,
                    alpha=shade,
                    label=name if shade == 1.0 else None,
                )  # fmt: skip
        axes.set_title(f"{pair}\n{len(motions)} examples", fontsize="medium")
        axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    for axes in every[len(frequent) :]:
        axes.set_visible(False)
    for axes in every[-columns:]:
        axes.set_xlabel("backward, mm", fontsize="small")
    figure.supylabel(AXES[2], fontsize="medium")
    figure.legend(
        *every[0].get_legend_handles_labels(), fontsize="small", ncols=3, loc="outside lower center"
    )


def _jaw(figure: Any, report: Report) -> None:
    """The envelope of the jaw in three views (Medina 2023, figure 2.4)."""
    for axes, (view, (across, along)) in zip(figure.subplots(1, len(VIEWS)), VIEWS.items(), strict=True):
        for name, jaw in report.jaws.items():
            cloud, outline = report.places[name], jaw.outlines[view]
            cloud = cloud[:: -(-len(cloud) // DRAWN)]
            (dots,) = axes.plot(cloud[:, across], cloud[:, along], ".", markersize=1.5, label=name)
            closed = np.concatenate([outline, outline[:1]])
            axes.plot(closed[:, 0], closed[:, 1], color=dots.get_color(), linewidth=0.8)
        axes.set(xlabel=AXES[across], ylabel=AXES[along], aspect="equal")
        axes.set_title(view, fontsize="medium")
    axes.legend(fontsize="small", markerscale=6)


def _speed(report: Report) -> str:
    """The measure of the first tongue sensor that exists, from the tip back."""
    present = [name for name in reversed(MIDSAGITTAL) if name in report.places]
    return f"speed_{present[0] if present else next(iter(report.places))}"


def _speeds(figure: Any, report: Report) -> None:
    """Mean peak speed of pairs of phones: the most frequent ones, sorted."""
    measure = _speed(report)
    known = [row for row in report.diphones if np.isfinite(row.means.get(measure, np.nan))]
    frequent = sorted(known, key=lambda row: (-row.examples, row.name))[:MOST]
    rows = sorted(frequent, key=lambda row: row.means[measure])
    axes = figure.subplots()
    bars = axes.bar([row.name for row in rows], [row.means[measure] for row in rows])
    axes.bar_label(bars, [row.examples for row in rows], fontsize=6)
    axes.set_ylabel(f"peak speed of {measure.removeprefix('speed_')}, mm/s")
    axes.set_xlabel("pair of phones (above: examples)")
    axes.tick_params(axis="x", rotation=90, labelsize=7)


def _shape(figure: Any, report: Report) -> None:
    """Width against curvature of the tongue, a dot for each pair of phones (Medina 2023, figure 2.2c)."""
    axes = figure.subplots()
    for row in report.diphones:
        at = row.means.get("width", np.nan), row.means.get("curvature", np.nan)
        axes.plot(*at, "o", markersize=3, color="tab:blue")
        axes.annotate(row.name, at, xytext=(3, 2), textcoords="offset points", fontsize=6)
    axes.axhline(0, color="grey", linewidth=0.5)
    axes.set(xlabel="width, mm", ylabel="curvature, 1/mm (edges down above 0)")
