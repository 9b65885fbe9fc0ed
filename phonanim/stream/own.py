"""Live motion of a model of controls, sensors or vertices: the rig that it moves, and its frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.own_motion import animate_controls, sensed_motion, unused_own_options
from phonanim.errors import OptionError
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig
from phonanim.regressors import Model
from phonanim.rig import Rig
from phonanim.rig.read import rig_names
from phonanim.speech.phones import PhoneTrack
from phonanim.targets.controls import Controls
from phonanim.targets.sensors import Sensors
from phonanim.targets.vertices import Vertices

Floats = NDArray[np.float32]
AXES = "xyz"


@dataclass(frozen=True)
class OwnMotion:
    """A model and the rig that its frames are of; only a rig that sensors move has a life of its own."""

    model: Model
    options: Options
    rig: Rig
    notes: tuple[str, ...] = ()
    face: NDArray[np.float64] | None = None  # at rest, of vertices

    @property
    def lives(self) -> bool:
        """Whether eyes, head and brows move beside the mouth."""
        return isinstance(self.model.target, Sensors)

    def move(self, rows: Floats, track: PhoneTrack, times: NDArray[np.float64]) -> Floats:
        """Controls at instants of a track, from rows of the model, (frames, size) -> (frames, controls)."""
        target = self.model.target
        if isinstance(target, Sensors):
            return sensed_motion(self.model, target, self.rig, rows, track, times, None, self.options).values
        if isinstance(target, Controls):
            return animate_controls(target.decode(rows), target, self.options).values
        return np.asarray(target.decode(rows, self.face).reshape(len(rows), -1), np.float32)


def own_motion(model: Model, options: Options) -> OwnMotion | None:
    """The motion of a model of controls, sensors or vertices; None for landmarks.

    Raises ModelError for a rig that no table leads to, OptionError for a way of retargeting.
    """
    target = model.target
    if isinstance(target, Sensors):
        return OwnMotion(model, options, load_cached_rig(options.rig))
    if isinstance(target, Controls):
        still = np.zeros((1, len(target.names)), np.float32)
        if target.least is not None:
            still = np.clip(still, target.least, target.most)
        first = animate_controls(still, target, options)
        rig = first.rig if first.rig in rig_names() else bare_rig(first.rig, first.channels, first.values[0])
        rig = load_cached_rig(rig) if isinstance(rig, str) else rig
        return OwnMotion(model, options, rig, unused_own_options(options))
    if isinstance(target, Vertices):
        rest = target.rest_in_style(model.style_name(options.model_style))
        names = tuple(f"v{vertex}{axis}" for vertex in range(len(rest)) for axis in AXES)
        rig = bare_rig(target.data, names, rest.ravel())
        return OwnMotion(model, options, rig, unused_own_options(options), rest)
    return None


def bare_rig(name: str, controls: tuple[str, ...], rest: NDArray[np.floating]) -> Rig:
    """A rig of which only the controls and their rest are known."""
    still = rest.astype(np.float64)
    unbounded = np.full(len(still), np.inf)
    return Rig(
        name=name,
        title=name,
        source="",
        controls=controls,
        minimum=-unbounded,
        maximum=unbounded,
        rest=still,
        mean=still,
        poses=np.zeros((0, len(still))),
    )


def check_places(model: Model, places: tuple[str, ...]) -> None:
    """Raise OptionError where vertices would go to a place that takes controls of a rig."""
    others = [place for place in places if place.partition("=")[0] != "stdout"]
    if isinstance(model.target, Vertices) and others:
        raise OptionError(
            f"--to {others[0]}: takes controls of a rig, and the model moves {len(model.target.own_rest)} "
            "vertices; use --to stdout"
        )
