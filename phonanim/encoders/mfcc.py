"""Mel-frequency cepstral coefficients and their slopes, which need no weights.

Medina (2023), section 3.2.2: 27 mel bins over windows of 2080 samples (130 ms), every 20 ms.
"""

from __future__ import annotations

from phonanim.encoders._cepstra import Cepstra

SIZE = 2080  # samples


def load() -> Cepstra:
    """The encoder."""
    return Cepstra(size=SIZE, sloped=True)
