"""The whole pipeline: from an alignment to an animation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.animation.animation import Animation
from phonanim.animation.corrections import Corrections, corrected_options, timed_options
from phonanim.animation.motion import (
    BLOCK,
    Motion,
    articulates,
    predict_controls,
)
from phonanim.animation.overlay import apply_overlays
from phonanim.animation.own_motion import (
    animate_controls,
    own_rig_note,
    sensed_motion,
    unused_own_options,
)
from phonanim.animation.provenance import take_provenance
from phonanim.animation.rates import check_rate, frame_count
from phonanim.animation.smooth import closure_mask, smooth_controls
from phonanim.animation.style import is_stepped_rig, unused_option_warnings
from phonanim.articulation.styles import DIALS, check_dial, choose_style, read_styles
from phonanim.core.catalog import find_model
from phonanim.errors import ModelError, OptionError
from phonanim.exporters import load
from phonanim.face.model import FaceModel
from phonanim.inputs.prosody import add_prosody
from phonanim.inputs.speech_input import SpeechInput, read_speech_input
from phonanim.life import Life, add_life, idle_life, life_of, mouth_freedom
from phonanim.media.audio import find_audio
from phonanim.options import DEFAULTS, SAMPLED, Options, make_options
from phonanim.rig import Rig, load_rig
from phonanim.rig.reference import face_notes
from phonanim.speech.intervals import Interval
from phonanim.speech.language import ReadingLanguage
from phonanim.speech.phones import PhoneTrack
from phonanim.targets.controls import Controls
from phonanim.targets.sensors import Sensors

USUAL_CONTROLS = 100  # of a rig: ARKit has 55, MetaHuman 87
UNCORRECTED = Corrections()

PRECOMPUTED = "precomputed"  # the encoder that reads the features of another program


@dataclass(frozen=True, slots=True)
class AnimationResult:
    """An animation with its intermediate results: the phones, and the face's modes (frames, modes).

    A model of other motion than landmarks has no face and no modes. `language` is the language that the
    labels were read as, None for a recording; `read` are the phones before they were corrected.
    """

    animation: Animation
    track: PhoneTrack
    notes: tuple[str, ...]
    modes: NDArray[np.float32] | None
    face: FaceModel | None
    language: ReadingLanguage | None = None
    read: tuple[Interval, ...] = ()


def animate(
    path: str | Path, options: Options | None = None, *, audio: str | Path | None = None, **settings: Any
) -> Animation:
    """Read an alignment and move a rig.

    The frames are at n / fps seconds, from 0 to the end of the alignment. `provenance["notes"]` of the result
    lists the labels that were replaced (option `unknown`).

    Args:
        path: An alignment, or a recording when the model is audio-driven.
        options: How to animate; the defaults of `Options` when it is None.
        audio: The recording; the one beside the alignment by default, with the same stem.
        settings: Single options by name, such as `rig="arkit"` or `fps=30`; they override `options`.
            `style` sets the options of a style, such as "clear", or is a style that the model has learned, by
            its name ("learned:clear" where a preset has that name, too) or its number.

    Raises:
        PhonanimError: The error of the step that fails: OptionError for an unknown option, AlignmentError
            for a file that cannot be read, LabelError for a label that the language does not have.

    Examples:
        >>> import phonanim
        >>> phonanim.animate("line.TextGrid", rig="arkit", fps=30).save("line.csv")
    """
    if "style" in settings:
        model = str(settings.get("model", (options or DEFAULTS).model))
        chosen = choose_style(str(settings.pop("style")), model, read_styles())
        learned = {} if chosen.number is None else {"model_style": chosen.number}
        settings = {**chosen.dials, **learned, **settings}
    options = make_options(options, settings)
    for dial in DIALS:
        check_dial(dial, getattr(options, dial))
    check_rate(options.fps, f"{options.fps:g}")
    path = Path(path)
    return animate_detailed(path, options, Path(audio) if audio else find_audio(path)).animation


def animate_detailed(
    path: Path,
    options: Options = DEFAULTS,
    audio: Path | None = None,
    corrections: Corrections = UNCORRECTED,
) -> AnimationResult:
    """The same as `animate`, with intermediate results, and the recording only if it is given.

    The line is read and moved with the phones and the settings of `corrections`; their curves are left to
    `phonanim.correcting`.
    """
    options = corrected_options(options, corrections)
    model, rig = model_with_settings(options), load_cached_rig(options.rig)
    line = read_speech_input(path, options, audio, model.input_modality, corrections.phones, model.recognizer)
    options = timed_options(options, corrections, line.alignment.intervals)
    frames = frame_count(line.track.duration, options.fps)
    _check_length(path, frames, rig, options)
    if not isinstance(model.target, FaceModel):
        animation = _animate_own(path, options, line, model)
        return AnimationResult(animation, line.track, line.notes, None, None, line.language, line.read)
    life = life_of(options, path.stem)
    follows = options.loudness > 0 and articulates(options, rig, line.track, line.sound)
    line = add_prosody(line, model.regressor, options, loudness=follows, prosody=life.moves(rig))
    motion = predict_controls(
        line.track, model, rig, options, frames, sound=line.sound, loudness=line.loudness
    )
    values, laid = _add_layers(motion, line, model.face, rig, options, life)
    remarks = (*unused_option_warnings(options, rig), *idle_life(options, rig), *laid, *_whispered(line))
    if options.closures and (motion.articulation is None or is_stepped_rig(rig)):
        remarks += (f"closures are held and released by articulation, which does not move {rig.name} here",)
    if motion.articulation is None:
        remarks += face_notes(model.face, rig.through.rig.face if rig.through else rig.face)
    animation = Animation(
        values=values,
        channels=rig.controls,
        fps=options.fps,
        rig=rig.name,
        phones=line.alignment.intervals,
        words=line.alignment.words,
        audio=line.audio,
        provenance=take_provenance(path, options, (*line.notes, *remarks), line),
        articulation=None if motion.articulation is None else motion.articulation.values.astype(np.float32),
    )
    return AnimationResult(
        animation, line.track, line.notes, motion.modes, model.face, line.language, line.read
    )


def _check_length(path: Path, frames: int, rig: Rig, options: Options) -> None:
    """Raise OptionError for a line of more values than are asked for, before any of them is made."""
    wide = max(len(rig.controls) / USUAL_CONTROLS, 1.0)
    if frames * wide > options.most_frames:
        raise OptionError(
            f"{path}: has {frames} frames at {options.fps:g} fps, over {int(options.most_frames / wide)}; "
            f"lower the rate, cut the line, or allow them: --most-frames {math.ceil(frames * wide)} "
            "(most_frames in Python)"
        )


def _animate_own(path: Path, options: Options, line: SpeechInput, model: regressors.Model) -> Animation:
    """The motion of a model of controls or sensors. Raises ModelError for vertices, which are no curves."""
    if isinstance(model.target, Sensors):
        return _animate_sensors(path, options, line, model, model.target)
    if isinstance(model.target, Controls):
        return _animate_controls(path, options, line, model, model.target)
    raise ModelError(f"{options.model}: moves {model.target.kind}, which are no curves of a rig")


def _animate_controls(
    path: Path, options: Options, line: SpeechInput, model: regressors.Model, target: Controls
) -> Animation:
    """Controls in the rig of their data set, or in one that a table leads to."""
    frames = frame_count(line.track.duration, options.fps)
    values = target.decode(model.predict(line.track, options.fps, frames, sound=line.sound))
    notes = (*line.notes, *unused_own_options(options), *own_rig_note(target, options))
    provenance = take_provenance(path, options, notes, line)
    return animate_controls(values, target, options, **_spoken_parts(line), provenance=provenance)


def _animate_sensors(
    path: Path, options: Options, line: SpeechInput, model: regressors.Model, target: Sensors
) -> Animation:
    """A rig moved by the articulation of predicted sensors. Raises RigError for one without a mouth."""
    rig, life = load_cached_rig(options.rig), life_of(options, path.stem)
    line = add_prosody(line, model.regressor, options, loudness=False, prosody=life.moves(rig))
    times = np.arange(frame_count(line.track.duration, options.fps)) / options.fps
    rows = model.predict(line.track, options.fps, len(times), sound=line.sound)
    motion = sensed_motion(model, target, rig, rows, line.track, times, line.sound, options)
    assert motion.articulation is not None
    values, laid = _add_layers(motion, line, None, rig, options, life)
    notes = (*line.notes, *unused_option_warnings(options, rig), *idle_life(options, rig), *laid)
    return Animation(
        values=values,
        channels=rig.controls,
        fps=options.fps,
        rig=rig.name,
        **_spoken_parts(line),
        provenance=take_provenance(path, options, notes, line),
        articulation=motion.articulation.values.astype(np.float32),
    )


def _spoken_parts(line: SpeechInput) -> dict[str, Any]:
    """The fields of an animation that tell what was said."""
    return {"phones": line.alignment.intervals, "words": line.alignment.words, "audio": line.audio}


def _add_layers(
    motion: Motion, line: SpeechInput, face: FaceModel | None, rig: Rig, options: Options, life: Life
) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Controls with smoothing, overlays and life, (frames, controls), and notes on the overlays."""
    values, times = motion.values, np.arange(len(motion.modes)) / options.fps
    if options.smooth and face is not None and not is_stepped_rig(rig):
        closed = closure_mask(motion.modes, line.track, face, times, motion.articulation)
        values = smooth_controls(values, options.smooth, options.fps, closed)
    values, notes = apply_overlays(values, rig, options.overlays, line.track, times, load)
    if line.prosody is not None:
        for begin in range(0, len(values), BLOCK):
            block = slice(begin, begin + BLOCK)
            free = mouth_freedom(line.prosody, line.track, times[block])
            values[block] = add_life(values[block], rig, life, line.prosody, times[block], free)
    return values, notes


def load_model(name: str | Path) -> regressors.Model:
    """Load a model by its name in `phonanim models`, or by the path of its folder. It is read once.

    Raises:
        ModelError: There is no such model, or its folder is damaged.

    Examples:
        >>> import phonanim
        >>> phonanim.load_model("default").card["fps"]
        25.0
    """
    return load_cached_model(str(name))


def model_with_settings(options: Options) -> regressors.Model:
    """The model of the options with their seed, steps and guidance, if it samples, and their style.

    Raises OptionError when another model is given such a setting, or features that it does not read, and
    ModelError when it does not take the value.
    """
    model = load_model(options.model)
    if options.features and getattr(model.regressor.config, "encoder", "") != PRECOMPUTED:
        raise OptionError(f"the model {options.model} reads no precomputed features: leave out --features")
    values = {name.removeprefix("model_"): getattr(options, name) for name in SAMPLED}
    given = {name: value for name, value in values.items() if value is not None}
    if not given:
        return model
    config, change = model.regressor.config, getattr(model.regressor, "with_settings", None)
    for name in given:
        takes = getattr(config, "styles", 1) > 1 if name == "style" else samples(model.regressor)
        if change is None or not takes:
            lacks = "has no styles" if name == "style" else "does not sample"
            raise OptionError(f"the model {options.model} {lacks}: leave out --{name}")
    return replace(model, regressor=change(**given)) if change else model


def samples(regressor: Any) -> bool:
    """Whether a model draws each take from a seed; the ablation of FaceDiffuser has one, and does not."""
    return hasattr(regressor.config, "seed") and getattr(regressor.config, "diffusion", True)


@lru_cache(maxsize=8)
def load_cached_model(name: str) -> regressors.Model:
    """The model of `load_model`; its cache can be cleared."""
    return regressors.load(find_model(name))


load_cached_rig = lru_cache(maxsize=64)(load_rig)


def _whispered(line: SpeechInput) -> tuple[str, ...]:
    remark = "the recording is whispered, so the mouth does not follow its level"
    return (remark,) if line.loudness is not None and line.loudness.whispered else ()
