"""Rhubarb Lip Sync JSON: mouth shapes with start and end."""

from __future__ import annotations

import json
from pathlib import Path

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.exporters._cues import mouth_cues

SUMMARY = "Rhubarb Lip Sync cues as JSON, for Godot, Spine, After Effects and web players"


def write(animation: Animation, path: Path) -> None:
    """Write `metadata` and `mouthCues`, times in seconds to two decimals. Raises OutputError."""
    cues = mouth_cues(animation, "rhubarb", path)
    tree = {
        "metadata": {
            "soundFile": animation.audio.name if animation.audio else "",
            "duration": round(cues[-1].end, 2),
        },
        "mouthCues": [
            {"start": round(cue.start, 2), "end": round(cue.end, 2), "value": cue.label} for cue in cues
        ],
    }
    write_text(path, json.dumps(tree, ensure_ascii=False, indent=2) + "\n")
