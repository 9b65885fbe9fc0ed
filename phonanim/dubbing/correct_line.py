"""A line of a review: as it is made now, with its corrections, and anew with others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.animation.corrections import Corrections, corrected_options, timed_options
from phonanim.animation.edit_file import read_edits
from phonanim.animation.edits import Edits, diff_animations
from phonanim.animation.other_rig import move_to_rig
from phonanim.correcting import animate_edited, apply_line_edits
from phonanim.dubbing.align_lines import aligned_options, alignment_place, prepare_line, sound_place
from phonanim.dubbing.line import Line
from phonanim.errors import LabelError, OptionError
from phonanim.exporters import needed_rig
from phonanim.options import Options
from phonanim.pipeline import AnimationResult, load_cached_rig
from phonanim.rig.head import SHIPPED
from phonanim.speech.intervals import Interval
from phonanim.speech.language_names import AUTO
from phonanim.speech.phone_changes import PhoneChanges, check_phones

PAGE = Path("line.html")
Points = Sequence[tuple[float, float]]
"""A drawn curve: (seconds, value), in order of time."""


@dataclass(frozen=True, slots=True)
class Take:
    """A line as it is made now: its motion on the rig that is shown, and what was corrected.

    `read` are its phones before corrections; `corrections` refer to the phones of this take; `options` are
    those that it was made with; `notes` are what did not fit. `fault` is why a batch does not make the line,
    which is then shown with what could not be read as silence.
    """

    animation: Animation
    read: tuple[Interval, ...]
    corrections: Corrections
    options: Options
    notes: tuple[str, ...] = ()
    fault: str = ""


def make_take(line: Line, folder: Path, corrections: Corrections) -> Take:
    """Make a line with corrections, to be shown. Raises PhonanimError where there is nothing to show."""
    try:
        options = aligned_options(line) if line.text is not None else line.options
        return _made(line, folder, corrections, options)
    except LabelError as error:
        languages = dict.fromkeys([line.options.language, AUTO])
        for language in languages:
            options = replace(line.options, language=language, unknown="silence")
            with suppress(LabelError):
                lenient = {name: one for name, one in corrections.settings.items() if name != "language"}
                take = _made(line, folder, replace(corrections, settings=lenient), options)
                settings = {**take.corrections.settings, **_language(corrections)}
                kept = replace(take.corrections, settings=settings)
                return replace(take, corrections=kept, fault=str(error), notes=(str(error), *take.notes))
        raise


def _language(corrections: Corrections) -> dict[str, Any]:
    """The setting of the language, if there is one."""
    return {name: one for name, one in corrections.settings.items() if name == "language"}


def _made(line: Line, folder: Path, corrections: Corrections, options: Options) -> Take:
    """Make a line with options."""
    path, audio = _local(line, folder)
    own = options.rig
    options = _shown_options(options, line)
    edits = [read_edits(line.edits)] if isinstance(line.edits, Path) else []
    result = animate_edited(path, options, audio, edits, _shown_corrections(corrections, own, options.rig))
    spoken = result.animation.phones
    now = timed_options(corrected_options(options, corrections), corrections, spoken)
    timed = {name: getattr(now, name) for name in ("emotions", "closures") if name in corrections.settings}
    settled = replace(
        corrections, phones=PhoneChanges(result.read, spoken), settings={**corrections.settings, **timed}
    )
    return Take(_shown(result, line), result.read, settled, now, result.notes)


def corrected(
    take: Take,
    line: Line,
    folder: Path,
    spoken: tuple[Interval, ...],
    settings: Mapping[str, object],
    style: str,
    drawn: Mapping[str, Points],
) -> Corrections:
    """The corrections of a take with other phones and settings, and with curves that were drawn over it.

    Drawing no points clears what was drawn over a channel before. Raises OptionError for what cannot be.
    """
    duration = max(float(take.animation.times[-1]), *(phone.end for phone in take.read), 0.0)
    check_phones(spoken, duration)
    curves = take.corrections.curves
    phones = PhoneChanges(take.read, spoken)
    changed = replace(take.corrections, phones=phones, settings=settings, style=style)
    if drawn:
        base = make_take(line, folder, replace(changed, curves=None)).animation
        curves = _redrawn(base, curves, drawn)
        changed = replace(changed, curves=curves)
    return changed


def shows_own_rig(line: Line) -> bool:
    """Whether the page shows the rig of a line: its character, or one that the shipped head can show."""
    if "character" in line.exports:
        return True
    return not needed_rig(PAGE, load_cached_rig(line.options.rig).controls)


def shown_head(line: Line) -> Path:
    """The character that shows a line."""
    character = line.exports.get("character")
    return character if isinstance(character, Path) else SHIPPED


def _local(line: Line, folder: Path) -> tuple[Path, Path | None]:
    """The alignment and the recording of a line. Raises OptionError where they are not on this machine.

    What the run aligned or spoke is taken as it is.
    """
    path, audio = alignment_place(line, folder), sound_place(line, folder)
    if not isinstance(path, Path) or not isinstance(audio, Path | None):
        raise OptionError(f"{line.source}: is not on this machine; copy the lines here to correct them")
    if not path.is_file():
        prepare_line(line, folder)
    return path, audio


def _shown_options(options: Options, line: Line) -> Options:
    """The options on the line's own rig, or on the shipped head's where no table leads there."""
    if shows_own_rig(line):
        return options
    shown = needed_rig(PAGE, load_cached_rig(options.rig).controls)
    probe = load_cached_rig(options.rig)
    empty = Animation(np.zeros((1, len(probe.controls)), np.float32), probe.controls, 1.0, probe.name)
    return options if move_to_rig(empty, shown) else replace(options, rig=shown, gains={})


def _shown_corrections(corrections: Corrections, own: str, shown: str) -> Corrections:
    """Corrections without the gains of a rig that is not shown. Raises OptionError for a control it lacks."""
    gains = corrections.settings.get("gains", {})
    if own == shown or not gains:
        return corrections
    for name in gains:
        if name not in load_cached_rig(own).controls:
            raise OptionError(f"there is no control {name!r:.60} on the rig {own}")
    others = {name: one for name, one in corrections.settings.items() if name != "gains"}
    return replace(corrections, settings=others)


def _shown(result: AnimationResult, line: Line) -> Animation:
    """The animation on the rig that is shown."""
    animation = result.animation
    if "character" in line.exports or not (rig := needed_rig(PAGE, animation.channels)):
        return animation
    moved = move_to_rig(animation, rig)
    return moved[0] if moved else animation


def _redrawn(base: Animation, curves: Edits | None, drawn: Mapping[str, Points]) -> Edits:
    """The edits of a base with some channels drawn anew; the others keep theirs."""
    options = Options(rig=base.rig)
    before = base if curves is None else apply_line_edits(base, curves, options)
    values = before.values.copy()
    for channel, points in drawn.items():
        if channel not in base.channels:
            raise OptionError(f"there is no curve {channel!r:.60} on the rig {base.rig}")
        column = base.channels.index(channel)
        if not points:
            values[:, column] = base.values[:, column]
            continue
        times, heights = (np.asarray(part, np.float64) for part in zip(*points, strict=True))
        if not (np.isfinite(times).all() and np.isfinite(heights).all() and (np.diff(times) >= 0).all()):
            raise OptionError(f"the curve drawn over {channel} has times that are not in order")
        within = (base.times >= times[0]) & (base.times <= times[-1])
        values[within, column] = np.interp(base.times[within], times, heights)
    found = diff_animations(base, before.with_values(values))
    if curves is None or (curves.phones, curves.rig) != (found.phones, found.rig):
        return found
    kept = [edit for edit in curves.edits if edit.channel not in drawn]
    return replace(found, edits=(*kept, *(edit for edit in found.edits if edit.channel in drawn)))
