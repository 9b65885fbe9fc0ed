"""Which way the axes of sensors point, by where lips and tongue are on average."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from phonanim.ema.articulation import DIRECTIONS, OUR_AXES, Articulation, standard_name

Array = NDArray[np.float64]
CLEAR = 1.3  # how much longer than the next an axis has to be, which a head bent by 37 degrees still is
SEEN = 20  # recordings by which axes are found
LEAST = 2.0  # mm between sensors that are apart
TONGUE = ("TD", "TB", "TT")  # from the back


def find_axes(recordings: Iterable[Articulation]) -> str | None:
    """The directions of x, y and z, as in "left,back,up"; None where the sensors do not show them.

    The upper lip is above the lower one, and lips are in front of the tongue. The third axis makes the three
    right-handed, as forward, left and up are.
    """
    places = mean_places(recordings)
    back = next((places[name] for name in TONGUE if name in places), None)
    if back is None or not {"UL", "LL"} <= set(places):
        return None
    lips = (places["UL"] + places["LL"]) / 2
    up, forward = _longest(places["UL"] - places["LL"]), _longest(lips - back)
    if up is None or forward is None or up[0] == forward[0]:
        return None
    rows = np.zeros((3, 3))  # forward, left and up in the axes of the files
    rows[2, up[0]], rows[0, forward[0]] = up[1], forward[1]
    rows[1] = np.cross(rows[2], rows[0])
    words = {(axis, sign): word for word, (axis, sign) in DIRECTIONS.items()}
    found = (int(np.abs(column).argmax()) for column in rows.T)
    return ",".join(words[axis, float(rows[axis, own])] for own, axis in enumerate(found))


def axes_or_ours(recordings: Iterable[Articulation]) -> tuple[str, str]:
    """The directions of x, y and z by the first recordings, and a line that says so.

    Where the sensors do not show them they are taken for forward, left and up.
    """
    found = find_axes(islice(recordings, SEEN))
    if found:
        return found, f"x, y and z are {found}, as lips and tongue lie; --axes gives others"
    return OUR_AXES, f"which way x, y and z point is not known, {OUR_AXES} is assumed; --axes gives others"


def mean_places(recordings: Iterable[Articulation]) -> Mapping[str, Array]:
    """The mean position of each sensor, (3,) mm, by its name in lexicon/sensors.csv."""
    found: dict[str, list[Array]] = {}
    for one in recordings:
        for name, track in zip(one.names, np.swapaxes(one.positions, 0, 1), strict=True):
            known = track[np.isfinite(track).all(axis=1)]
            if len(known):
                found.setdefault(standard_name(name), []).append(known.mean(axis=0))
    return {name: np.mean(places, axis=0) for name, places in found.items()}


def _longest(way: Array) -> tuple[int, float] | None:
    """The axis along which a way is clearly longest, and its sign."""
    order = np.argsort(-np.abs(way))
    longest, second = np.abs(way[order[:2]])
    if longest < LEAST or longest < CLEAR * second:
        return None
    return int(order[0]), float(np.sign(way[order[0]]))
