"""Life: what a speaker's face does besides speaking, one module a behaviour.

Each behaviour is a function of a seed, of the line's prosody and of time; nothing outside of `AHEAD` and
`BACK` seconds around a frame decides it, so a stream gives what the whole line gives.
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
