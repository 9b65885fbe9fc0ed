"""Rigs: the controls of a character, their limits, and how the reference face's modes move them."""

from __future__ import annotations

from phonanim.rig.read import load_rig, rig_names
from phonanim.rig.rig import HingeMap, Rig

__all__ = ["HingeMap", "Rig", "load_rig", "rig_names"]
