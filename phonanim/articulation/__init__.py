"""Articulation: the motion of jaw, lips and tongue in millimetres, computed from phones and applied to a rig.

`channels` names the measures, `table` reads the targets of lexicon/articulation.csv, `trajectories` blends
them over time, `closures` enforces contacts.
"""

from phonanim.articulation.channels import CHANNELS, Articulation
from phonanim.articulation.trajectories import articulate

__all__ = ["CHANNELS", "Articulation", "articulate"]
