"""MetaHuman curves as a Curve Table of Unreal Engine: one row per curve.

Besides CTRL_expressions curves, a MetaHuman reads HeadYaw, HeadPitch and HeadRoll in degrees while
HeadControlSwitch is 1, as its Live Link sources send them.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE, read_utf8
from phonanim.core.files import atomic_path
from phonanim.errors import OutputError
from phonanim.exporters._take import build_take, check_times
from phonanim.rig.morphs import plain_name
from phonanim.rig.neck import TURNS, turns_of

SUMMARY = "MetaHuman CTRL_expressions curves, to import into Unreal as a linear Curve Table"
RIG = "metahuman"
PREFIX = "CTRL_expressions_"
SWITCH = "HeadControlSwitch"


def write(animation: Animation, path: Path) -> None:
    """Write the times in the first row and a curve in each further row.

    With turns of the head, the switch of its curves is on; without motion there it is off.
    Raises OutputError when the rig has no MetaHuman curve, or the destination cannot be written.
    """
    if not fits(animation.channels):
        raise OutputError(f"{path}: the rig {animation.rig} has no {PREFIX} curve; choose --rig metahuman")
    with atomic_path(path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["---", *(f"{time:.6f}" for time in animation.times)])
        for name, curve in zip(animation.channels, np.asarray(animation.values).T, strict=True):
            table.writerow([name, *(f"{value:.6f}" for value in curve.tolist())])
        if plain_name(TURNS[0]) in map(plain_name, animation.channels):
            turns = turns_of(animation.values, animation.channels) is not None
            table.writerow([SWITCH, *[f"{turns:.6f}"] * len(animation.times)])


def fits(channels: Sequence[str]) -> bool:
    """Whether a channel is a MetaHuman curve."""
    return any(name.startswith(PREFIX) for name in channels)


def read(path: Path) -> Animation:
    """Read a Curve Table with evenly spaced times. Raises OutputError for any other file."""
    try:
        head, *rows = csv.reader(io.StringIO(read_utf8(path).removeprefix("\ufeff"), newline=""))
        rows = [row for row in rows if row[:1] != [SWITCH]]
        times = np.array(head[1:], float)
        values = np.array([row[1:] for row in rows], np.float32).reshape(-1, len(times)).T
        check_times(times, "its first row")
        step = float(np.diff(times).mean())
        if not (np.isfinite(values).all() and step > 0 and np.ptp(np.diff(times)) < step / 2):
            raise ValueError("its times are not evenly spaced, or a value is not finite")
        fps, names = (len(times) - 1) / float(times[-1] - times[0]), [row[0] for row in rows]
        about = {"provenance": {"input": path.name}}
        return build_take(values, names, fps, float(times[0]), about, path, "metahuman")
    except (OSError, csv.Error, *DAMAGE) as error:
        raise OutputError(
            f"{path}: is not a Curve Table with a row of times and rows of values: {error}"
        ) from error
