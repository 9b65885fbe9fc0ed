"""A viewer in one HTML file: the speaking head with sound, phones, words and curves on a timeline."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.articulation import CHANNELS
from phonanim.core.files import read_bounded, write_text
from phonanim.core.pages import fill_page, script_data
from phonanim.errors import OutputError
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.media.glb import Glb
from phonanim.rig.head import SHIPPED
from phonanim.speech.alignment import pack_intervals
from phonanim.viewer.page import base64_text, character_targets, read_character, read_page_part

SUMMARY = "viewer in one file that works offline: head, sound, timeline, curves, two takes side by side"
INLINE = "<script>\n{{script}}\n</script>"
SCRIPTS = ("three.js", "data.js", "stage.js", "timeline.js", "player.js")
MAX_SOUND = 1 << 29  # bytes of a recording within a page: an hour of stereo at 48 kHz has 690 MB
AUDIO_TYPES = {
    ".wav": "audio/wav",
    ".flac": "audio/flac",
    ".ogg": "audio/ogg",
    ".opus": "audio/ogg",
    ".mp3": "audio/mpeg",
    ".aac": "audio/aac",
    ".m4a": "audio/mp4",
    ".mp4": "video/mp4",
    ".webm": "video/webm",
}


@dataclass(frozen=True, slots=True)
class Extras:
    """What a page has besides the viewer: further data, style and script, and origins that it may ask.

    `shared` are files of scripts beside the page, which hold the head and the viewer for many pages.
    """

    data: Mapping[str, Any] = field(default_factory=dict)
    style: str = ""
    script: str = ""
    connect: str = ""
    shared: tuple[str, ...] = ()


NO_EXTRAS = Extras()


def write(
    animation: Animation, path: Path, beside: Animation | None = None, character: Path = SHIPPED
) -> None:
    """Write the page; `beside` is a second take, shown next to the first.

    Raises RigError when the character is compressed, needs files outside its own, or has no target for any
    channel, OutputError when the sound cannot be read or the destination not be written.
    """
    write_text(path, viewer_page(animation, path.stem, beside, character))


def viewer_page(
    animation: Animation,
    title: str,
    beside: Animation | None = None,
    character: Path = SHIPPED,
    extras: Extras = NO_EXTRAS,
) -> str:
    """The page as text; the input of the animation is its title where it is known. Errors as of `write`."""
    glb = read_character(character)
    takes = [take_data(take, glb) for take in (animation, beside) if take]
    data = {
        "facts": _facts(animation),
        "takes": takes,
        "audio": sound_address(animation.audio) if animation.audio else None,
        "head": None if extras.shared else base64_text(character.read_bytes()),
        **extras.data,
    }
    fields = {
        "title": html.escape(str(animation.provenance.get("input", title))),
        "style": "\n".join([read_page_part("style.css"), extras.style]).rstrip("\n") + "\n",
        "data": script_data(data),
        "script": "" if extras.shared else viewer_script(extras.script),
    }
    page = read_page_part("page.html")
    if not extras.shared:
        return fill_page(page, fields, extras.connect)
    tags = "\n".join(f'<script src="{name}"></script>' for name in extras.shared)
    return fill_page(page.replace(INLINE, tags), fields, extras.connect, scripts="'self' file:")


def viewer_script(more: str = "") -> str:
    """The script of the viewer, and more that runs after it."""
    return "\n".join([*map(read_page_part, SCRIPTS), *([more] if more else [])])


def take_data(animation: Animation, glb: Glb | None = None) -> dict[str, Any]:
    """One take for the page: float32 curves, frame after frame; articulation, if known, last and in mm.

    With a character, the take has the targets that its channels move.
    """
    channels, values = animation.channels, animation.values
    if animation.articulation is not None:
        channels = (*channels, *(f"{name} mm" for name in CHANNELS))
        values = np.column_stack([values, animation.articulation])
    return {
        "name": str(animation.provenance.get("name", animation.provenance.get("input", animation.rig))),
        "fps": animation.fps,
        "start": animation.start,
        "channels": list(channels),
        **({} if glb is None else {"targets": character_targets(animation.channels, glb)}),
        "phones": pack_intervals(animation.phones),
        "words": pack_intervals(animation.words),
        "curves": base64_text(np.ascontiguousarray(values, "<f4").tobytes()),
    }


def _facts(animation: Animation) -> str:
    seconds = len(animation.values) / animation.fps
    return f"{animation.rig} · {animation.fps:g} fps · {seconds:.2f} s · {len(animation.phones)} phones"


def sound_address(path: Path) -> str:
    """A recording as a data address."""
    kind = AUDIO_TYPES.get(path.suffix.lower())
    if kind is None:
        raise OutputError(
            f"{path}: a browser plays {' '.join(AUDIO_TYPES)}; convert the recording to one of them"
        )
    try:
        return f"data:{kind};base64,{base64_text(read_bounded(path, MAX_SOUND))}"
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from error
