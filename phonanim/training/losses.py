"""Draw the losses of a training (extra `plots`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.core.files import atomic_path
from phonanim.errors import MissingExtraError, ModelError
from phonanim.regressors import regressor_class

CURVE = "loss.csv"  # columns epoch, training_loss, validation_mm2
DOTS = 110  # per inch


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


def draw_curve(curve: Path, picture: Path) -> None:
    """Loss and validation error of each epoch; a line marks the epoch whose weights were kept."""
    from matplotlib.figure import Figure

    epochs, losses, errors = np.loadtxt(curve, delimiter=",", skiprows=1, ndmin=2).T
    figure = Figure(figsize=(8, 3), layout="constrained")
    panels = {"training loss": losses, "validation error, mm²": errors}
    for axes, (title, values) in zip(figure.subplots(1, 2), panels.items(), strict=True):
        axes.plot(epochs, values, marker=".")
        axes.axvline(epochs[errors.argmin()], color="0.6", linewidth=1, linestyle="--")
        axes.set(xlabel="epoch (dashed: the weights that were kept)", ylabel=title)
        axes.set_ylim(bottom=min(0.0, float(np.nanmin(values))))
    with atomic_path(picture) as unfinished:
        figure.savefig(unfinished, dpi=DOTS, metadata={"Software": None})
