"""`phonanim ema`: measure tongue, jaw and lips in electromagnetic articulography."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._numbers import Number
from phonanim.commands._renamed import renamed_option

if TYPE_CHECKING:
    from phonanim.ema.posture import Posture

FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)
FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
PLATE = 3  # sensors


@click.group()
def command() -> None:
    """Measure recordings of electromagnetic articulography.

    \b
    Example:
      phonanim ema report recordings/ -o report/
    """


@command.command()
@click.argument("folder", type=FOLDER)
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder."
)
@click.option("--axes", default="forward,left,up", help="Directions of x, y and z in the files.")
@click.option("--names", help="Sensors of the channels in order, separated by commas; - skips one.")
@click.option("--reference", help="Sensors on the skull, separated by commas: remove head motion by them.")
@renamed_option(
    "--bite-plate",
    "--bite",
    type=FILE,
    help="A recording with a plate between the teeth: rotate to its plane.",
)
@click.option("--plate", default="front,left,right", help="Sensors of the plate, separated by commas.")
@click.option("--origin", default="", help="Sensor of the plate's recording that becomes the origin.")
@click.option("--rate", type=Number(10, 2000), help="Resample all recordings to this rate, in hertz.")
@click.option("--language", default="auto", help="Label set of the alignments.")
@renamed_option(
    "--min-examples",
    "--least",
    type=click.IntRange(1),
    default=1,
    help="Minimum number of examples of a pair of phones.",
)
@click.option("--plots/--no-plots", default=True, help="Also draw pictures.")
@console_options
def report(
    folder: Path,
    output: Path,
    axes: str,
    names: str | None,
    reference: str | None,
    bite: Path | None,
    plate: str,
    origin: str,
    rate: float | None,
    language: str,
    least: int,
    plots: bool,
    console: Console,
) -> None:
    """Measure the sensors in a FOLDER of recordings, and write tables, JSON and pictures.

    FOLDER holds EMU bundles (SSFF), Carstens .pos or MATLAB .mat files beside alignments of the same stem,
    or is what `phonanim corpus import` wrote. docs/ema.md explains each measure.

    \b
    Examples:
      phonanim ema report ema_de/ -o report/ --axes left,back,up --language german
      phonanim ema report pos/ -o report/ --names TD,TB,TT,-,LI,UL,LL,NA,EL,ER,-,- --reference NA,EL,ER
    """
    from phonanim.ema.figures import check_plots, draw_report
    from phonanim.ema.report import Preparation, make_report, report_summary, write_report
    from phonanim.ema.utterances import find_spoken

    if plots:
        check_plots()
    channels = _words(names)
    posture = _posture(folder, channels, _words(reference), bite, _words(plate), origin)
    preparation = Preparation(channels, axes, posture, rate)
    spoken = [one for one in find_spoken(folder) if bite is None or one.name != bite.stem]
    with console.progress(folder.name) as progress:
        found = make_report(spoken, preparation, language, least, progress)
    files = write_report(found, output) + (draw_report(found, output) if plots else [])
    for line in report_lines(found):
        console.print(line)
    console.print_result({**report_summary(found), "files": [str(output / name) for name in files]})


def report_lines(found: Any) -> list[str]:
    """The amount of data, and what was left out, in a few lines."""
    seconds = sum(one["seconds"] for one in found.recordings)
    gaps = [gap for one in found.recordings for gap in one["gaps"]]
    filled = sum(gap["filled"] for gap in gaps)
    lines = [
        f"{len(found.recordings)} recordings, {seconds:.1f} s, {len(found.phones)} phones, "
        f"{len(found.diphones)} pairs of phones"
    ]
    if gaps:
        lines.append(
            f"{len(gaps)} gaps in the sensors: {filled} filled, {len(gaps) - filled} too long and left out"
        )
    return lines


def _words(text: str | None) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",")) if text else ()


def _posture(
    folder: Path,
    names: tuple[str, ...],
    references: tuple[str, ...],
    bite: Path | None,
    plate: tuple[str, ...],
    origin: str,
) -> Posture | None:
    """The head at rest: from the recording of the plate, or from the folder's first recording."""
    from phonanim.ema.articulation import rename_sensors
    from phonanim.ema.posture import bite_posture, rest_posture
    from phonanim.ema.readers import read_articulation
    from phonanim.ema.utterances import find_spoken

    if not references:
        if bite:
            raise click.UsageError(
                "--bite-plate needs --reference: sensors on the skull that both recordings have"
            )
        return None
    raw = read_articulation(bite) if bite else find_spoken(folder)[0].sensors()
    named = rename_sensors(raw, names) if names else raw
    if bite is None:
        return rest_posture(named, references)
    if len(plate) != PLATE:
        raise click.UsageError(f"--plate names {len(plate)} sensors; give front, left and right")
    return bite_posture(named, references, (plate[0], plate[1], plate[2]), origin)
