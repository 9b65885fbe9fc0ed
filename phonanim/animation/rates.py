"""Frame rates: exact NTSC rates, and the instants of a line's frames."""

from __future__ import annotations

import math
from fractions import Fraction

from phonanim.errors import OptionError

# Usual spellings of the NTSC rates, which are whole rates x 1000/1001.
NTSC = {"23.976": 24, "23.98": 24, "29.97": 30, "47.952": 48, "47.95": 48, "59.94": 60, "119.88": 120}
LOWEST, HIGHEST = 1, 1000  # hertz
ROUNDING = 1e-6  # frames: an instant closer than this beyond the end counts as the end


def parse_rate(text: str) -> float:
    """Frames per second from "60", "29.97" (taken as 30000/1001) or "30000/1001". Raises OptionError."""
    stripped = text.strip()
    try:
        rate = Fraction(NTSC[stripped] * 1000, 1001) if stripped in NTSC else Fraction(stripped)
    except (ValueError, ZeroDivisionError) as error:
        raise OptionError(f"{text!r} is not a frame rate; write it as 60, 29.97 or 30000/1001") from error
    check_rate(rate, text)
    return float(rate)


def check_rate(rate: float | Fraction, text: str) -> None:
    """Raise OptionError, naming the rate as it was written, when it is out of range."""
    if not LOWEST <= rate <= HIGHEST:
        raise OptionError(f"{text} frames per second: the rate must lie from {LOWEST} to {HIGHEST}")


def frame_count(duration: float, fps: float) -> int:
    """The number of instants n / fps, n = 0, 1, ..., from 0 to `duration` seconds, both included."""
    return math.floor(duration * fps + ROUNDING) + 1
