"""Rhubarb Lip Sync XML: mouth shapes with start and end."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import escape

from phonanim.animation.animation import Animation
from phonanim.core.files import write_text
from phonanim.exporters._cues import mouth_cues

SUMMARY = "Rhubarb Lip Sync cues as XML"
PAGE = """<?xml version="1.0" encoding="utf-8"?>
<rhubarbResult>
  <metadata>
    <soundFile>{sound}</soundFile>
    <duration>{duration:.2f}</duration>
  </metadata>
  <mouthCues>
{cues}
  </mouthCues>
</rhubarbResult>
"""


def write(animation: Animation, path: Path) -> None:
    """Write `metadata` and `mouthCues`, times in seconds to two decimals. Raises OutputError."""
    cues = mouth_cues(animation, "rhubarb", path)
    lines = [
        f'    <mouthCue start="{cue.start:.2f}" end="{cue.end:.2f}">{cue.label}</mouthCue>' for cue in cues
    ]
    sound = escape(animation.audio.name) if animation.audio else ""
    write_text(path, PAGE.format(sound=sound, duration=cues[-1].end, cues="\n".join(lines)))
