"""How loud the speech of a line is, for SLCC: the correlation over lines of level and speed of the lips."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.errors import EvaluationError
from phonanim.evaluation.predictions import line_name
from phonanim.media.audio import read_sound
from phonanim.media.voice import analyze_voice

SOUNDS = (".wav", ".flac", ".ogg", ".mp3")


def speech_level(path: Path) -> float:
    """Mean level of the voiced frames of a sound, dB of full scale; NaN without voice. Raises AudioError."""
    sound = read_sound(path)
    voice = analyze_voice(sound.samples, sound.rate)
    spoken = voice.active() & np.isfinite(voice.pitch)
    return float(voice.level[spoken].mean()) if spoken.any() else float("nan")


def find_sound(sound: Path, prediction: Path) -> Path:
    """The sound of a line: a file, or the one of its stem in a folder. Raises EvaluationError."""
    if not sound.is_dir():
        return sound
    name = line_name(prediction)
    for suffix in SOUNDS:
        if (sound / f"{name}{suffix}").is_file():
            return sound / f"{name}{suffix}"
    raise EvaluationError(f"{sound}: has no sound named {name} ({', '.join(SOUNDS)}); rename it")
