"""Corrections of a line: its phones, settings and curves, as a person set them for this line alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from phonanim.animation.edits import Edits
from phonanim.options import Closure, Emotion, Options
from phonanim.speech.anchors import Anchors, match_phones
from phonanim.speech.intervals import Interval
from phonanim.speech.phone_changes import PhoneChanges

WHOLE = ("language", "intensity", "jaw", "lips", "rounding", "quickness", "reduction", "hold", "loudness")
"""Options that a correction may set for the whole line."""


@dataclass(frozen=True, slots=True)
class Corrections:
    """What a person corrected in a line.

    `settings` are options of the line by their names: those of `WHOLE`, `gains`, and `emotions` and
    `closures`, whose spans are in the time of the corrected phones. `style` is the name of the style that its
    dials come from, if any. `curves` are edits, which refer to phones of their own.
    """

    phones: PhoneChanges = field(default_factory=PhoneChanges)
    settings: Mapping[str, Any] = field(default_factory=dict)
    style: str = ""
    curves: Edits | None = None

    @property
    def empty(self) -> bool:
        """Whether nothing is corrected."""
        same = self.phones.before == self.phones.after
        return same and not self.settings and not (self.curves and self.curves.edits)


def corrected_options(options: Options, corrections: Corrections) -> Options:
    """The options of a line with the settings that hold for the whole of it."""
    settings = dict(corrections.settings)
    timed = {name: settings.pop(name) for name in ("emotions", "closures") if name in settings}
    gains = {**options.gains, **settings.pop("gains", {})}
    return replace(options, gains=gains, **settings, **timed)


def timed_options(options: Options, corrections: Corrections, phones: tuple[Interval, ...]) -> Options:
    """The options with the spans of emotions and closures moved as the phones moved, now `phones`."""
    timed = {"emotions", "closures"} & corrections.settings.keys()
    spoken = corrections.phones.after
    if not timed or not spoken or spoken == phones:
        return options
    anchors = match_phones(spoken, phones)
    moved: dict[str, Any] = {}
    if "emotions" in timed:
        moved["emotions"] = tuple(_moved_emotion(emotion, anchors) for emotion in options.emotions)
    if "closures" in timed:
        moved["closures"] = tuple(_moved_closure(closure, anchors) for closure in options.closures)
    return replace(options, **moved)


def _moved_emotion(emotion: Emotion, anchors: Anchors) -> Emotion:
    if emotion.span is None:
        return emotion
    start, end = anchors.moved(emotion.span)
    return replace(emotion, span=(float(start), float(end)))


def _moved_closure(closure: Closure, anchors: Anchors) -> Closure:
    start, end = anchors.moved((closure.start, closure.end))
    return replace(closure, start=float(start), end=float(end))
