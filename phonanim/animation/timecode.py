"""SMPTE timecode: hours:minutes:seconds:frames, with drop-frame counting (SMPTE ST 12-1)."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import OptionError

TEXT = re.compile(r"(\d{1,2}):(\d{1,2}):(\d{1,2})([:;])(\d{1,3}(?:\.\d+)?)")
DAY = 24  # hours


@dataclass(frozen=True)
class Timecode:
    """A way to count frames: `nominal` per second of timecode.

    Drop-frame counting is for the NTSC rates, `nominal` · 1000/1001: it leaves out two labels per 30 at the
    start of every minute but the tenth, so that labels stay close to real time.
    """

    nominal: int
    drop: bool = False

    @property
    def rate(self) -> float:
        """Frames per second of real time."""
        return self.nominal * 1000 / 1001 if self.drop else float(self.nominal)

    @property
    def dropped(self) -> int:
        """Labels left out at the start of a minute."""
        return self.nominal // 30 * 2 if self.drop else 0

    def format(self, time: float) -> str:
        """The label of a time in seconds, with thousandths of a frame; it restarts after a day."""
        hours, minutes, seconds, frame, fraction = (int(part[0]) for part in self.counts(np.array([time])))
        return f"{hours:02}:{minutes:02}:{seconds:02}{self.mark}{frame:02}.{fraction:03}"

    def counts(self, times: NDArray[np.float64]) -> tuple[NDArray[np.int64], ...]:
        """Numbers in the labels of times, (n,) seconds -> hours, minutes, seconds, frames, thousandths."""
        frames, fraction = np.divmod(np.rint(times * self.rate * 1000).astype(np.int64), 1000)
        if self.drop:
            tens, rest = np.divmod(frames, 10 * self._minute + self.dropped)
            frames = frames + self.dropped * (9 * tens + np.maximum(0, rest - self.dropped) // self._minute)
        seconds, frame = np.divmod(frames, self.nominal)
        return seconds // 3600 % DAY, seconds // 60 % 60, seconds % 60, frame, fraction

    def parse(self, text: str) -> float:
        """The inverse of `format`, in seconds. Raises OptionError for an invalid label."""
        found = TEXT.fullmatch(text.strip())
        if not found or (found[4] == ";") != self.drop:
            example = "01:00:00;02" if self.drop else "01:00:00:02"
            raise OptionError(
                f"{text!r} is not a timecode at {self.rate:.6g} frames per second; write {example}"
            )
        hours, minutes, seconds, frames = int(found[1]), int(found[2]), int(found[3]), float(found[5])
        if minutes > 59 or seconds > 59 or frames >= self.nominal:
            raise OptionError(f"{text!r}: minutes and seconds go to 59, frames to {self.nominal - 1}")
        if seconds == 0 and minutes % 10 and frames < self.dropped:
            raise OptionError(f"{text!r} is left out in drop-frame counting; write frame {self.dropped:02}")
        whole = hours * 60 + minutes
        counted = (whole * 60 + seconds) * self.nominal + frames - self.dropped * (whole - whole // 10)
        return counted / self.rate

    @property
    def mark(self) -> str:
        """The character before the frames."""
        return ";" if self.drop else ":"

    @property
    def _minute(self) -> int:
        """Labels of a minute that leaves some out."""
        return 60 * self.nominal - self.dropped


def timecode_for_label(text: str, nominal: int) -> Timecode:
    """Detect how a label counts: `;` before its frames means drop-frame."""
    return Timecode(nominal, drop=";" in text)
