"""Pitch by Praat, where the extra `pitch` is installed. It uses the whole recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from phonanim.errors import MissingExtraError
from phonanim.media.voice import FRAMES, Floats, Voice

FLOOR, CEILING = 70.0, 500.0  # hertz


def with_praat_pitch(voice: Voice, samples: Floats, rate: int) -> Voice:
    """A voice from the start of mono samples in -1..1, (samples,), with the pitch that Praat finds.

    Boersma's autocorrelation method with his path over frames (1993, Proceedings of the Institute of Phonetic
    Sciences 17). Raises MissingExtraError without parselmouth.
    """
    try:
        from parselmouth import PraatError, Sound
    except ImportError as error:
        raise MissingExtraError("pitch by Praat needs pip install 'phonanim[pitch]'") from error
    try:
        found = Sound(samples.astype(float), rate).to_pitch_ac(
            time_step=1 / FRAMES, pitch_floor=FLOOR, pitch_ceiling=CEILING
        )
    except PraatError:  # too short for one period
        return replace(voice, pitch=np.full(len(voice.level), np.nan))
    hertz = found.selected_array["frequency"]
    rows = np.rint((np.arange(len(voice.level)) / FRAMES - found.xs()[0]) * FRAMES).astype(np.int64)
    inside = (rows >= 0) & (rows < len(hertz))
    hertz = np.where(inside, hertz[np.clip(rows, 0, len(hertz) - 1)], 0.0)
    return replace(voice, pitch=np.where(hertz > 0, hertz, np.nan))
