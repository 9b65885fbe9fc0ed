"""What an audit asks of the motion of a line: whether it moves, and whether it ends with the line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.errors import AudioError, MissingExtraError
from phonanim.media.audio import audio_duration
from phonanim.pipeline import AnimationResult
from phonanim.speech.alignment import Interval
from phonanim.speech.labels import is_silent

STILL = 0.01  # of a control's range: less motion is not seen
TOLERANCE = 0.15  # seconds between the end of a line and the end of its animation


def line_motion(result: AnimationResult, audio: Path | None) -> dict[str, Any]:
    """The motion of a line that was made; empty when its recording cannot be read on this machine."""
    try:
        seconds = audio_duration(audio) if audio else result.track.duration
    except (AudioError, MissingExtraError):
        return {}
    return measure_motion(result.animation, result.animation.phones, seconds)


def measure_motion(animation: Animation, phones: Iterable[Interval], seconds: float) -> dict[str, Any]:
    """Whether a line of speech does not move, when its animation ends, and its `seconds`."""
    still = bool(np.ptp(animation.values, axis=0).max(initial=0.0) < STILL)
    return {
        "still": still and not all(is_silent(phone.label) for phone in phones),
        "end": round((len(animation.values) - 1) / animation.fps, 6),
        "seconds": round(seconds, 6),
    }


def motion_problems(motion: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The problems of a motion: (problem, text)."""
    if motion["still"]:
        yield "still", "nothing moves during speech"
    end, seconds = motion["end"], motion["seconds"]
    if abs(end - seconds) > TOLERANCE:
        yield "mistimed", f"ends at {end:.2f} s, the line at {seconds:.2f} s"
