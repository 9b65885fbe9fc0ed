"""Draw the losses of a training (extra `plots`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DecodeError
from phonanim.core.files import atomic_path
from phonanim.core.tables import parse_cell, read_rows
from phonanim.errors import MissingExtraError, ModelError
from phonanim.regressors import regressor_class

CURVE = "loss.csv"  # columns epoch, training_loss, validation_mm2
DOTS = 110  # per inch
LARGEST = 1e30  # of a loss


def check_drawable(kind: str, config: Path) -> None:
    """Raise MissingExtraError without Matplotlib, and ModelError for a kind that saves no losses."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "the picture needs Matplotlib: pip install 'phonanim[plots]', or leave out --plot"
        ) from error
    if not getattr(regressor_class(kind), "resumable", False):
        raise ModelError(f"{config}: a training of {kind!r} saves no losses to draw; leave out --plot")


def draw_losses(folder: Path) -> list[Path]:
    """Draw every loss.csv of a model folder as a loss.png next to it; -> the pictures."""
    curves = sorted(folder.rglob(CURVE))
    for curve in curves:
        draw_curve(curve, curve.with_suffix(".png"))
    return [curve.with_suffix(".png") for curve in curves]


def read_losses(curve: Path) -> NDArray[np.float64]:
    """Epochs, losses and validation errors of a loss.csv, (3, epochs). Raises ModelError."""
    try:
        rows = read_rows(curve)[1:]
        values = np.array([[parse_cell(cell, "a loss", high=LARGEST) for cell in row] for row in rows])
        if values.shape[1:] != (3,):
            raise DecodeError("its rows are not an epoch, a loss and an error")
    except (OSError, ValueError) as error:
        raise ModelError(f"{curve}: cannot be drawn: {error}; delete it, or train again") from error
    return values.T


def draw_curve(curve: Path, picture: Path) -> None:
    """Loss and validation error of each epoch; a line marks the epoch whose weights were kept."""
    from matplotlib.figure import Figure

    epochs, losses, errors = read_losses(curve)
    figure = Figure(figsize=(8, 3), layout="constrained")
    panels = {"training loss": losses, "validation error, mm²": errors}
    for axes, (title, values) in zip(figure.subplots(1, 2), panels.items(), strict=True):
        axes.plot(epochs, values, marker=".")
        axes.axvline(epochs[errors.argmin()], color="0.6", linewidth=1, linestyle="--")
        axes.set(xlabel="epoch (dashed: the weights that were kept)", ylabel=title)
        axes.set_ylim(bottom=min(0.0, float(np.nanmin(values))))
    with atomic_path(picture) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, metadata={"Software": None})
