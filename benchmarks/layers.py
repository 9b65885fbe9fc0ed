"""What smoothing and overlays leave of the closures, measured on the lips of the shipped head.

    python benchmarks/layers.py ALIGNMENT ...

For each setting: the mean jerk of the curves, as a share of the plain line's; how many p b m f v there are;
and how much farther than in the plain line the lips part, at most: in those frames of these phones in which
they are closed, and anywhere in these phones.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.face.model import INNER_LIP_PAIRS
from phonanim.options import Options, Overlay
from phonanim.pipeline import AnimationResult, animate_detailed
from phonanim.rig.head import load_head
from phonanim.rig.landmark_rig import LandmarkRig, make_landmark_rig
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.speech.inventory import INVENTORY

Array = NDArray[np.float64]
SETTINGS = {
    "smooth 0.05 s": {"smooth": 0.05},
    "smooth 0.1 s": {"smooth": 0.1},
    "smooth 0.3 s": {"smooth": 0.3},
    "smile": {"overlays": (Overlay("smile"),)},
    "twice a smile, angry, blinks": {"overlays": (Overlay("smile", 2.0), Overlay("angry")), "blinks": 1},
}


def gaps(result: AnimationResult, landmark_rig: LandmarkRig) -> Array:
    """The widest of seven gaps between the lips of the head, (frames,) mm."""
    upper, lower = (result.face.rows(side) for side in zip(*INNER_LIP_PAIRS, strict=True))
    posed = landmark_rig.pose(result.animation.values)
    return np.asarray((posed[:, upper, 1] - posed[:, lower, 1]).max(axis=1))


def closed(path: Path) -> NDArray[np.bool_]:
    """The frames in which articulation closes the lips, (frames,)."""
    lips = animate_detailed(path, Options(rig="articulation", unknown="nearest", life=0)).animation
    return np.asarray(lips.channel("lip_gap") <= 0)


def jerk(result: AnimationResult) -> float:
    """Mean size of the third differences of all curves."""
    return float(np.abs(np.diff(result.animation.values, 3, axis=0)).mean())


def main() -> None:
    """Print a table row for each setting."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("alignments", type=Path, nargs="+", metavar="ALIGNMENT")
    paths = options.parse_args().alignments
    plain = [animate_detailed(path, Options(unknown="nearest", life=0)) for path in paths]
    landmark_rig = make_landmark_rig(load_head(), shipped_landmarks(), plain[0].face).take(
        plain[0].animation.channels
    )
    seconds = sum(float(one.animation.times[-1]) for one in plain)
    print(f"{len(paths)} lines, {seconds:.0f} s\n")
    print("| setting | jerk | p b m f v | parted at closures | parted in p b m f v |\n|---|---|---|---|---|")
    lips, shut = INVENTORY.codes(("p", "b", "m", "f", "v")), [closed(path) for path in paths]
    for name, setting in SETTINGS.items():
        after = [animate_detailed(path, Options(unknown="nearest", life=0, **setting)) for path in paths]
        more = [gaps(b, landmark_rig) - gaps(a, landmark_rig) for a, b in zip(plain, after, strict=True)]
        held = [np.isin(one.track.sample(one.animation.times), lips) for one in plain]
        firm = [m[h & s] for m, h, s in zip(more, held, shut, strict=True)]
        count = sum(int(np.isin(one.track.codes, lips).sum()) for one in plain)
        left = sum(map(jerk, after)) / sum(map(jerk, plain))
        worst = [
            max(float(np.abs(part).max(initial=0)) for part in parts)
            for parts in (firm, [m[h] for m, h in zip(more, held, strict=True)])
        ]
        print(f"| {name} | {left:.2f} | {count} | {worst[0]:.3f} mm | {worst[1]:.3f} mm |")


if __name__ == "__main__":
    main()
