"""`phonanim corpus track` and `phonanim corpus appearance`: corpora from films of a speaking face."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.commands._numbers import Number

FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command()
@click.argument(
    "films", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option("-o", "--output", required=True, type=FOLDER, help="Folder for the recordings.")
@click.option(
    "--model",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Appearance model of this speaker; by default MediaPipe (phonanim[track]) finds the face.",
)
@click.option("--test", type=Number(0, 0.5), default=0.1, help="Share of the clips set aside for testing.")
@console_options
def track(films: tuple[Path, ...], output: Path, model: Path | None, test: float, console: Console) -> None:
    """Make recordings for a corpus from your own films of a speaking face.

    Each film needs its text (FILM.txt) or its alignment (FILM.TextGrid) beside it. `corpus build` reads the
    folder that this command writes; quality.txt in it rates each film and lists the rejected frames. A film
    that cannot be used is skipped and reported, and the exit code is 1.

    \b
    Examples:
      phonanim corpus track films/*.mp4 -o recordings && phonanim corpus build recordings -o corpus
      phonanim corpus track films/*.mp4 -o recordings --model corpus/appearance
    """
    from phonanim.corpus.recordings import make_recordings, report_text
    from phonanim.corpus.tracking import aam_tracker, mediapipe_tracker, shipped_indices

    tracker = aam_tracker(model) if model else mediapipe_tracker(shipped_indices())
    with console.progress("films") as progress:
        report = make_recordings(films, output, tracker, test, progress)
    for line in report_text(report):
        console.print(line)
    console.print(f"wrote {output}: {len(report.clips)} clips; make a corpus with `phonanim corpus build`")
    console.print_result(
        {
            "recordings": str(output),
            "clips": [clip.name for clip in report.clips],
            "rejected": [{"film": str(film.film), "why": film.why} for film in report.rejected],
        }
    )
    if report.rejected:
        click.get_current_context().exit(1)


@click.command()
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--corpus",
    "corpus_folder",
    required=True,
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="The corpus that was built from these recordings.",
)
@console_options
def appearance(recordings: Path, corpus_folder: Path, console: Console) -> None:
    """Learn an appearance model of the mouth, and write it into the folder of a corpus.

    The recordings hold mouth/*.mp4; clips.csv gives their position in the image (crop_x, crop_y).

    \b
    Example:
      phonanim corpus appearance recordings/grid_s1 --corpus work/corpus
    """
    from phonanim.corpus.pictures import build_appearance, reconstruction_error

    with console.progress("appearance") as progress:
        captured = build_appearance(recordings, corpus_folder, progress=progress)
    model, error = captured.model, reconstruction_error(captured)
    sizes = {
        name: len(part.std)
        for name, part in (("shape", model.face), ("outer", model.outer), ("inner", model.inner))
    }
    console.print(f"wrote {corpus_folder / 'appearance'}: {len(model.std)} joint modes of {sizes}")
    if error:
        console.print(
            f"what the model leaves of the test clips' pixels: {error['whole']:g} grey levels squared"
        )
    console.print_result(
        {"corpus": str(corpus_folder), "modes": sizes | {"joint": len(model.std)}, "pixel_mse": error}
    )
