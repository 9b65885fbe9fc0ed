"""`phonanim edit`: keep an animator's edits in a file of their own."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.commands._numbers import Number

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.group()
def command() -> None:
    """Keep edits of an animation, to apply them when its line is made again.

    \b
    Example:
      phonanim edit diff line.json edited.json -o line.edits.json
    """


@command.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="File of edits to write.",
)
@console_options
def join(files: tuple[Path, ...], output: Path, console: Console) -> None:
    """Join edits of one line that were made in several tools or on several rigs.

    All become edits of the rig and of the phones of the first file.

    \b
    Example:
      phonanim edit join blender.edits.json maya.edits.json -o line.edits.json
    """
    from phonanim.animation.edit_file import read_edits, write_edits
    from phonanim.commands._outputs import check_outputs
    from phonanim.correcting import join_edits

    check_outputs([output], files)
    joined, notes = join_edits([read_edits(file) for file in files])
    write_edits(joined, output)
    console.print(f"wrote {output}: {len(joined.edits)} edits of the rig {joined.rig}")
    for note in notes:
        console.print(note)
    console.print_result({"output": str(output), "edits": len(joined.edits), "notes": list(notes)})


@command.command()
@click.argument("base", type=FILE)
@click.argument("edited", type=FILE)
@click.option(
    "-o",
    "--output",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="File of edits to write.",
)
@click.option(
    "--replace", is_flag=True, help="Keep the edited curves themselves, not their differences from BASE."
)
@click.option(
    "--error",
    type=Number(1e-6, 1),
    default=1e-3,
    help="Allowed distance from EDITED; smaller differences are ignored.",
)
@click.option("--alignment", type=FILE, help="Alignment of BASE, for edits to follow its phones.")
@console_options
def diff(
    base: Path,
    edited: Path,
    output: Path,
    replace: bool,
    error: float,
    alignment: Path | None,
    console: Console,
) -> None:
    """Write the differences from BASE to EDITED, two animations of one line.

    Any format that can be read back is accepted. In formats that hold the phones, such as JSON and NPZ, an
    edit follows its phones when the line is aligned again; for others, give --alignment.

    \b
    Examples:
      phonanim edit diff line.json edited.json -o line.edits.json
      phonanim edit diff line.json edited.csv -o line.edits.json --replace
      phonanim edit diff line.anim maya.anim --alignment line.TextGrid -o line.edits.json
    """
    from phonanim.animation.edit_file import write_edits
    from phonanim.animation.edits import diff_animations as find
    from phonanim.commands._outputs import check_outputs
    from phonanim.exporters import load
    from phonanim.inputs.alignment import read_alignment

    check_outputs([output], [base, edited, *filter(None, [alignment])])
    before, after = load(base), load(edited)
    if alignment is not None:
        before = dataclasses.replace(before, phones=read_alignment(alignment).intervals)
    edits = find(before, after, "replace" if replace else "offset", error)
    write_edits(edits, output)
    channels = len({edit.channel for edit in edits.edits})
    keys = sum(len(edit.times) for edit in edits.edits)
    console.print(
        f"wrote {output}: {len(edits.edits)} edits of {channels} channels, {keys} keys, error {error:g}"
    )
    for path, take in ((base, before), (edited, after)):
        for note in take.provenance.get("notes", ()) if path.suffix == ".anim" else ():
            console.print(f"{path}: {note}")
    if not edits.phones:
        console.print(
            "neither file holds phones, so the edits cannot follow them; they keep their times, "
            "unless you give --alignment"
        )
    console.print_result(
        {"output": str(output), "edits": len(edits.edits), "channels": channels, "keys": keys}
    )
