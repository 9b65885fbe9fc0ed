"""Mel-frequency cepstral coefficients that hear little ahead: windows of 40 ms, and no slopes.

A network of convolutions finds slopes by itself, and the 85 ms that `mfcc` spends on hearing ahead for them
and for its long windows are better spent on what is said next.
"""

from __future__ import annotations

from phonanim.encoders._cepstra import Cepstra

SIZE = 640  # samples


def load() -> Cepstra:
    """The encoder."""
    return Cepstra(size=SIZE, sloped=False)
