"""Life: what a speaker's face does besides speaking, one module a behaviour.

Each behaviour is a function of a seed, of the line's prosody and of time; nothing outside of `AHEAD` and
`BACK` seconds around a frame decides it, so a stream gives what the whole line gives.
"""

from phonanim.life.layer import BACK, BEHAVIOURS, HEAD, Life, add_life, life_curves
from phonanim.speech.prosody import AHEAD

__all__ = ["AHEAD", "BACK", "BEHAVIOURS", "HEAD", "Life", "add_life", "life_curves"]
