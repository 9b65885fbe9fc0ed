"""Life: what a speaker's face does besides speaking, one module a behaviour.

Each behaviour is a function of a seed, of the line's prosody and of time; nothing outside of `AHEAD` and
`BACK` seconds around a frame decides it, so a stream gives what the whole line gives.
"""

from phonanim.life.layer import AHEAD, BACK, BEHAVIOURS, HEAD, add_life, life_curves

__all__ = ["AHEAD", "BACK", "BEHAVIOURS", "HEAD", "add_life", "life_curves"]
