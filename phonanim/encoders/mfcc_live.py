"""Mel-frequency cepstral coefficients with little look-ahead: windows of 40 ms, and no slopes.

A convolutional network computes slopes itself. Slopes and long windows cost `mfcc` 85 ms of look-ahead,
which is better spent on the audio that follows.
"""

from __future__ import annotations

from phonanim.encoders._cepstra import Cepstra

SIZE = 640  # samples


def load() -> Cepstra:
    """The encoder."""
    return Cepstra(size=SIZE, sloped=False)
