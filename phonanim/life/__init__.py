"""Life: motion of a speaker's face besides speech, one module per behaviour.

Each behaviour is a function of a seed, the line's prosody and time. A frame depends only on what is within
`AHEAD` and `BACK` seconds of it, so a stream gives the same result as the whole line.
"""

from phonanim.life.layer import (
    BACK,
    BEHAVIOURS,
    Life,
    add_life,
    idle_life,
    life_curves,
    life_of,
    life_offsets,
    lively,
    mouth_freedom,
)
from phonanim.speech.prosody import AHEAD

__all__ = [
    "AHEAD",
    "BACK",
    "BEHAVIOURS",
    "Life",
    "add_life",
    "idle_life",
    "life_curves",
    "life_of",
    "life_offsets",
    "lively",
    "mouth_freedom",
]
