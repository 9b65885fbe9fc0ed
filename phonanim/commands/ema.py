"""`phonanim ema`: measure tongue, jaw and lips in electromagnetic articulography."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._renamed import renamed_option
from phonanim.commands._sensor_options import SensorOptions, sensor_options

FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)


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
@sensor_options
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
    sensors: SensorOptions,
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
    from phonanim.ema.report import make_report
    from phonanim.ema.report_files import report_summary, write_report
    from phonanim.ema.utterances import find_spoken

    if plots:
        check_plots()
    preparation = sensors.preparation(folder)
    spoken = [one for one in find_spoken(folder) if one.name != preparation.plate]
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
