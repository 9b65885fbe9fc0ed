"""`phonanim animate`: animate one alignment and write animation files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from phonanim.commands import Console, console_options
from phonanim.commands._export import NAMES, export_options, output_notes, save_outputs
from phonanim.commands._mesh import check_mesh_options, moves_mesh, write_mesh
from phonanim.commands._options import animation_options
from phonanim.commands._renamed import renamed_option
from phonanim.commands._takes import Sources, list_takes

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation
    from phonanim.options import Options

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
OUTPUT = click.Path(dir_okay=False, path_type=Path)
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
@click.option("--template", type=FILE, help="A face at rest (.npy), for a model of vertices.")
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
        check_mesh_options(takes, edits, sheet, view, exports)
        write_mesh(alignment, outputs, options, audio, template, console)
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


def find_source(
    alignment: Path | None,
    text: str | None,
    voice: str | None,
    beside: Path,
    audio: Path | None,
    options: Options,
    console: Console,
) -> tuple[Path, Options, Path | None]:
    """What to animate, which may have to be made first; how to read it; and the recording."""
    words = text is not None
    if alignment is not None and not words and needs_words(alignment, options):
        options = with_phones_recognized(alignment, voice, options, console)
        words = needs_words(alignment, options)
    if alignment is None or words:
        made, options, recording = make_alignment(alignment, text, voice, beside, options, console)
        return made, options, audio or recording
    return with_lines_aligned(alignment, audio, options, console)


def with_lines_aligned(
    alignment: Path, audio: Path | None, options: Options, console: Console
) -> tuple[Path, Options, Path | None]:
    """The alignment, how to read it, and the recording; of lines of text, one made of both."""
    from phonanim.media.audio import find_audio
    from phonanim.readers import LINES

    recording = audio or find_audio(alignment)
    if recording is None or alignment.suffix.lower() not in LINES:
        return alignment, options, audio
    from phonanim.commands._speech import align_subtitles

    path, settings = align_subtitles(alignment, recording, options, console)
    return path, settings, audio if path == alignment else recording


def needs_words(path: Path, options: Options) -> bool:
    """Whether a path is a recording whose words have to be found, because the model needs phones."""
    from phonanim.inputs.speech_input import is_recording
    from phonanim.pipeline import load_model

    return is_recording(path) and load_model(options.model).input_modality not in ("audio", "recognized")


def with_phones_recognized(recording: Path, voice: str | None, options: Options, console: Console) -> Options:
    """The options with the model that recognizes phones, where words cannot be recognized; a line says why.

    Only where no model was chosen: words need the extras `recognize` and `align`, and are English alone.
    """
    from phonanim.commands._speech import why_no_words
    from phonanim.core.catalog import RECOGNITION_MODEL

    if click.get_current_context().get_parameter_source("model") is not ParameterSource.DEFAULT:
        return options
    why = why_no_words(voice_of(voice, options))
    if not why:
        return options
    console.print(f"{recording}: {why}; so --model {RECOGNITION_MODEL} recognizes phones, many of them wrong")
    return replace(options, model=RECOGNITION_MODEL)


def voice_of(voice: str | None, options: Options) -> str | None:
    """The voice that is named, or that of the language; None for English."""
    from phonanim.speech.labels import load_language
    from phonanim.speech.language_names import is_auto

    code = None if is_auto(options.language) else load_language(options.language).code
    return voice or (None if code is None or code.startswith("en") else code)


def with_own_rig(options: Options, character: Any, console: Console) -> Options:
    """The options with the rig whose names a character has, unless one was chosen. Raises RigError."""
    from phonanim.rig.coverage import choose_rig

    if click.get_current_context().get_parameter_source("rig") is not ParameterSource.DEFAULT:
        return options
    rig, share = choose_rig(character)
    if rig == options.rig:
        return options
    console.print(
        f"{character}: has shapes for {share} of the rig {rig}, so it is used; --rig chooses another"
    )
    return replace(options, rig=rig)


def with_rig_of_format(options: Options, outputs: Sequence[Path], console: Console) -> Options:
    """The options with the one rig that every output's format needs, unless one was chosen."""
    from phonanim.exporters import needed_rig
    from phonanim.pipeline import load_cached_rig

    if click.get_current_context().get_parameter_source("rig") is not ParameterSource.DEFAULT:
        return options
    controls = load_cached_rig(options.rig).controls
    needed = {needed_rig(path, controls) for path in outputs}
    if len(needed) != 1 or needed == {""}:
        return options
    rig = needed.pop()
    console.print(f"{outputs[0]}: its format is of the rig {rig}, so it is used")
    return replace(options, rig=rig)


def make_alignment(
    recording: Path | None,
    text: str | None,
    voice: str | None,
    beside: Path,
    options: Options,
    console: Console,
) -> tuple[Path, Options, Path | None]:
    """The alignment of a recording, or of speech that is made from text; how to read it; and the recording.

    The words of a recording are its text, or recognized. Speech in another language than English is aligned,
    and text alone is spoken, with the voice, or with the voice of the language. Made speech and its alignment
    are written beside the first output. Raises click.UsageError when there is neither a recording nor text.
    """
    from phonanim.aligners.espeak import VOICE, reading_language
    from phonanim.commands._speech import align_recording, speak_text

    named = voice_of(voice, options)
    if recording is not None:
        path, language = align_recording(recording, text, named, console)
        return path, replace(options, language=language), recording
    if text is None:
        raise click.UsageError("give an ALIGNMENT, a recording, or --text")
    voice = named or VOICE
    return speak_text(text, voice, beside, console), replace(options, language=reading_language(voice)), None


def show(animation: Animation, outputs: Sequence[Path], console: Console) -> None:
    """Open the animation in the browser: the page among the outputs, or a temporary one."""
    import tempfile

    from phonanim.commands._view import open_page

    pages = [path for path in outputs if path.suffix.lower() in (".html", ".htm")]
    if not pages:
        folder = Path(tempfile.mkdtemp(prefix="phonanim-view-"))
        pages = [folder / f"{outputs[0].stem}.html"]
        animation.save(pages[0])
    open_page(pages[0], console)


def check_outputs(outputs: Sequence[Path], inputs: Sequence[Path]) -> None:
    """Raise OptionError when two outputs are the same file or an output would overwrite an input."""
    from phonanim.errors import OptionError

    taken = {path.resolve() for path in inputs}
    for path in outputs:
        if path.resolve() in taken:
            raise OptionError(f"{path}: is named twice, as input or output; give every file its own name")
        taken.add(path.resolve())


def write_outputs(
    animation: Animation, outputs: Sequence[Path], sheet: Path | None, exports: dict[str, object]
) -> list[Path]:
    """Check that every format is known, write every output, and return the paths."""
    from phonanim.exporters import find_exporter

    for path in outputs:
        find_exporter(path)
    if sheet:
        from phonanim.viewer.sheet import save_sheet

        save_sheet(animation, sheet, shown_character(exports))
    save_outputs(animation, outputs, exports, pictured=sheet is not None)
    return [*outputs, *filter(None, [sheet])]


def shown_character(exports: dict[str, object]) -> Path | None:
    """The character that pictures show, of the options of formats."""
    character = exports.get("character")
    return character if isinstance(character, Path) else None


def describe(animation: Animation, alignment: Path, options: Options, written: list[Path]) -> dict[str, Any]:
    """The result as data, for scripts."""
    from phonanim.speech.labels import is_silent

    frames, channels = animation.values.shape
    return {
        "alignment": str(alignment),
        "audio": str(animation.audio) if animation.audio else None,
        "phones": sum(not is_silent(phone.label) for phone in animation.phones),
        "frames": frames,
        "fps": animation.fps,
        "seconds": round((frames - 1) / animation.fps, 6),
        "channels": channels,
        "rig": animation.rig,
        "model": options.model,
        "language": animation.provenance.get("language"),
        "notes": animation.provenance["notes"],
        "outputs": [{"path": str(path), "bytes": path.stat().st_size} for path in written],
    }


def report_lines(facts: dict[str, Any]) -> list[str]:
    """The same as text: what was read, made and written, and which labels were replaced."""
    sound = f" with {facts['audio']}" if facts["audio"] not in (None, facts["alignment"]) else ""
    files = ", ".join(f"{output['path']} ({format_size(output['bytes'])})" for output in facts["outputs"])
    spoken = facts["language"]
    return [
        f"read {facts['alignment']}: {facts['phones']} phones in {facts['seconds']:.2f} s{sound}",
        *([describe_language(spoken)] if spoken else []),
        f"moved {facts['rig']} by {facts['model']}: {facts['frames']} frames at {facts['fps']:g} fps, "
        f"{facts['channels']} channels",
        f"wrote {files}",
        *facts["notes"],
    ]


def describe_language(facts: Mapping[str, Any]) -> str:
    """The language of the provenance in a line."""
    from phonanim.speech.reading import describe_language

    return describe_language(facts)


def format_size(count: int) -> str:
    """A number of bytes as text, in kB or MB."""
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.1f} kB"
