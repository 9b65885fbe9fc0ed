"""The level of speech that counts as usual, in numbers or as a recording."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from phonanim.errors import OptionError
from phonanim.media.audio import RECORDINGS, read_sound
from phonanim.media.voice import analyze_voice
from phonanim.speech.loudness import speech_level

QUIETEST = -90.0  # dB of full scale


def parse_level(text: str, find: Callable[[str], Path] = Path) -> float:
    """Decibels of full scale from a number, or those of the speech in a recording, whose path `find` gives.

    Raises OptionError, and AudioError for a recording that cannot be read.
    """
    if text.lower().endswith(RECORDINGS):
        path = find(text)
        sound = read_sound(path)
        level = speech_level(analyze_voice(sound.samples, sound.rate))
        if math.isnan(level):
            raise OptionError(f"{path}: has no voiced speech to take a level from; name another recording")
        return round(level, 2)
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not QUIETEST <= value <= 0:
        raise OptionError(f"level = {text!r}; give dB of full scale, -90 to 0, or a recording")
    return value
