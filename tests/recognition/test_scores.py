from __future__ import annotations

from pathlib import Path

import numpy as np

from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import read_sound, resample
from phonanim.recognition.scores import phone_misfits
from phonanim.speech.language import to_phones


def test_the_phones_that_are_said_fit_better_than_others(root: Path) -> None:
    sound = read_sound(root / "examples" / "line.wav")
    misfits = phone_misfits(resample(sound.samples, sound.rate, 16000))
    assert abs(len(misfits) - 100 * sound.duration) < 1
    np.testing.assert_allclose(misfits.min(axis=1), 0, atol=1e-6)
    track, _ = to_phones(read_alignment(root / "examples" / "line.TextGrid"), "english")
    said = track.sample(np.arange(len(misfits)) / 100)
    others = np.roll(said, 50)
    steps = np.arange(len(misfits))
    assert misfits[steps, said].mean() < 0.5 * misfits[steps, others].mean()
