"""Check a head's size and direction, measured from what its shapes move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.rig.head import Head
from phonanim.rig.names import known_controls

Array = NDArray[np.float64]

EYES = ("eyeblinkleft", "eyeblinkright", "eyeblink", "blinkleft", "blinkright", "blink")
MOUTHS = ("jawopen", "mouthopen", "visemeaa", "aa")
TALLEST, SMALLEST = 10.0, 0.05  # metres, of anybody who speaks
CENTIMETRE, MILLIMETRE = 0.01, 0.001
LEANING = 0.5  # of its height: a face this far in front of the head's middle faces that way


def orientation_warnings(head: Head) -> tuple[str, ...]:
    """Problems of a head's size and direction, each with its fix; empty where there are none.

    glTF uses metres, y up, and faces look along z. Directions are measured from shapes that move eyes and
    mouth, if shapes with these names exist.
    """
    return tuple(filter(None, (_size(head), _direction(head))))


def _size(head: Head) -> str:
    tall = float(np.ptp(head.vertices, axis=0).max())
    if SMALLEST <= tall <= TALLEST:
        return ""
    if tall < SMALLEST:
        return f"is {tall:.2g} m high, too small to be in metres; scale it up, and apply the scale"
    unit, factor = ("millimetres", MILLIMETRE) if tall > TALLEST / CENTIMETRE else ("centimetres", CENTIMETRE)
    return (
        f"is {tall:.0f} m high, so it is probably in {unit}, and glTF counts metres; "
        f"scale it by {factor:g}, and apply the scale"
    )


def _direction(head: Head) -> str:
    eyes, mouth = moved_centre(head, EYES), moved_centre(head, MOUTHS)
    if eyes is None or mouth is None:
        return ""
    up = eyes - mouth
    axis = int(np.abs(up).argmax())
    if axis != 1:
        return f"lies along {'xyz'[axis]}; turn it upright (y up), and apply the rotation"
    if up[1] < 0:
        return "stands upside down; turn it upright (y up), and apply the rotation"
    return _look(head, (eyes + mouth) / 2, float(up[1]))


def _look(head: Head, face: Array, tall: float) -> str:
    """Check that the face is on the right side: far in front of the middle of its head."""
    near = np.abs(head.vertices[:, 1] - face[1]) < tall
    middle = (head.vertices[near].min(axis=0) + head.vertices[near].max(axis=0)) / 2
    ahead = face - middle
    if ahead[2] < -LEANING * tall or abs(ahead[0]) > max(LEANING * tall, ahead[2]):
        return "does not look along z; turn its face to +z, and apply the rotation"
    return ""


def moved_centre(head: Head, names: tuple[str, ...]) -> Array | None:
    """The centre of what the shapes with these plain names move, (3,), or None without such shapes."""
    rows = [number for number, name in enumerate(head.targets) if set(known_controls(name)) & set(names)]
    weight = np.linalg.norm(head.deltas[rows], axis=2).sum(axis=0) if rows else np.zeros(1)
    return np.asarray(weight @ head.vertices / weight.sum()) if weight.sum() > 0 else None
