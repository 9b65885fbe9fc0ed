"""The head on which a rig can be seen: its own, or the shipped one with visemes for shapes."""

from __future__ import annotations

from phonanim.rig.align import add_viseme_shapes
from phonanim.rig.character import load_character
from phonanim.rig.head import SHIPPED, Head, load_head
from phonanim.rig.landmarks import MeshLandmarks, read_landmarks, shipped_landmarks
from phonanim.rig.rig import Rig

MOST = 0.5  # of a rig's controls: a head that has more of them shows the rig


def own_head(rig: Rig) -> tuple[Head, MeshLandmarks] | None:
    """The head of a rig and its landmarks; none where nothing says what its mouths look like.

    Visemes and VRM's expressions are seen on the shipped head, as mixtures of its shapes.
    """
    if rig.head is not None and rig.landmarks is not None:
        shipped = rig.head.resolve() == SHIPPED.resolve()
        return (load_head() if shipped else load_character(rig.head)), read_landmarks(rig.landmarks)
    found = own_head(rig.through.rig) if rig.through is not None else None
    head, landmarks = found or (add_viseme_shapes(load_head()), shipped_landmarks())
    shown = len(set(rig.controls) & set(head.targets)) > MOST * len(rig.controls)
    return (head, landmarks) if shown else None
