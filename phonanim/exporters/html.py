"""A viewer in one HTML file: the speaking head with sound, phones, words and curves on a timeline."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.articulation import CHANNELS
from phonanim.core.files import write_text
from phonanim.core.pages import fill_page, script_data
from phonanim.errors import OutputError, RigError
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.media.glb import Glb, read_glb
from phonanim.media.gltf import external_files
from phonanim.rig.head import SHIPPED
from phonanim.speech.alignment import pack_intervals
from phonanim.viewer.page import base64_text, character_targets, read_page_part

SUMMARY = "viewer in one file that works offline: head, sound, timeline, curves, two takes side by side"
SCRIPTS = ("three.js", "data.js", "stage.js", "timeline.js", "player.js")
AUDIO_TYPES = {".wav": "audio/wav", ".flac": "audio/flac", ".ogg": "audio/ogg", ".mp3": "audio/mpeg"}


def write(
    animation: Animation, path: Path, beside: Animation | None = None, character: Path = SHIPPED
) -> None:
    """Write the page; `beside` is a second take, shown next to the first.

    Raises RigError when the character is compressed, needs files outside its own, or has no target for any
    channel, OutputError when the sound cannot be read or the destination not be written.
    """
    glb = read_glb(character)
    glb.refuse_compressed()  # the page cannot decode compressed meshes
    if outside := external_files(glb.tree):
        raise RigError(
            f"{character}: its {outside[0]!r:.60} is outside the file, and the page loads no other files; "
            "pack it with: npx @gltf-transform/cli copy IN.glb OUT.glb"
        )
    takes = [_take(take, glb) for take in (animation, beside) if take]
    data = {
        "facts": _facts(animation),
        "takes": takes,
        "audio": _sound(animation.audio) if animation.audio else None,
        "head": base64_text(character.read_bytes()),
    }
    fields = {
        "title": html.escape(str(animation.provenance.get("input", path.stem))),
        "style": read_page_part("style.css"),
        "data": script_data(data),
        "script": "\n".join(map(read_page_part, SCRIPTS)),
    }
    write_text(path, fill_page(read_page_part("page.html"), fields))


def _take(animation: Animation, glb: Glb) -> dict[str, Any]:
    """One take for the page: float32 curves, frame after frame; articulation, if known, last and in mm."""
    channels, values = animation.channels, animation.values
    if animation.articulation is not None:
        channels = (*channels, *(f"{name} mm" for name in CHANNELS))
        values = np.column_stack([values, animation.articulation])
    return {
        "name": str(animation.provenance.get("name", animation.provenance.get("input", animation.rig))),
        "fps": animation.fps,
        "start": animation.start,
        "channels": list(channels),
        "targets": character_targets(animation.channels, glb),
        "phones": pack_intervals(animation.phones),
        "words": pack_intervals(animation.words),
        "curves": base64_text(np.ascontiguousarray(values, "<f4").tobytes()),
    }


def _facts(animation: Animation) -> str:
    seconds = len(animation.values) / animation.fps
    return f"{animation.rig} · {animation.fps:g} fps · {seconds:.2f} s · {len(animation.phones)} phones"


def _sound(path: Path) -> str:
    """A recording as a data address."""
    kind = AUDIO_TYPES.get(path.suffix.lower())
    if kind is None:
        raise OutputError(
            f"{path}: a browser plays {' '.join(AUDIO_TYPES)}; convert the recording to one of them"
        )
    try:
        return f"data:{kind};base64,{base64_text(path.read_bytes())}"
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror}") from error
