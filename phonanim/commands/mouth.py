"""`phonanim mouth`: render mouths that were learned from films."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.commands._numbers import Number

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.group()
def command() -> None:
    """Render the mouth of a filmed speaker saying something new.

    \b
    Example:
      phonanim mouth draw line.TextGrid --model models/mouth -o line.mp4
    """


@command.command()
@click.argument("config", type=FILE)
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder to write."
)
@console_options
def train(config: Path, output: Path, console: Console) -> None:
    """Train a mouth from a TOML configuration, on a corpus with an appearance model.

    \b
    Example:
      phonanim mouth train benchmarks/configs/mouth.toml -o models/mouth
    """
    from phonanim.training.mouth import train_mouth

    with console.progress(config.stem) as progress:
        folder = train_mouth(config, output, progress)
    console.print(f"wrote {folder}; draw with `phonanim mouth draw --model {folder}`")
    console.print_result({"mouth": str(folder)})


@command.command()
@click.argument("alignment", type=FILE)
@click.option(
    "--model",
    required=True,
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="The trained mouth.",
)
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False, path_type=Path))
@click.option("--fps", type=Number(1, 120), default=25.0, help="Frames per second of the film.")
@click.option("--audio", type=FILE, help="The recording, for the film's sound.")
@click.option("--scale", type=Number(0.5, 8), default=3.0, help="Size relative to the reference.")
@console_options
def draw(
    alignment: Path, model: Path, output: Path, fps: float, audio: Path | None, scale: float, console: Console
) -> None:
    """Render the mouth for an alignment: a film (.mp4), or a strip with one picture per phone (.png).

    \b
    Examples:
      phonanim mouth draw line.TextGrid --model models/mouth -o line.mp4 --audio line.wav
      phonanim mouth draw line.TextGrid --model models/mouth -o line.png
    """
    from phonanim.errors import OutputError
    from phonanim.inputs.alignment import read_alignment
    from phonanim.media.pixels import write_png
    from phonanim.speech.language import to_phones
    from phonanim.training.mouth import load_mouth, strip, write_mouth_film

    if output.suffix not in (".mp4", ".png"):
        raise OutputError(f"{output}: a mouth is drawn as .mp4 or .png; choose one of them")
    mouth = load_mouth(model)
    track = to_phones(read_alignment(alignment))[0]
    if output.suffix == ".png":
        write_png(strip(mouth, track, scale), output)
    else:
        with console.progress("film") as progress:
            write_mouth_film(mouth, track, output, fps, audio, scale, progress)
    console.print(f"wrote {output}")
    console.print_result({"output": str(output)})
