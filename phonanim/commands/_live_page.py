"""The live page of `phonanim stream`: its place, its sound, and waiting for it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from phonanim.commands import Console

if TYPE_CHECKING:
    from phonanim.options import Options
    from phonanim.stream.sinks import Sink

WEBSOCKET = "websocket"
PATIENCE = 300.0  # seconds that a page may take to open and to be clicked


def shown_places(places: tuple[str, ...], view: bool, character: Path | None) -> tuple[str, ...]:
    """Where frames go, with the WebSocket when its page is wanted. Raises OptionError."""
    from phonanim.errors import OptionError

    served = any(place.partition("=")[0] == WEBSOCKET for place in places)
    if view and not served:
        given = click.get_current_context().get_parameter_source("places")
        return (WEBSOCKET,) if given is ParameterSource.DEFAULT else (*places, WEBSOCKET)
    if character is not None and not served:
        raise OptionError(
            f"--character {character}: is shown by the page of --to websocket; add it, or --view"
        )
    return places


def sound_in_step(
    source: str, microphone: bool, audio: Path | None, options: Options
) -> tuple[Path | None, float]:
    """The recording that a page plays in step with the frames, and its second that is 0 of them."""
    from phonanim.exporters.html import AUDIO_TYPES
    from phonanim.inputs.speech_input import is_recording, read_with_options
    from phonanim.media.audio import find_audio
    from phonanim.stream import inputs

    if microphone or source == "-" or inputs.is_lines(Path(source)):
        return None, 0.0
    path = Path(source)
    sound = path if is_recording(path) else audio or find_audio(path)
    if sound is None or sound.suffix.lower() not in AUDIO_TYPES:
        return None, 0.0
    return sound, 0.0 if is_recording(path) else read_with_options(path, options, sound).offset


def wait_for_page(sinks: list[Sink], console: Console) -> None:
    """Open the live page, and wait until it is ready. Raises StreamError when it never is."""
    import webbrowser

    from phonanim.errors import StreamError
    from phonanim.stream.sinks import Waiting

    for sink in sinks:
        if isinstance(sink, Waiting):
            console.print(f"waiting for {sink.where} to be ready; press Sound there, if there is one")
            webbrowser.open(sink.where)
            if not sink.wait(PATIENCE):
                raise StreamError(
                    f"{sink.where}: no page was ready within {PATIENCE:g} s; open it in a browser"
                )
