"""`phonanim evaluate`: score the output of any tool against a reference."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._lips_read import find_alignment, read_lips
from phonanim.commands._maps import start_maps
from phonanim.commands._score_report import build_report
from phonanim.commands._score_tables import score_table, summary_table

if TYPE_CHECKING:
    from phonanim.evaluation.predictions import Motion
    from phonanim.evaluation.scoring import Scores
    from phonanim.evaluation.surfaces import Settings
    from phonanim.speech.phones import PhoneTrack

PATH = click.Path(exists=True, path_type=Path)
OUT = click.Path(dir_okay=False, path_type=Path)
FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command()
@click.argument("predictions", type=PATH)
@click.option("--reference", type=PATH, help="The reference: a file or a folder.")
@click.option("--mask", "masks", multiple=True, metavar="[REGION=]FILE", help="Vertices of a region.")
@click.option("--alignment", type=PATH, help="Alignment file, or a folder of them matched by stem.")
@click.option(
    "--language",
    default="auto",
    help="Label set of the alignment, or of the labels of sensors; with --lips-read: of the words.",
)
@click.option("--axes", help="Directions of x, y and z of sensors in EMU bundles, such as left,back,up.")
@click.option("--template", type=PATH, help="The mesh at rest, or a folder or .pkl of one per subject.")
@click.option("--reference-template", type=PATH, help="Mesh at rest of the reference, if it is another face.")
@click.option("--sound", type=PATH, help="Sound of the line, or a folder matched by stem: adds SLCC.")
@click.option("--lips", help="Four vertices of the mesh: upper lip, lower lip, right and left corner.")
@click.option(
    "--unit",
    type=click.Choice(["m", "cm", "mm"]),
    help="Unit of vertices; detected from the size by default.",
)
@click.option("--fps", metavar="RATE", help="Rate of a .npy of predictions (default 30).")
@click.option("--reference-fps", metavar="RATE", help="Rate of a .npy of references (default --fps).")
@click.option("--heat", type=OUT, help="Also draw the error of each vertex or curve, as PNG (extra plots).")
@click.option("--motion-map", type=OUT, help="Also draw how much each vertex or curve moves, as PNG.")
@click.option("--lips-read", type=FILE, metavar="NETWORK", help="Read words from the lips (TorchScript).")
@click.option(
    "--words", type=FILE, metavar="LIST", help="The words that the network can recognize, one per line."
)
@console_options
def command(
    predictions: Path,
    reference: Path | None,
    masks: tuple[str, ...],
    alignment: Path | None,
    language: str,
    axes: str | None,
    template: Path | None,
    reference_template: Path | None,
    sound: Path | None,
    lips: str | None,
    unit: str | None,
    fps: str | None,
    reference_fps: str | None,
    heat: Path | None,
    motion_map: Path | None,
    lips_read: Path | None,
    words: Path | None,
    console: Console,
) -> None:
    """Score PREDICTIONS of any tool against a reference, file by file or folder by folder.

    Reads curves (.npz .json .csv .glb .usda .track.json) and vertices or controls (.npy in the layouts of
    VOCA, FaceFormer, CodeTalker and FaceDiffuser). ARKit curves are also scored in millimetres on the shipped
    head. The reference may be articulography (*_bndl.json, .npz of sensors, or a folder of these), which
    scores the articulation of a take. docs/measures.md defines each measure.

    \b
    Examples:
      phonanim evaluate line.npz --reference capture.csv --alignment line.TextGrid
      phonanim evaluate ofx.track.json --reference capture.glb --json
      phonanim evaluate line.npz --reference ema/line_bndl.json
      phonanim evaluate line.npz --lips-read network.pt --words words.txt
      phonanim evaluate out/ --reference vertices_npy/ --mask lips=lve.txt --mask upper=fdd.txt --fps 25
      phonanim evaluate out/ --reference vertices_npy/ --fps 25 --heat heat.png --motion-map motion.png
    """
    given = {"mask": masks, "template": template, "reference_template": reference_template, "lips": lips}
    given |= {"unit": unit, "sound": sound, "heat": heat, "fps": fps, "reference_fps": reference_fps}
    given |= {"motion_map": motion_map}
    if words and not lips_read:
        raise click.UsageError("--words is the list of a network: name it with --lips-read NETWORK")
    if lips_read:
        if not words:
            raise click.UsageError("--lips-read needs the words that the network can recognize: --words LIST")
        check_unused("--lips-read, which reads pictures", **given, axes=axes)
        with console.progress("reading lips") as progress:
            found = read_lips(predictions, reference, alignment, lips_read, words, language, progress)
        console.print_result(*found)
        return
    if not reference:
        raise click.UsageError("Missing option '--reference'.")
    from phonanim.animation.rates import parse_rate
    from phonanim.ema.scoring import is_articulography
    from phonanim.evaluation.predictions import pair_files, read_templates
    from phonanim.evaluation.surfaces import Settings
    from phonanim.face.masks import parse_masks

    maps = start_maps(heat, motion_map)
    own = parse_rate(fps) if fps else None
    rates = own, parse_rate(reference_fps) if reference_fps else own
    settings = Settings(
        masks=parse_masks(masks),
        lips=_four(lips) if lips else (),
        unit=unit,
    )
    rests = tuple(read_templates(path) if path else None for path in (template, reference_template))
    diversities: list[dict[str, float]] = []
    with console.progress("scoring") as progress:
        if is_articulography(reference):
            check_unused("sensors of articulography", **given, alignment=alignment)
            rows = score_sensors(predictions, reference, language, axes)
        else:
            check_unused("a reference without sensors", axes=axes)
            pairs = pair_files(predictions, reference)
            rows, diversities = score_all(
                pairs, rates, settings, rests, alignment, language, progress, maps.add
            )
            if sound:
                add_levels(rows, pairs, sound)
    maps.draw(unit)
    facts = build_report(rows, diversities)
    for note in dict.fromkeys(note for scores in rows.values() for note in scores.notes):
        console.print(f"note: {note}")
    console.print_result(
        facts, "\n".join(score_table(rows, facts) if len(rows) == 1 else summary_table(rows, facts))
    )


def score_sensors(
    predictions: Path, reference: Path, language: str = "auto", axes: str | None = None
) -> dict[str, Scores]:
    """The scores of articulation against sensors, by file; files of a folder go by the recordings' names."""
    from phonanim.ema.scoring import find_recordings, recording_of, score_recording
    from phonanim.errors import EvaluationError, PhonanimError
    from phonanim.evaluation.predictions import line_name, motions_of, read_motion

    recordings = find_recordings(reference, language, axes)
    paths = [predictions]
    if predictions.is_dir():
        paths = [path for path in motions_of(predictions) if line_name(path) in recordings]
    if not paths:
        raise EvaluationError(
            f"{predictions}: no file has the name of a recording in {reference}; rename them"
        )
    rows = {}
    for path in paths:
        try:
            rows[path.name] = score_recording(read_motion(path), recording_of(path, recordings, reference))
        except PhonanimError as error:
            raise type(error)(f"{path} against {reference}: {error}") from error
    return rows


def score_all(
    pairs: list[tuple[Path, Path]],
    rates: tuple[float | None, float | None],
    settings: Settings,
    rests: tuple[dict[str, Any] | None, ...],
    alignment: Path | None,
    language: str,
    progress: Any,
    see: Callable[[Motion, Motion], None] = lambda predicted, captured: None,
) -> tuple[dict[str, Scores], list[dict[str, float]]]:
    """The scores of every prediction by name, and the diversity of each line that has several.

    `see` gets the two sides of each.
    """
    from phonanim.errors import PhonanimError
    from phonanim.evaluation.evaluate import evaluate
    from phonanim.evaluation.predictions import read_motion, template_of
    from phonanim.evaluation.scoring import takes_diversity

    rows: dict[str, Scores] = {}
    takes: dict[Path, list[Any]] = {}
    for done, (mine, theirs) in enumerate(pairs, start=1):
        track = load_phones(alignment, mine, language) if alignment else None
        own, other = (
            template_of(known, path) if known else None
            for known, path in zip(rests, (mine, theirs), strict=True)
        )
        predicted = read_motion(mine, rates[0], own)
        captured = read_motion(theirs, rates[1], own if other is None else other)
        try:
            rows[mine.name] = evaluate(
                predicted,
                captured,
                alignment=track,
                masks=settings.masks,
                lips=settings.lips,
                template=own,
                reference_template=other,
                unit=settings.unit,
            )
            see(predicted, captured)
        except PhonanimError as error:
            raise type(error)(f"{mine} against {theirs}: {error}") from error
        takes.setdefault(theirs, []).append(predicted)
        progress(done / len(pairs))
    found = (takes_diversity(group, settings) for group in takes.values() if len(group) > 1)
    return rows, [values for values in found if values]


def add_levels(rows: dict[str, Scores], pairs: list[tuple[Path, Path]], sound: Path) -> None:
    """Add the level of each line's speech, `speech_level_db`. Raises EvaluationError, AudioError."""
    from phonanim.evaluation.levels import find_sound, speech_level

    for mine, _ in pairs:
        rows[mine.name].measures["speech_level_db"] = speech_level(find_sound(sound, mine))


def check_unused(scored: str, **given: Any) -> None:
    """Raise UsageError when an option was given that a way of scoring does not read."""
    unused = [f"--{name.replace('_', '-')}" for name, value in given.items() if value]
    if unused:
        raise click.UsageError(f"{' and '.join(unused)} cannot be used with {scored}; leave it out")


def load_phones(alignment: Path, prediction: Path, language: str) -> PhoneTrack:
    """The phones of a line, from a file or from the one of its stem in a folder. Raises EvaluationError."""
    from phonanim.inputs.alignment import read_alignment
    from phonanim.speech.language import to_phones

    return to_phones(read_alignment(find_alignment(alignment, prediction)), language)[0]


def _four(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(word) for word in text.split(","))
    except ValueError as error:
        raise click.BadParameter(
            f"{text!r} is not four vertex numbers such as 3531,3504,2827,1710"
        ) from error
