"""Rigs: a character's controls, their limits, and their mapping from the reference face's modes."""

from __future__ import annotations

from phonanim.rig.read import load_rig, rig_names
from phonanim.rig.rig import HingeMap, Rig

__all__ = ["HingeMap", "Rig", "load_rig", "rig_names"]
