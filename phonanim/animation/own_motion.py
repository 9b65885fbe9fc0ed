"""Motion of a model that moves what its data set has: controls of that rig, not those of any rig."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.motion import Motion, spoken_articulation
from phonanim.animation.other_rig import move_to_rig
from phonanim.animation.style import scale_controls
from phonanim.articulation import CHANNELS, Articulation, articulate
from phonanim.articulation.blend import CLEAR
from phonanim.articulation.closures import enforce_contacts
from phonanim.articulation.from_audio import AudioArticulation
from phonanim.articulation.table import read_targets
from phonanim.errors import ModelError, OptionError
from phonanim.media.audio import Sound
from phonanim.options import DEFAULTS, Options
from phonanim.regressors import Model
from phonanim.rig import Rig, load_rig
from phonanim.rig.read import rig_names
from phonanim.rig.retarget import pronounce_on
from phonanim.speech.gestures import GESTURES
from phonanim.speech.phones import PhoneTrack
from phonanim.targets.controls import Controls
from phonanim.targets.sensors import Sensors

Array = NDArray[np.float64]
SILENCE = GESTURES.names.index("sil")

WITHOUT = (
    *("intensity", "jaw", "lips", "rounding", "quickness", "reduction", "hold", "loudness", "gains"),
    *("smooth", "overlays", "life", "emotions", "blinks", "look_at"),
)
"""Options that change the motion of the reference face, and have no effect on learned controls."""
FEWEST = 0.6  # share of a rig's controls: fewer names, although all are of the rig, are not taken for it


def animate_controls(
    values: NDArray[np.floating], target: Controls, options: Options, **known: Any
) -> Animation:
    """Curves of a data set's rig, (frames, controls), on the rig of `options` where a table leads there.

    Controls with the names of a shipped rig are of that rig; others keep their names. `known` are further
    fields of the animation. Raises ModelError for an option `rig` that no table leads to.
    """
    rig = rig_of_names(target.names) or target.data
    curves = Animation(np.asarray(values, np.float32), target.names, options.fps, rig, **known)
    if options.rig in (rig, DEFAULTS.rig) and rig not in rig_names():
        return curves
    if options.rig == rig:
        return on_whole_rig(curves, rig)
    moved = move_to_rig(on_whole_rig(curves, rig) if rig in rig_names() else curves, options.rig)
    if moved is None:
        raise ModelError(
            f"the model moves {len(target.names)} controls of {rig}, and no table leads from them to the rig "
            f"{options.rig}; write them as they are (.npz, .json, .tsv), without --rig"
        )
    animation, notes = moved
    provenance = {**animation.provenance, "notes": [*animation.provenance.get("notes", ()), *notes]}
    return Animation(**{**vars(animation), "provenance": provenance})


def rig_of_names(names: tuple[str, ...]) -> str:
    """The shipped rig that has all of these names, which are most of its controls; "" where there is none."""
    for name in rig_names():
        controls = load_rig(name).controls
        if set(names) <= set(controls) and len(names) >= FEWEST * len(controls):
            return name
    return ""


def on_whole_rig(animation: Animation, name: str) -> Animation:
    """The animation with all controls of a rig, in its order; those that it lacks are at rest."""
    rig = load_rig(name)
    values = np.tile(rig.rest.astype(np.float32), (len(animation.values), 1))
    for column, control in enumerate(rig.controls):
        if control in animation.channels:
            values[:, column] = animation.channel(control)
    return Animation(**{**vars(animation), "values": values, "channels": rig.controls, "rig": rig.name})


def sensed_articulation(
    model: Model,
    target: Sensors,
    rows: NDArray[np.floating],
    track: PhoneTrack,
    times: Array,
    sound: Sound | None,
    contacts: bool = True,
) -> Articulation:
    """Articulation of predicted sensors, (frames, size) -> (frames, channels) mm.

    Channels that the sensors do not show are those of the phones, else those that the model predicts from
    sound, else those of a mouth at rest. Contacts of lips and teeth are enforced where there are phones.
    """
    spoken = bool(track.codes.any())
    if spoken:
        values = articulate(track, times).values.copy()
    elif sound is not None and model.articulation is not None:
        values = AudioArticulation.from_tensors(model.articulation).at(sound, times)[0]
    else:
        values = np.tile(read_targets().target[SILENCE], (len(times), 1))
    gap, teeth = CHANNELS.index("lip_gap"), CHANNELS.index("lower_lip_to_teeth")
    before = values[:, gap].copy()
    for name, curve in target.channels(target.decode(rows)).items():
        values[:, CHANNELS.index(name)] = curve
    values[:, CHANNELS.index("jaw")] = np.maximum(values[:, CHANNELS.index("jaw")], 0)
    # The lower lip follows the gap, but does not reach the teeth where nothing asks for it.
    followed = values[:, teeth] + values[:, gap] - before
    values[:, teeth] = np.maximum(followed, np.minimum(values[:, teeth], CLEAR))
    if contacts and spoken:
        enforce_contacts(values, track, times)
    return Articulation(values)


def sensed_motion(
    model: Model,
    target: Sensors,
    rig: Rig,
    rows: NDArray[np.float32],
    track: PhoneTrack,
    times: Array,
    sound: Sound | None,
    options: Options,
) -> Motion:
    """The motion of a rig by predicted sensors, (frames, size) -> (frames, controls).

    Raises RigError for a rig without a mouth.
    """
    mouth = sensed_articulation(model, target, rows, track, times, sound, options.contacts)
    mouth = spoken_articulation(mouth, options, track, times, None)
    values = pronounce_on(mouth, rig, track, times)
    return Motion(rows, scale_controls(values, rig, float(options.intensity > 0), own=options.gains), mouth)


def own_rig_note(target: Controls, options: Options) -> tuple[str, ...]:
    """A note that the shipped head does not show controls that keep the data set's own names, or none."""
    if rig_of_names(target.names) or options.rig != DEFAULTS.rig:
        return ()
    return (
        f"the controls are those of {target.data}, which the shipped head does not have: a GLB, a page or a "
        "sheet shows them on a --character with blendshapes of these names",
    )


def unused_own_options(options: Options) -> tuple[str, ...]:
    """A note on options that do not change learned controls, or none.

    Raises OptionError for a way of retargeting, which needs landmarks.
    """
    if options.retarget != DEFAULTS.retarget:
        raise OptionError("--retarget maps landmarks to a rig, and this model moves none; leave it out")
    given = [name for name in WITHOUT if getattr(options, name) != getattr(DEFAULTS, name)]
    if not given:
        return ()
    return (f"the model moves controls of its data set, so {', '.join(given)} did nothing",)
