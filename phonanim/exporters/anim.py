"""Maya animation file: a curve per channel for the weights of a blendShape node."""

from __future__ import annotations

import re
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.keys import Keys, reduce_channels
from phonanim.core.decode import DAMAGE, DecodeError, decode_rate, read_utf8
from phonanim.core.files import write_pieces
from phonanim.errors import OutputError
from phonanim.exporters._curves import estimate_rate, rig_of_channels, sample_tangents
from phonanim.exporters._take import build_take, check_times, take_grid

SUMMARY = "Maya .anim for a blendShape node; File > Import with the animImportExport plug-in"
UNITS = {24: "film", 25: "pal", 30: "ntsc", 48: "show", 50: "palf", 60: "ntscf"}  # frames per second
FALLBACK = 60  # times of other rates are fractions of these frames
EXACT = {"linear", "flat", "step"}  # kinds of tangents whose form the file tells
WHOLE = 1e-3  # frames; a key closer than this to a frame is on it
_UNIT = re.compile(r"^[ \t]*timeUnit (\S+?);", re.MULTILINE)
_CURVE = re.compile(r"^[ \t]*anim (\S+) [^;{\n]*;\s*animData \{[^{}]*keys \{([^{}]*)\}", re.MULTILINE)
HEADER = """animVersion 1.1;
mayaVersion 2022;
timeUnit {unit};
linearUnit cm;
angularUnit deg;
startTime {first:g};
endTime {last:g};
"""
CURVE = """anim {name} {name} {node} 0 0 {number};
animData {{
  input time;
  output unitless;
  weighted 0;
  preInfinity constant;
  postInfinity constant;
  keys {{
{keys}
  }}
}}
"""


def write(animation: Animation, path: Path, node: str = "blendShape1", keys: float | None = None) -> None:
    """Write curves with linear tangents for the weights of `node`, named like the channels.

    With `keys`, frames are left out if linear interpolation is within that error. Time zero is frame 0.
    Raises OutputError when the destination cannot be written.
    """
    rate = round(animation.fps) if abs(animation.fps - round(animation.fps)) < 1e-6 else FALLBACK
    rate = rate if rate in UNITS else FALLBACK
    frames = animation.times * rate
    header = HEADER.format(unit=UNITS[rate], first=frames[0], last=frames[-1])
    curves = enumerate(_keyed(animation, keys).items())
    write_pieces(path, chain([header], (_curve(node, frames, *curve) for curve in curves)))


def _curve(node: str, frames: NDArray[np.float64], number: int, curve: tuple[str, Keys]) -> str:
    name, found = curve
    pairs = zip(frames[found.frames].tolist(), found.values[:, 0].tolist(), strict=True)
    rows = "\n".join(f"    {time:.9g} {value:.7g} linear linear 1 1 0;" for time, value in pairs)
    return CURVE.format(name=name, node=node, number=number, keys=rows)


def read(path: Path) -> Animation:
    """Read the curves of weights, one of each attribute.

    Linear, stepped and flat tangents are as in Maya. Other kinds are read as splines through the keys, and a
    note says so: bake the curves for their exact form. Raises OutputError for any other file.
    """
    try:
        text = read_utf8(path)
        if not text.lstrip().startswith("animVersion"):
            raise DecodeError("it does not begin with animVersion")
        rate = _rate(text)
        curves = {name: _keys(rows) for name, rows in _CURVE.findall(text)}
        if not curves:
            raise DecodeError("it has no curves with keys; select the blendShape node, and export it again")
        for name, keys in curves.items():
            check_times(keys.times / rate, name)
        grid, fps = _grid(curves, rate, path)
        values = np.stack(
            [sample_tangents(grid, k.times / rate, k.values, *_slopes(k, rate)) for k in curves.values()],
            axis=1,
        )
        smooth = [name for name, keys in curves.items() if {*keys.before, *keys.after} - EXACT]
        about: dict[str, Any] = {"input": path.name}
        if smooth:
            more = f" and {len(smooth) - 1} more" if len(smooth) > 1 else ""
            what = "tangents are read as splines through their keys; bake the curves for their exact form"
            about["notes"] = [f"{smooth[0]}{more}: {what}"]
        start, names = float(grid[0]), list(curves)
        return build_take(values, names, fps, start, {"provenance": about}, path, rig_of_channels(names))
    except (OSError, *DAMAGE) as error:
        raise OutputError(f"{path}: is not a Maya animation file: {error}") from error


class _Curve(NamedTuple):
    """The keys of a curve: times in units of the file, values, and kinds of tangents, (k,) each."""

    times: NDArray[np.float64]
    values: NDArray[np.float64]
    before: list[str]
    after: list[str]


def _rate(text: str) -> float:
    """Time units per second."""
    unit = _UNIT.search(text)
    if unit is None:
        raise DecodeError("it has no timeUnit")
    if match := re.fullmatch(r"([\d.]+)fps", unit[1]):
        return decode_rate(float(match[1]), "timeUnit")
    rates = {"sec": 1.0, "millisec": 1000.0, "game": 15.0} | {name: float(n) for n, name in UNITS.items()}
    if unit[1] not in rates:
        raise DecodeError(
            f"its timeUnit is {unit[1]!r}; it may be {', '.join(rates)} or a rate such as 90fps"
        )
    return rates[unit[1]]


def _keys(rows: str) -> _Curve:
    found = [row.split() for row in rows.split(";") if row.strip()]
    numbers = np.array([row[:2] for row in found], np.float64)
    if not np.isfinite(numbers).all():
        raise DecodeError("a key is not a finite number")
    if not all(kind.isalpha() for row in found for kind in row[2:4]):
        raise DecodeError("a key has no kinds of tangents")
    return _Curve(numbers[:, 0], numbers[:, 1], [row[2] for row in found], [row[3] for row in found])


def _grid(curves: dict[str, _Curve], rate: float, path: Path) -> tuple[NDArray[np.float64], float]:
    """Instants of the frames and their rate; keys between frames tell a rate that Maya has no unit for."""
    times = np.unique(np.concatenate([keys.times for keys in curves.values()]).round(6))
    fps = rate
    if len(times) > 1 and (np.abs(times - times.round()) > WHOLE).any():
        steps = np.diff(times)
        fps = estimate_rate(np.array([0.0, steps[steps > WHOLE].min()]) / rate)
    return take_grid(times[0] / rate, times[-1] / rate, fps, len(curves), path), fps


def _slopes(keys: _Curve, rate: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values per second before and after each key, infinite where the curve steps, (k,) each."""
    times, values = keys.times / rate, keys.values
    rise = np.diff(values) / np.maximum(np.diff(times), 1e-9)
    sides = np.concatenate([[0.0], rise]), np.concatenate([rise, [0.0]])
    smooth = np.gradient(values, times) if len(times) > 1 and (np.diff(times) > 0).all() else 0.0 * values
    known = {"flat": 0.0 * values, "step": values + np.inf, "stepnext": values + np.inf}
    before, after = (
        np.array([({"linear": side} | known).get(kind, smooth)[n] for n, kind in enumerate(kinds)])
        for side, kinds in zip(sides, (keys.before, keys.after), strict=True)
    )
    return np.where(np.isinf(before), 0.0, before), after


def _keyed(animation: Animation, keys: float | None) -> dict[str, Keys]:
    if keys is not None:
        return reduce_channels(animation, keys)
    every = np.arange(len(animation.values))
    values = np.asarray(animation.values, np.float64)
    return {name: Keys(every, values[:, [i]], 0.0) for i, name in enumerate(animation.channels)}
