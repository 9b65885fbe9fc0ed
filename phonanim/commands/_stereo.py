"""`phonanim corpus reconstruct`: landmarks in millimetres from two or more calibrated views."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.commands._numbers import Number

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command()
@click.argument("views", nargs=-1, required=True, type=FILE)
@click.option(
    "--calibration",
    required=True,
    type=FILE,
    help="Table of known points: x, y, z in millimetres, and u1, v1, u2, v2 ... in pixels of each view.",
)
@click.option(
    "-o", "--output", required=True, type=click.Path(dir_okay=False, path_type=Path), help="Array (.npy)."
)
@click.option(
    "--largest",
    type=Number(0),
    default=5.0,
    help="Distance in pixels from a view beyond which a point is left out.",
)
@console_options
def reconstruct(
    views: tuple[Path, ...], calibration: Path, output: Path, largest: float, console: Console
) -> None:
    """Reconstruct landmarks in millimetres from two or more synchronous views.

    Each of VIEWS is an array (frames, points, 2) of pixels, NaN where nothing was seen. The cameras are found
    from the calibration by the direct linear transformation, and so are the points. OUTPUT is an array
    (frames, points, 3), NaN where fewer than two views saw a point.

    \b
    Example:
      phonanim corpus reconstruct front.npy side.npy --calibration cube.csv -o face.npy
    """
    import numpy as np

    from phonanim.core.files import atomic_path
    from phonanim.corpus.stereo import calibrate_cameras, drop_outliers, read_views, reconstruct

    if len(views) < 2:
        raise click.UsageError("give two VIEWS or more")
    cameras, fits = calibrate_cameras(calibration, len(views))
    pictures = read_views(views)
    found = reconstruct(cameras, pictures)
    kept = drop_outliers(found, largest)
    with atomic_path(output) as path, path.open("wb") as file:
        np.save(file, kept.points)
    facts = {"output": str(output), "frames": len(kept.points), "calibration_px": fits} | found.facts(kept)
    named = ", ".join(f"{path.name} {fit:.2f}" for path, fit in zip(views, fits, strict=True))
    console.print(f"calibration: {named} px")
    console.print(
        f"wrote {output}: {facts['points']} points, {facts['apart_px']:.2f} px from the views; "
        f"{facts['unseen']} unseen, {facts['left_out']} beyond {largest:g} px"
    )
    console.print_result(facts)
