"""Maya animation file: a curve per channel for the weights of a blendShape node."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.animation.keys import Keys, reduce_channels
from phonanim.core.files import write_text

SUMMARY = "Maya .anim for a blendShape node; File > Import with the animImportExport plug-in"
UNITS = {24: "film", 25: "pal", 30: "ntsc", 48: "show", 50: "palf", 60: "ntscf"}  # frames per second
FALLBACK = 60  # times of other rates are fractions of these frames
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
    lines = [HEADER.format(unit=UNITS[rate], first=frames[0], last=frames[-1])]
    for number, (name, found) in enumerate(_keyed(animation, keys).items()):
        pairs = zip(frames[found.frames].tolist(), found.values[:, 0].tolist(), strict=True)
        rows = "\n".join(f"    {time:.9g} {value:.7g} linear linear 1 1 0;" for time, value in pairs)
        lines.append(CURVE.format(name=name, node=node, number=number, keys=rows))
    write_text(path, "".join(lines))


def _keyed(animation: Animation, keys: float | None) -> dict[str, Keys]:
    if keys is not None:
        return reduce_channels(animation, keys)
    every = np.arange(len(animation.values))
    values = np.asarray(animation.values, np.float64)
    return {name: Keys(every, values[:, [i]], 0.0) for i, name in enumerate(animation.channels)}
