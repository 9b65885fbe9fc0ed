"""Articulation: what the jaw, the lips and the tongue do, in millimetres, between phones and a rig.

`channels` names the measures, `table` reads the targets of lexicon/articulation.csv, `trajectories` blends
them over time, `closures` keeps contacts.
"""

from phonanim.articulation.channels import CHANNELS, Articulation
from phonanim.articulation.trajectories import articulate

__all__ = ["CHANNELS", "Articulation", "articulate"]
