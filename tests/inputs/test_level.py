"""The level of usual speech, as a number or as a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from speech import write_wav
from voices import RATE, voiced

from phonanim.errors import AudioError, OptionError
from phonanim.inputs.level import parse_level
from phonanim.media.audio import Sound


def recording(path: Path, samples: np.ndarray) -> str:
    write_wav(path, Sound(samples.astype(np.float32), RATE))
    return str(path)


def test_numbers_and_recordings(tmp_path: Path) -> None:
    assert parse_level("-23.5") == -23.5
    loud, soft = (parse_level(recording(tmp_path / f"{g}.wav", g * voiced())) for g in (1.0, 0.1))
    assert loud == pytest.approx(-20, abs=2)
    assert loud - soft == pytest.approx(20, abs=0.2)


@pytest.mark.parametrize("text", ["loud", "3", "-91", "nan"])
def test_what_is_no_level(text: str) -> None:
    message = f"level = '{text}'; give dB of full scale, -90 to 0, or a recording"
    with pytest.raises(OptionError, match=message):
        parse_level(text)


def test_recordings_without_a_level(tmp_path: Path) -> None:
    silent = recording(tmp_path / "silent.wav", np.zeros(RATE))
    with pytest.raises(OptionError, match=r"silent.wav: has no voiced speech to take a level from"):
        parse_level(silent)
    with pytest.raises(AudioError, match=r"gone.wav: cannot be read"):
        parse_level(str(tmp_path / "gone.wav"))
