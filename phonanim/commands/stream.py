"""`phonanim stream`: animate phones or audio in real time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from phonanim.commands import Console, console_options
from phonanim.commands._chosen_rig import with_own_rig
from phonanim.commands._live_page import shown_places, sound_in_step, wait_for_page
from phonanim.commands._numbers import Number
from phonanim.commands._options import animation_options

if TYPE_CHECKING:
    from phonanim.options import Options
    from phonanim.stream.events import Event
    from phonanim.stream.play import Engine, Player

STDIN = 0
SLACK = 0.02  # seconds that audio may be late before a frame waits for it
EXACT = "exact"


class LookAhead(click.ParamType):  # type: ignore[type-arg]
    """Seconds, or "exact"."""

    name = "SECONDS|exact"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float | None:
        """None for exact."""
        if value is None or value == EXACT:
            return None
        try:
            seconds = float(value)
        except ValueError:
            self.fail(f"{value!r} is not a number of seconds or {EXACT}", param, ctx)
        if not 0 <= seconds <= 10:
            self.fail(f"{value} does not lie in 0 to 10 seconds", param, ctx)
        return seconds


@click.command()
@click.argument("source", default="-", type=click.Path(exists=True, dir_okay=False, allow_dash=True))
@click.option(
    "--to",
    "places",
    metavar="SINK[=HOST:PORT]",
    multiple=True,
    default=("stdout",),
    help="Where frames go: stdout, livelink, osc, vmc, websocket. Repeatable.",
)
@click.option("--realtime", is_flag=True, help="Send each frame at its time by the clock.")
@click.option("--look-ahead", type=LookAhead(), default="0.2", help="Seconds of phones that frames wait for.")
@click.option(
    "--delay",
    type=Number(0, 10),
    help="Seconds after its time at which a frame is sent; by default the look-ahead.",
    show_default=False,
)
@click.option(
    "--microphone", "--mic", is_flag=True, help="Read the microphone; SOURCE is then its name or number."
)
@click.option(
    "--rate", type=click.IntRange(4000, 384000), default=16000, help="Sample rate of raw samples, in hertz."
)
@click.option("--channels", type=click.IntRange(1, 64), default=1, help="Number of channels of raw samples.")
@click.option(
    "--origin",
    "origins",
    metavar="URL",
    multiple=True,
    help="Let pages of this site connect to the WebSocket. Repeatable.",
)
@click.option(
    "--audio",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The recording of an alignment, whose level the mouth follows; by default the one beside it.",
)
@click.option(
    "--character",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="GLB or VRM that the page of the WebSocket shows; the shipped head by default.",
)
@click.option(
    "--view",
    is_flag=True,
    help="Open the page of the WebSocket in the browser, and begin in real time when it is ready.",
)
@animation_options
@console_options
def command(
    source: str,
    places: tuple[str, ...],
    realtime: bool,
    look_ahead: float | None,
    delay: float | None,
    microphone: bool,
    rate: int,
    channels: int,
    origins: tuple[str, ...],
    audio: Path | None,
    character: Path | None,
    view: bool,
    options: Options,
    console: Console,
) -> None:
    """Animate phones or audio in real time, as they arrive.

    SOURCE is - (stdin) or a file: lines of JSON, such as {"phone": "AA1", "start": 0.1, "end": 0.2},
    {"time": 0.3}, {"end": true}; or any alignment. For an audio-driven model (audio, cnn, tcn) it is
    a recording, or - for raw samples: 16-bit, little-endian. A recording and the microphone are read by the
    model audio unless another is named.

    \b
    Examples:
      recognizer | phonanim stream --realtime --to livelink=192.168.1.5:11111
      phonanim stream line.TextGrid --view
      phonanim stream line.TextGrid --view --character mine.vrm
      phonanim stream line.TextGrid --audio line.wav --look-ahead exact
      phonanim stream --mic --to websocket
      phonanim stream speech.wav --realtime --to livelink
      arecord -f S16_LE -r 16000 | phonanim stream --model audio --to osc=127.0.0.1:9000
    """
    from phonanim.pipeline import load_model
    from phonanim.stream.own import check_places
    from phonanim.stream.play import Player, report_lines
    from phonanim.stream.sinks import Stage, open_named

    places, realtime = shown_places(places, view, character), realtime or view
    if character is not None:
        options = with_own_rig(options, character, console)
    options = with_audio_model(options, source, microphone)
    check_places(load_model(options.model), places)
    engine, events, ahead = open_engine(source, microphone, rate, channels, options, look_ahead, audio)
    check_options(realtime, ahead, delay)
    sound, start = sound_in_step(source, microphone, audio, options) if realtime else (None, 0.0)
    rest = tuple(float(value) for value in engine.rig.rest)
    stage = Stage(engine.rig.name, engine.rig.controls, options.fps, origins, rest, character, sound, start)
    sinks = [open_named(place, stage) for place in places]
    named = [sink.where for sink in sinks]
    player = Player(
        engine,
        sinks,
        options.fps,
        say=lambda text: print_problem(console, text),
        tell=lambda text: print_news(console, text),
    )
    console.print(f"{engine.rig.name} by {options.model}, {options.fps:g} fps, to {', '.join(named)}")
    try:
        if view:
            wait_for_page(sinks, console)
        run_stream(player, events, realtime, ahead, delay)
    except KeyboardInterrupt:
        if realtime:
            player.go_to_rest()
        raise
    finally:
        for sink in tuple(player.sinks):
            sink.close()
        if player.tally.frames or engine.ended:
            for line in (*report_lines(player.tally, named), *engine.notes):
                console.print(line)
        console.print_event("end", **stream_facts(player))
    if not player.sinks:
        raise click.exceptions.Exit(1)


def with_audio_model(options: Options, source: str, microphone: bool) -> Options:
    """The options with the model audio for a recording and for the microphone, unless one was chosen."""
    from phonanim.core.catalog import RECOGNITION_MODEL
    from phonanim.inputs.speech_input import is_recording

    chosen = click.get_current_context().get_parameter_source("model") is not ParameterSource.DEFAULT
    if chosen or not (microphone or is_recording(Path(source))):
        return options
    return replace(options, model=RECOGNITION_MODEL)


def open_engine(
    source: str,
    microphone: bool,
    rate: int,
    channels: int,
    options: Options,
    look_ahead: float | None,
    audio: Path | None = None,
) -> tuple[Engine, Iterator[Event], float | None]:
    """The engine that makes frames, the incoming events, and the look-ahead in seconds."""
    from phonanim.errors import OptionError
    from phonanim.inputs.speech_input import is_recording
    from phonanim.pipeline import load_model
    from phonanim.recognition.recognizer import mean_of
    from phonanim.recognition.spectrum import VoiceMean
    from phonanim.stream import inputs
    from phonanim.stream.engine import PhoneStream
    from phonanim.stream.recognized import RecognizedStream
    from phonanim.stream.sound import SoundStream

    line = "stream" if microphone or source == "-" else Path(source).stem
    modality = load_model(options.model).input_modality
    sounds = microphone or is_recording(Path(source))
    audio_driven = modality == "audio" or (modality == "recognized" and (sounds or source == "-"))
    silent = not (audio_driven or sounds)
    lines = silent and (source == "-" or inputs.is_lines(Path(source)))
    if audio is not None and (audio_driven or lines):
        raise OptionError(f"--audio {audio}: is for the recording of an alignment; leave it out")
    if audio_driven:
        if microphone:
            pieces = inputs.microphone(None if source == "-" else source, rate)
        elif source == "-":
            pieces = inputs.raw_samples(STDIN, channels)
        else:
            rate, pieces = inputs.recording(Path(source))
        if modality == "recognized":
            whole = look_ahead is None and sounds and not microphone
            mean = mean_of(Path(source)) if whole else VoiceMean()
            listening = RecognizedStream(options, rate, look_ahead, line, mean)
            waits = listening.look_ahead
            return listening, pieces, None if waits is None else waits + SLACK
        engine = SoundStream(options, rate, line)
        return engine, pieces, engine.look_ahead + SLACK
    if sounds:
        given = "--microphone: gives audio" if microphone else f"{source}: is a recording"
        raise OptionError(
            f"{given}, and {options.model} reads phones; choose --model audio, or one of kind cnn or tcn"
        )
    if lines:
        events = inputs.json_lines(STDIN if source == "-" else os.open(source, os.O_RDONLY))
        return PhoneStream(options, look_ahead, line), events, look_ahead
    return *open_alignment(Path(source), audio, options, look_ahead), look_ahead


def open_alignment(
    path: Path, audio: Path | None, options: Options, look_ahead: float | None
) -> tuple[Engine, Iterator[Event]]:
    """The engine and the events of an alignment, with its recording if there is a readable one."""
    from phonanim.errors import AudioError, MissingExtraError
    from phonanim.media.audio import find_audio
    from phonanim.stream import inputs
    from phonanim.stream.engine import PhoneStream

    language, words, offset, events = inputs.alignment_file(path, options)
    sound, rate = audio or find_audio(path), None
    if sound is not None and options.loudness > 0:
        try:
            rate, events = inputs.with_recording(events, sound, offset)
        except (AudioError, MissingExtraError):
            if audio is not None:
                raise
    return PhoneStream(replace(options, language=language), look_ahead, path.stem, words, rate), events


def check_options(realtime: bool, look_ahead: float | None, delay: float | None) -> None:
    """Raise OptionError when the options do not go together."""
    from phonanim.errors import OptionError

    if realtime and look_ahead is None:
        raise OptionError("--look-ahead exact waits as long as it takes; with --realtime give it in seconds")
    if delay is not None and not realtime:
        raise OptionError("--delay needs --realtime; add it")


def run_stream(
    player: Player, events: Iterator[Event], realtime: bool, look_ahead: float | None, delay: float | None
) -> None:
    """Run the stream to its end."""
    if realtime and look_ahead is not None:
        player.run_in_time(events, look_ahead, look_ahead if delay is None else delay)
    else:
        player.run(events)


def print_problem(console: Console, text: str) -> None:
    """Print a problem, also with --quiet."""
    if console.json:
        console.print_event("problem", text=text)
    else:
        click.echo(text, err=True)


def print_news(console: Console, text: str) -> None:
    """Print what was decided, such as the language."""
    console.print(text)
    console.print_event("note", text=text)


def stream_facts(player: Player) -> dict[str, object]:
    """Counts of the stream at its end, for scripts."""
    tally = player.tally
    return {
        "frames": tally.frames,
        "late": tally.late,
        "stalls": tally.stalls,
        "problems": tally.problems,
        "processor_ms_per_frame": round(1000 * tally.work / max(tally.frames, 1), 4),
    }
