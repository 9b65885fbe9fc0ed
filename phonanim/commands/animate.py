"""`phonanim animate`: animate one alignment and write animation files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from phonanim.commands import Console, console_options
from phonanim.commands._chosen_rig import with_own_rig, with_rig_of_format
from phonanim.commands._export import NAMES, export_options, output_notes
from phonanim.commands._line_source import find_source
from phonanim.commands._mesh import check_mesh_options, moves_mesh, write_mesh
from phonanim.commands._options import animation_options
from phonanim.commands._outputs import OUTPUT, check_outputs, describe, report_lines, show, write_outputs
from phonanim.commands._renamed import renamed_option
from phonanim.commands._takes import Sources, list_takes

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation
    from phonanim.options import Options

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
HEAD_RIG = "arkit_tongue"  # every control of the shipped head
SPOKEN = Path("speech.glb")  # default output of --text alone


@click.command()
@click.argument("alignment", type=FILE, required=False)
@click.option("-o", "--output", "outputs", type=OUTPUT, multiple=True, help="File to write. Repeatable.")
@animation_options
@click.option(
    "--text",
    help="The spoken text of the recording ALIGNMENT (phonanim[align]); without ALIGNMENT, what to speak "
    "(phonanim[espeak]).",
)
@click.option(
    "--voice", help="Language of --text as a voice of eSpeak NG, such as de; by default --language."
)
@click.option("--audio", type=FILE, help="The recording; by default the one beside the alignment.")
@click.option(
    "--features",
    type=click.Path(exists=True, dir_okay=False),
    help="Precomputed features of the recording (.npy), for a model trained on such.",
)
@click.option(
    "--takes",
    type=click.IntRange(1),
    default=1,
    help="Takes of a sampling model, one for each seed from --seed on.",
)
@click.option("--template", type=FILE, help="A face at rest (.npy .obj .ply), for a model of vertices.")
@click.option(
    "--edits",
    type=FILE,
    multiple=True,
    help="Edits to apply, of `phonanim edit diff`, or corrections of `phonanim review`. Repeatable.",
)
@renamed_option(
    "--contact-sheet", "--sheet", type=OUTPUT, help="Also draw a contact sheet of the face, as PNG."
)
@click.option("--view", is_flag=True, help="Open the animation in the browser.")
@export_options
@NAMES
@console_options
def command(
    alignment: Path | None,
    outputs: tuple[Path, ...],
    options: Options,
    text: str | None,
    voice: str | None,
    audio: Path | None,
    takes: int,
    template: Path | None,
    edits: tuple[Path, ...],
    sheet: Path | None,
    view: bool,
    exports: dict[str, object],
    console: Console,
) -> None:
    """Animate a rig from a phone alignment, or from a recording with an audio-driven model.

    The suffix of each output chooses its format. Without -o, the shipped head with its tongue
    (--rig arkit_tongue) is written as a GLB beside the alignment. `phonanim info` lists formats, rigs and
    languages.

    \b
    Examples:
      phonanim animate line.TextGrid
      phonanim animate line.TextGrid -o line.csv --rig arkit --fps 25
      phonanim animate line.TextGrid -o line.glb -o line.npz --contact-sheet line.png
      phonanim animate line.TextGrid -o line.glb --character mine.glb --key-tolerance 0.01
      phonanim animate line.TextGrid -o line.glb --edits line.edits.json
      phonanim animate line.TextGrid -o line.glb --life brows=0,head=0.5 --look-at 0.4,0,1.2
      phonanim animate line.TextGrid -o line.glb --emotion joy=0.4@1.2-3 --pitch praat
      phonanim animate speech.wav
      phonanim animate speech.wav --text "What is said."
      phonanim animate rede.wav --text "Guten Morgen." --voice de
      phonanim animate --text "Guten Morgen." --voice de -o morgen.glb
      phonanim animate speech.wav --model audio
      phonanim animate speech.wav --model models/facediffuser --takes 3 --steps 50
    """
    beside = outputs[0] if outputs else SPOKEN
    source, options, audio = find_source(alignment, text, voice, beside, audio, options, console)
    given, alignment = alignment or source, source
    if moves_mesh(options, template):
        check_mesh_options(edits, sheet, view, exports)
        write_mesh(alignment, outputs, options, takes, audio, template, console)
        return
    if not outputs:
        outputs = (given.with_suffix(".glb"),)
        if click.get_current_context().get_parameter_source("rig") is ParameterSource.DEFAULT:
            options = replace(options, rig=options.rig if "character" in exports else HEAD_RIG)
    if "character" in exports:
        options = with_own_rig(options, exports["character"], console)
    sources = Sources(alignment, audio, edits)
    planned = list(list_takes(takes, options, outputs, sheet))
    named = [path for _, files, pictured in planned for path in (*files, *filter(None, [pictured]))]
    check_outputs(named, sources.paths(options))
    made = []
    for settings, files, pictured in planned:
        if "character" not in exports:
            settings = with_rig_of_format(settings, files, console)
        animation, facts = write_take(sources, settings, files, pictured, exports, console)
        made.append(facts)
    if view:
        show(animation, files, console)
    elif files[0].suffix.lower() == ".glb":
        console.print(f"to see it: --view, or open {files[0]} in any glTF viewer")
    console.print_result({"takes": made} if takes > 1 else made[0])


def write_take(
    sources: Sources,
    options: Options,
    outputs: tuple[Path, ...],
    sheet: Path | None,
    exports: dict[str, object],
    console: Console,
) -> tuple[Animation, dict[str, Any]]:
    """Animate the line, write it and print what was done; -> the animation, and the result as data."""
    from phonanim.correcting import animate_corrected
    from phonanim.media.audio import find_audio

    audio = sources.audio or find_audio(sources.alignment)
    animation = animate_corrected(sources.alignment, options, audio, sources.edits).animation
    written = write_outputs(animation, outputs, sheet, exports)
    facts = describe(animation, sources.alignment, options, written)
    for line in (*report_lines(facts), *output_notes(animation, outputs, exports)):
        console.print(line)
    return animation, facts
