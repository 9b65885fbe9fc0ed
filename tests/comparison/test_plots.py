"""The figures of a comparison: bars from zero, no lines through categories, and names that can be read."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phonanim.comparison import plots
from phonanim.comparison.figures import draw_file
from phonanim.comparison.plots import Shown
from phonanim.core.decode import read_toml

pytest.importorskip("matplotlib")
MODELS = [Shown("ours", "phones", True), Shown("second", "phones"), Shown("third", "audio")]


@pytest.fixture
def figure() -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    made = Figure(figsize=(8, 4.5), layout="constrained")
    FigureCanvasAgg(made)
    return made


def test_bars_begin_at_zero_with_a_name_and_the_colour_of_the_input(figure: Any) -> None:
    values = np.array([[0.8, 0.7, 0.9], [0.85, 0.8, 0.9], [0.9, 0.88, 0.93]])
    plots.draw_bars(figure, MODELS, {"aperture r": values})
    (axes,) = figure.axes
    assert axes.get_xlim()[0] == 0.0
    assert [label.get_text() for label in axes.get_yticklabels()] == ["ours", "second", "third"]
    assert len({bar.get_facecolor() for bar in axes.patches}) == 3
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["phone-driven", "audio-driven", "ours (phone-driven)"]


def test_settings_with_names_are_bars_and_numbers_are_lines_from_zero(figure: Any) -> None:
    plots.draw_sweep(figure, "a", "features", "error", {"all frames": {"": {"raw": 0.5, "all": 0.4}}})
    (axes,) = figure.axes
    assert not axes.lines
    assert len(axes.patches) == 2
    figure.clear()
    series = {"width 1": {"1": 0.9, "21": 0.5}, "width 3": {"1": 0.8, "21": 0.4}}
    higher = {"width 1": {"1": 1.9, "21": 0.5}}
    plots.draw_sweep(figure, "a", "reach", "error", {"all frames": series, "speech": higher})
    first = figure.axes[0]
    np.testing.assert_array_equal(first.lines[0].get_xdata(), [1, 21])
    for axes in figure.axes:
        low, high = axes.get_ylim()
        assert low == 0.0
        assert high > 1.9
    assert first.lines[0].get_color() != first.lines[1].get_color()
    assert first.lines[0].get_marker() != first.lines[1].get_marker()


def test_a_grid_has_a_number_in_each_cell(figure: Any) -> None:
    plots.draw_grid(
        figure, ["ours", "second"], ["clean", "noise"], np.array([[0.9, -0.001], [0.5, np.nan]]), "r", 1.0
    )
    axes = figure.axes[0]
    assert [text.get_text() for text in axes.texts] == ["0.90", "0.00", "0.50", "–"]
    assert axes.get_ylabel() == "model"
    assert not axes.lines


def test_names_beside_their_dots_cover_none(figure: Any) -> None:
    rng = np.random.default_rng(0)
    ends = rng.normal(0, 1, (12, 2)) ** 3
    models = [Shown(f"model number {n}", "both") for n in range(12)]
    axes = figure.subplots()
    for end in ends:
        axes.scatter(*end)
    plots.place_names(axes, models, ends, np.full(12, 3.0))
    boxes = [text.get_window_extent() for text in axes.texts]
    assert all(box.count_overlaps(boxes) == 1 for box in boxes)  # with itself
    assert all(plots.is_inside(box, axes.bbox) for box in boxes)


def test_the_committed_tables_are_enough_to_draw_the_benchmark_again(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = importlib.util.spec_from_file_location("plot_benchmark", root / "scripts/plot_benchmark.py")
    assert spec
    assert spec.loader
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    (tmp_path / "benchmark.json").write_bytes((root / "docs/benchmark/benchmark.json").read_bytes())
    monkeypatch.setattr("sys.argv", ["plot_benchmark", str(tmp_path)])
    script.main()
    drawn = sorted(path.name for path in tmp_path.glob("*.png"))
    assert drawn == [
        *("bars.png", "conditions.png", "cost.png"),
        *("sweep_amount.png", "sweep_features.png", "sweep_window.png"),
    ]


def test_a_figure_is_written_at_the_size_at_which_names_were_placed(tmp_path: Path) -> None:
    seen = []
    draw_file(lambda figure: seen.append(figure.dpi), tmp_path / "a.png")
    assert seen == [110]


def test_the_notes_of_the_plan_stand_on_the_published_pages(root: Path) -> None:
    notes = read_toml(root / "benchmarks/compare.toml")["notes"]
    pages = [root / "docs/benchmark.md", *(root / "docs/benchmark").glob("*.md")]
    published = "\n".join(path.read_text("utf-8") for path in pages).replace("](../", "](")
    assert [name for name, note in notes.items() if note.strip() not in published] == []
