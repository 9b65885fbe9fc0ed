"""`phonanim batch`: animate many alignments; an interrupted run can be resumed."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from phonanim.commands import Console, console_options
from phonanim.commands._export import RUN_NAMES, export_options, option_spelling
from phonanim.commands._options import animation_options
from phonanim.commands._run_file import KeptCommand, keep_arguments

if TYPE_CHECKING:
    from phonanim.articulation.styles import ChosenStyle
    from phonanim.dubbing.lines import Lines
    from phonanim.dubbing.row import Common
    from phonanim.dubbing.run import Engine
    from phonanim.dubbing.storage import Place
    from phonanim.options import Options

SOME_FAILED = 1


@click.command(cls=KeptCommand)
@click.argument("source")
@click.option("-o", "--output", "folder", required=True, help="Output folder, by path or URL.")
@click.option(
    "--format",
    "formats",
    multiple=True,
    default=["csv"],
    help="Suffix of the outputs; `phonanim info` lists them. Repeatable.",
)
@animation_options
@click.option(
    "--styles",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="TOML with the styles that a table names; phonanim's own by default.",
)
@click.option(
    "--characters",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="TOML or CSV with the characters that a table names: rig, mesh, style, language, voice.",
)
@export_options
@RUN_NAMES
@click.option(
    "--edits", metavar="FOLDER", help="Folder of an animator's edits, with OUTPUT.edits.json for each line."
)
@click.option("--workers", type=click.IntRange(1, 512), help="Number of processes; one per core by default.")
@click.option(
    "--engine",
    type=click.Choice(["processes", "dask"]),
    default="processes",
    help="Where to run: processes of this machine, or a dask cluster.",
)
@click.option("--scheduler", help="Address of the dask scheduler, such as tcp://10.0.0.1:8786.")
@click.option("--verify", is_flag=True, help="Read every file again, also those of the same size and time.")
@click.option("--dry-run", is_flag=True, help="Report what would be made, and write nothing.")
@click.option("--verbose", "-v", is_flag=True, help="Print every line, not only lines with problems.")
@console_options
def command(
    source: str,
    folder: str,
    formats: tuple[str, ...],
    options: Options,
    styles: Path | None,
    characters: Path | None,
    styled: ChosenStyle,
    exports: dict[str, object],
    names: Path | None,
    edits: str | None,
    workers: int | None,
    engine: str,
    scheduler: str | None,
    verify: bool,
    dry_run: bool,
    verbose: bool,
    console: Console,
) -> int:
    """Animate many lines: a folder, a pattern in quotes, or a table.

    A table (.csv .tsv .jsonl) has a column `alignment`, or `audio` and `text`, or `text` alone, which is
    spoken by eSpeak NG with the `voice` or the `language` of the row (phonanim[espeak]). It may have id,
    output, character, edits, timecode and style, and the options rig, model, language, tier, speaker,
    lexicon, fps, unknown, unit, offset, intensity, jaw, lips, rounding, quickness, reduction, hold,
    loudness, level, pitch, gain, smooth and overlay. Paths may be URLs (s3://...). A line whose inputs
    did not change is kept. A line that fails does not stop the others, but makes the exit code 1. The
    output folder also gets report.html, report.json, summary.txt and ledger.jsonl. With --json every line
    prints an event on stdout.

    \b
    Examples:
      phonanim batch lines/ -o curves/ --format csv --rig arkit
      phonanim batch 'takes/**/*.TextGrid' -o out/ --format glb --format npz --workers 4
      phonanim batch script.csv -o out/ --format glb --character hero.glb --edits edits/
      phonanim batch s3://show/script.csv -o s3://show/out --engine dask --scheduler tcp://10.0.0.1:8786
      phonanim batch script.csv -o out/ --characters show.toml --format metahuman.csv --format curves.usda
      phonanim batch script.csv -o out/ --format glb --character hero.glb --names hero.csv
      phonanim batch script.csv -o out/ --dry-run
    """
    from phonanim.commands._batch_report import RunReporter, report_dry_run
    from phonanim.dubbing.run import run

    lines, target, formats = plan_lines(
        source, folder, formats, options, styles, characters, styled, exports, edits, console, names
    )
    if dry_run:
        return SOME_FAILED if report_dry_run(lines, target, formats, console, verbose) else 0
    for note in lines.notes:
        console.print(note)
    started = time.monotonic()
    with console.progress(source) as progress:
        reporter = RunReporter(len(lines.lines), console, progress, verbose)
        chosen = choose_engine(engine, scheduler, workers)
        outcomes = run(lines, target, formats, chosen, reporter.tell, verify)
        keep_arguments(target)
    failed = reporter.finish(outcomes, target / "report.html", time.monotonic() - started)
    return SOME_FAILED if failed else 0


def plan_lines(
    source: str,
    folder: str,
    formats: tuple[str, ...],
    options: Options,
    styles: Path | None,
    characters: Path | None,
    styled: ChosenStyle,
    exports: dict[str, object],
    edits: str | None,
    console: Console,
    names: Path | None = None,
    **others: object,
) -> tuple[Lines, Place, tuple[str, ...]]:
    """The lines of a run, its output folder and its formats, by the options of the command."""
    from phonanim.articulation.styles import read_styles
    from phonanim.dubbing.characters import read_characters
    from phonanim.dubbing.lines import read_lines
    from phonanim.dubbing.reserve import reserve_outputs
    from phonanim.dubbing.row import Common
    from phonanim.dubbing.storage import parse_place
    from phonanim.exporters import option_names
    from phonanim.rig.names import read_name_table

    formats = tuple(dict.fromkeys(name.lower().lstrip(".") for name in formats))
    check_options(formats, options, exports)
    options = fit_character(options, exports, console)
    target = parse_place(folder)
    meshes = any("character" in option_names(Path(f"line.{name}")) for name in formats)
    common = Common(
        options,
        read_styles(styles),
        exports,
        parse_place(edits) if edits else None,
        target.absolute(),
        styled,
        read_characters(characters, meshes),
        read_name_table(names) if names else None,
    )
    return reserve_outputs(read_lines(source, with_absolute_paths(common)), target, formats), target, formats


def fit_character(options: Options, exports: dict[str, object], console: Console) -> Options:
    """The options with the rig of the character of all lines; says once what it leaves unmoved."""
    from phonanim.commands._chosen_rig import with_own_rig
    from phonanim.commands._outputs import shown_character
    from phonanim.pipeline import load_cached_rig
    from phonanim.rig.coverage import coverage_notes

    character = shown_character(exports)
    if character is None:
        return options
    options = with_own_rig(options, character, console)
    for note in coverage_notes(character, options.rig, load_cached_rig(options.rig).controls):
        console.print(note)
    return options


def with_absolute_paths(common: Common) -> Common:
    """The same with absolute paths, for remote workers. Raises OptionError where an overlay is missing."""
    from phonanim.animation.overlay import find_overlay, is_pose
    from phonanim.dubbing.row import resolve_files

    options = common.options
    overlays = (
        one if is_pose(one.source) else replace(one, source=str(find_overlay(one.source).absolute()))
        for one in options.overlays
    )
    lexicon = str(Path(options.lexicon).absolute()) if options.lexicon else None
    found = resolve_files(Path(), {"rig": options.rig, "model": options.model})
    return replace(
        common,
        options=replace(options, overlays=tuple(overlays), lexicon=lexicon, **found),
        exports={name: v.absolute() if isinstance(v, Path) else v for name, v in common.exports.items()},
    )


def check_options(formats: tuple[str, ...], options: Options, exports: dict[str, object]) -> None:
    """Raise at once what would fail every line: an unknown format, model or rig, an unused option."""
    from phonanim.errors import OptionError
    from phonanim.exporters import assign_options
    from phonanim.pipeline import load_cached_rig, load_model

    _, idle = assign_options(exports, [Path(f"line.{name}") for name in formats])
    if idle:
        raise OptionError(f"{option_spelling(idle[0])} does nothing for {', '.join(formats)}; leave it out")
    load_model(options.model)
    load_cached_rig(options.rig)


def choose_engine(engine: str, scheduler: str | None, workers: int | None) -> Engine:
    """The engine that the options ask for. Raises OptionError."""
    from phonanim.dubbing.make import make_line
    from phonanim.errors import OptionError

    if engine == "processes":
        from phonanim.core.threads import count_cores
        from phonanim.dubbing import processes

        return partial(processes.run_jobs, task=make_line, workers=workers or count_cores())
    if not scheduler:
        raise OptionError("--engine dask needs the address of a running cluster: --scheduler tcp://HOST:8786")
    from phonanim.dubbing import cluster

    return partial(cluster.run_jobs, task=make_line, scheduler=scheduler)
