"""The motion of a line: from phones or sound to the controls of a rig, some frames at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.animation.style import scale_controls
from phonanim.articulation import Articulation
from phonanim.articulation.blend import blend_articulation, blend_channels
from phonanim.articulation.closures import set_closures
from phonanim.articulation.effort import effort_gains
from phonanim.articulation.from_audio import AudioArticulation
from phonanim.articulation.scaling import scale_articulation
from phonanim.errors import ModelError
from phonanim.face import contacts
from phonanim.media.audio import Sound
from phonanim.options import Options
from phonanim.rig import Rig
from phonanim.rig.retarget import retarget
from phonanim.speech.loudness import Loudness
from phonanim.speech.phones import PhoneTrack

BLOCK = 1 << 14  # frames that are moved at a time, so that memory grows by what is kept of each frame alone


class Motion(NamedTuple):
    """Modes (frames, modes), controls (frames, controls), and the articulation that made them, if any."""

    modes: NDArray[np.float32]
    values: NDArray[np.float32]
    articulation: Articulation | None


def predict_controls(
    track: PhoneTrack,
    model: regressors.Model,
    rig: Rig,
    options: Options,
    frames: int,
    start: float = 0.0,
    sound: Sound | None = None,
    loudness: Loudness | None = None,
) -> Motion:
    """The motion at start + n / fps seconds of a track, at the level of `loudness`, or at the usual level.

    A frame depends only on what is near it, so a stream can compute a few frames at a time.
    """
    predicted = model.predict(track, options.fps, frames, start, sound)
    modes = np.empty(predicted.shape, np.float32)
    values = np.empty((frames, len(rig.controls)), np.float32)
    mouths = []
    for begin in range(0, max(frames, 1), BLOCK):
        block = slice(begin, begin + BLOCK)
        times = start + np.arange(begin, min(begin + BLOCK, frames)) / options.fps
        part = _move_block(predicted[block], times, track, model, rig, options, sound, loudness)
        modes[block], values[block] = part.modes, part.values
        mouths += [] if part.articulation is None else [part.articulation.values]
    return Motion(modes, values, Articulation(np.concatenate(mouths)) if mouths else None)


def _move_block(
    modes: NDArray[np.float32],
    times: NDArray[np.float64],
    track: PhoneTrack,
    model: regressors.Model,
    rig: Rig,
    options: Options,
    sound: Sound | None,
    loudness: Loudness | None,
) -> Motion:
    """The motion of some frames, (frames, modes) at rising instants (frames,) seconds."""
    if options.contacts:
        modes = contacts.enforce_lip_contacts(modes, track, model.face, times)
    articulation = None
    if articulates(options, rig, track, sound):
        lips, closed = contacts.lip_part(model.face)
        mouth = blend_articulation(
            lips.instance(modes), lips, closed, track, times, options.contacts, options.quickness
        )
        articulation = spoken_articulation(mouth, options, track, times, loudness)
    elif sound is not None and articulates_from_audio(options, rig, model):
        articulation = spoken_articulation(
            mouth_from_audio(modes, model, sound, times), options, track, times, None
        )
    values = retarget(modes, model.face, rig, options.retarget, track, times, options.contacts, articulation)
    if articulation is None:
        values = scale_controls(values, rig, options.intensity, options.jaw, options.lips, options.gains)
    else:
        values = scale_controls(values, rig, float(options.intensity > 0), own=options.gains)
    return Motion(modes, values, articulation)


def articulates(options: Options, rig: Rig, track: PhoneTrack, sound: Sound | None) -> bool:
    """Whether articulation moves the rig. False where modes move it, and where sound has no phones."""
    known = sound is None or bool(track.codes.any())
    return options.retarget in ("auto", "articulation") and rig.speaks and known


def articulates_from_audio(options: Options, rig: Rig, model: regressors.Model) -> bool:
    """Whether articulation moves the rig without phones. Rigs of mouth shapes choose them by phones."""
    by_phones = rig.visemes or (rig.through and rig.through.rig.visemes)
    chosen = options.retarget in ("auto", "articulation") and rig.speaks
    return chosen and not by_phones and model.articulation is not None


def mouth_from_audio(
    modes: NDArray[np.floating], model: regressors.Model, sound: Sound, times: NDArray[np.float64]
) -> Articulation:
    """Articulation by sound alone, blended with the learned lips, (frames, modes) -> (frames, channels).

    Without phones no closure is enforced. Raises ModelError for a model that has not learned it.
    """
    if model.articulation is None:
        raise ModelError("the model has not learned articulation from sound; train it again")
    values, silent, rounded = AudioArticulation.from_tensors(model.articulation).at(sound, times)
    lips, closed = contacts.lip_part(model.face)
    return Articulation(blend_channels(values, lips.instance(modes), lips, closed, silent, rounded))


def spoken_articulation(
    mouth: Articulation,
    options: Options,
    track: PhoneTrack,
    times: NDArray[np.float64],
    loudness: Loudness | None,
) -> Articulation:
    """Articulation scaled by the options, stress, rate and loudness."""
    louder = None if loudness is None else options.loudness * loudness.at(times)
    gains = effort_gains(track, times, options.reduction, options.hold, louder)
    rounding = options.rounding * track.rounding
    mouth = scale_articulation(mouth, options.intensity, options.jaw, options.lips, gains, rounding)
    return set_closures(mouth, options.closures, times)
