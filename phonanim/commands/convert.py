"""`phonanim convert`: convert an animation file to other formats."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._between_rigs import for_formats, on_rig
from phonanim.commands._export import FILE, NAMES, export_options, output_notes, save_outputs
from phonanim.commands._numbers import Number
from phonanim.commands._outputs import OUTPUT, check_outputs, format_size, shown_character
from phonanim.commands._renamed import renamed_option

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation


@click.command()
@click.argument("source", type=FILE)
@click.option("-o", "--output", "outputs", type=OUTPUT, multiple=True, help="File to write. Repeatable.")
@click.option("--fps", metavar="RATE", help="New frame rate, such as 25 or 29.97.")
@click.option("--start", type=Number(-1e6, 1e6), help="Time of the first frame, in seconds.")
@click.option("--alignment", type=FILE, help="Alignment with phones and words, for timelines and cues.")
@click.option("--audio", type=FILE, help="The recording.")
@click.option(
    "--rig",
    help="Rig to convert the channels to, or that they belong to, where the file does not name it.",
)
@renamed_option(
    "--compare-with", "--beside", type=FILE, help="A second take, shown next to the first in a .html."
)
@renamed_option(
    "--contact-sheet", "--sheet", type=OUTPUT, help="Also draw a contact sheet of the face, as PNG."
)
@export_options
@NAMES
@console_options
def command(
    source: Path,
    outputs: tuple[Path, ...],
    fps: str | None,
    start: float | None,
    alignment: Path | None,
    audio: Path | None,
    rig: str | None,
    beside: Path | None,
    sheet: Path | None,
    exports: dict[str, object],
    console: Console,
) -> None:
    """Convert an animation to other formats: a capture, a take, another tool's output.

    The suffixes choose the formats. `phonanim info` lists them; docs/output.md lists which can be read.

    \b
    Examples:
      phonanim convert capture.csv -o capture.npz
      phonanim convert take.glb -o take.anim --key-tolerance 0.01
      phonanim convert capture.csv -o capture.html --alignment line.TextGrid --audio line.wav
      phonanim convert capture.csv -o capture.metahuman.csv
      phonanim convert take.metahuman.csv -o take.glb
      phonanim convert take1.npz -o takes.html --compare-with take2.npz
      phonanim convert take.npz -o take.csv --fps 29.97 --timecode "01:00:00;00"
    """
    from phonanim.exporters import find_exporter, load

    if not outputs and not sheet:
        raise click.UsageError("nothing to write: name a file with -o, or a picture with --contact-sheet")
    check_outputs([*outputs, *filter(None, [sheet])], [source, *filter(None, [alignment, audio, beside])])
    for path in outputs:
        find_exporter(path)
    animation = apply_overrides(load(source), fps, start, alignment, audio)
    animation, notes = on_rig(animation, rig) if rig else (animation, ())
    takes, more = for_formats(animation, outputs, "character" in exports)
    second = {"beside": load(beside)} if beside else {}
    save_outputs(animation, outputs, exports | second, sheet is not None, takes)
    if sheet:
        from phonanim.viewer.sheet import save_sheet

        save_sheet(animation, sheet, shown_character(exports))
    facts = describe(animation, source, [*outputs, *filter(None, [sheet])])
    for line in (*report_lines(facts), *notes, *more, *output_notes(animation, outputs, exports)):
        console.print(line)
    console.print_result(facts)


def apply_overrides(
    animation: Animation,
    fps: str | None,
    start: float | None,
    alignment: Path | None,
    audio: Path | None,
) -> Animation:
    """The animation with the options that were given in place of the file's values."""
    if fps is not None:
        from phonanim.animation.rates import parse_rate

        animation = animation.at_rate(parse_rate(fps))
    if alignment is not None:
        from phonanim.inputs.alignment import read_alignment

        read = read_alignment(alignment)
        animation = replace(animation, phones=read.intervals, words=read.words)
    given = {"start": start, "audio": audio}
    return replace(animation, **{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]


def describe(animation: Animation, source: Path, written: list[Path]) -> dict[str, Any]:
    """The result as data, for scripts."""
    frames, channels = animation.values.shape
    return {
        "source": str(source),
        "frames": frames,
        "fps": animation.fps,
        "seconds": round((frames - 1) / animation.fps, 6),
        "channels": channels,
        "rig": animation.rig,
        "outputs": [{"path": str(path), "bytes": path.stat().st_size} for path in written],
    }


def report_lines(facts: dict[str, Any]) -> list[str]:
    """The same as text."""
    files = ", ".join(f"{output['path']} ({format_size(output['bytes'])})" for output in facts["outputs"])
    return [
        f"read {facts['source']}: {facts['frames']} frames at {facts['fps']:g} fps, "
        f"{facts['channels']} channels",
        f"wrote {files}",
    ]
