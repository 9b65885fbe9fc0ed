"""`phonanim corpus`: make training corpora from recordings."""

from __future__ import annotations

from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._corpus_score import score
from phonanim.commands._films import appearance, track
from phonanim.commands._numbers import Number
from phonanim.commands._stereo import reconstruct

if TYPE_CHECKING:
    from phonanim.corpus.motion import MotionCorpus


@click.group()
def command() -> None:
    """Make training corpora, and list data sets.

    \b
    Example:
      phonanim corpus build recordings/grid_s1 -o work/corpus
    """


command.add_command(track)
command.add_command(appearance)
command.add_command(reconstruct)
command.add_command(score)


@command.command()
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder."
)
@click.option("--dataset", help="Read RECORDINGS as this data set, one of `corpus datasets`.")
@click.option("--every", type=click.IntRange(1), help="With --dataset: keep every N-th frame.")
@click.option(
    "--template",
    type=click.Path(exists=True, path_type=Path),
    help="Faces at rest of a data set of vertices: a folder or a .pkl of one per subject.",
)
@click.option(
    "--mesh",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="The mesh of a data set of vertices, for its triangles (.obj .ply).",
)
@click.option("--language", default="auto", help="Label set of a data set's phones.")
@click.option("--axes", default="forward,left,up", help="Directions of x, y and z of sensors in the files.")
@click.option("--rate", type=Number(10, 2000), help="Rate of sensors in the corpus, hertz (50).")
@console_options
def build(
    recordings: Path,
    output: Path,
    dataset: str | None,
    every: int | None,
    template: Path | None,
    mesh: Path | None,
    language: str,
    axes: str,
    rate: float | None,
    console: Console,
) -> None:
    """Write a training corpus of a folder: of tracked films, of a data set, or of articulography.

    Films are what `corpus track` writes: clips.csv, landmarks.npz, textgrid/ and audio/. A data set is what
    `corpus import` wrote, or with --dataset its owners' own layout. Articulography is what `ema report`
    reads, or .npz of sensors. docs/targets.md describes such corpora.

    \b
    Examples:
      phonanim corpus build recordings/grid_s1 -o work/corpus
      phonanim corpus build work/vocaset -o work/vocaset --template templates.pkl
      phonanim corpus build facegood/ --dataset facegood -o work/facegood
      phonanim corpus build ema_de/ -o work/ema_de
    """
    if holds_sensors(recordings, dataset):
        if dataset:
            import_sensors(dataset, recordings, output, every or 1, console)
            recordings = output
        facts = build_sensors(recordings, output, axes, rate, language, console)
    elif dataset or (recordings / "dataset.json").is_file():
        facts = build_motion(recordings, output, dataset, every, (template, mesh), language, console)
    elif template or every or mesh:
        raise click.UsageError("--template, --mesh and --every are for data sets; leave them out")
    else:
        facts = build_landmarks(recordings, output, console)
    counted = ", ".join(f"{value} {name}" for name, value in facts.items() if isinstance(value, int))
    console.print(f"wrote {output}: {counted}")
    for note in facts.get("guessed", ()):
        console.print(note)
    console.print_result(facts)


def holds_sensors(folder: Path, dataset: str | None) -> bool:
    """Whether a folder has sensors: articulography as it is recorded, or an imported data set of it."""
    from phonanim.corpus.motion_build import read_imported
    from phonanim.datasets import load_dataset
    from phonanim.ema.scoring import is_articulography

    if dataset:
        return load_dataset(dataset).CARD.kind == "sensors"
    if (folder / "clips.csv").is_file():
        return False
    if (folder / "dataset.json").is_file():
        return bool(read_imported(folder)[0]["kind"] == "sensors")
    recorded = any(path.suffix.lower() in (".pos", ".mat") for path in folder.iterdir())
    return recorded or is_articulography(folder)


def import_sensors(dataset: str, folder: Path, output: Path, every: int, console: Console) -> None:
    """Import a data set of sensors into the folder of its corpus."""
    from phonanim.corpus.importing import import_dataset

    with console.progress(dataset) as progress:
        import_dataset(dataset, folder, output, every, progress=progress)


def build_sensors(
    folder: Path, output: Path, axes: str, rate: float | None, language: str, console: Console
) -> dict[str, Any]:
    """Build a corpus of sensors, and return what it has."""
    from phonanim.ema.corpus import RATE, build_sensor_corpus
    from phonanim.ema.report import Preparation

    preparation = Preparation(axes=axes, rate=rate or RATE)
    with console.progress(folder.name) as progress:
        found = build_sensor_corpus(folder, output, preparation, language, progress)
    for name, why in found.left_out.items():
        console.print(f"left out {name}: {why}")
    return describe_corpus(found.corpus, output) | {"sensors": len(found.corpus.source.names)}


def build_landmarks(recordings: Path, output: Path, console: Console) -> dict[str, Any]:
    """Build a corpus of landmarks, and return what it has."""
    from phonanim.corpus.corpus import build_corpus

    with console.progress("corpus") as progress:
        corpus = build_corpus(recordings, output, progress)
    return {
        "corpus": str(output),
        "clips": len(corpus.clips),
        "frames": int(corpus.frames.sum()),
        "fps": corpus.fps,
        "landmarks": len(corpus.indices),
    }


def build_motion(
    recordings: Path,
    output: Path,
    dataset: str | None,
    every: int | None,
    faces: tuple[Path | None, Path | None],
    language: str,
    console: Console,
) -> dict[str, Any]:
    """Build a corpus of controls, sensors or vertices, and return what it has.

    `faces` are the files of faces at rest and of the mesh.
    """
    from phonanim.corpus.motion_build import build_from_dataset, build_motion_corpus
    from phonanim.evaluation.predictions import read_templates
    from phonanim.rig.mesh_file import read_mesh

    rests = read_templates(faces[0]) if faces[0] else None
    triangles = read_mesh(faces[1])[1] if faces[1] else None
    with console.progress(dataset or "corpus") as progress:
        if dataset:
            corpus = build_from_dataset(
                dataset, recordings, output, every or 1, rests, language, triangles, progress
            )
        elif every:
            raise click.UsageError("--every is for --dataset; give it to phonanim corpus import")
        else:
            corpus = build_motion_corpus(recordings, output, rests, language, triangles)
    return describe_corpus(corpus, output)


def describe_corpus(corpus: MotionCorpus, output: Path) -> dict[str, Any]:
    """The facts of a corpus of controls, sensors or vertices."""
    from collections import Counter

    splits = Counter(clip.split for clip in corpus.clips)
    width = prod(corpus.frames(0).shape[1:])
    return {
        "corpus": str(output),
        "kind": corpus.kind,
        "clips": len(corpus.clips),
        "frames": sum(clip.frames for clip in corpus.clips),
        "fps": corpus.fps,
        "seconds": round(sum(clip.frames for clip in corpus.clips) / corpus.fps, 1),
        "numbers a frame": width,
        "subjects": len({clip.subject for clip in corpus.clips}),
        "aligned clips": sum(clip.aligned for clip in corpus.clips),
        "splits": dict(splits),
        "guessed": list(corpus.provenance.get("guessed", ())),
    }


@command.command()
@click.argument("name", required=False)
@console_options
def datasets(name: str | None, console: Console) -> None:
    """List the third-party data sets that can be read, or describe one.

    \b
    Examples:
      phonanim corpus datasets
      phonanim corpus datasets biwi
    """
    from dataclasses import asdict

    from phonanim.datasets import dataset_names, load_dataset

    cards = {one: load_dataset(one).CARD for one in ([name] if name else dataset_names())}
    facts = {one: asdict(card) for one, card in cards.items()}
    if name:
        listing = "\n".join(f"{field:<8} {text}" for field, text in facts[name].items() if text)
    else:
        listing = "\n".join(
            f"{one:<10} {card.kind:<9} {card.title}: {card.content}" for one, card in cards.items()
        )
    console.print_result(facts, listing)


@command.command("import")
@click.argument("name")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder."
)
@click.option("--every", type=click.IntRange(1), default=1, help="Keep every N-th frame.")
@click.option(
    "--split",
    "splits",
    multiple=True,
    type=click.Choice(["train", "validation", "test", "test_b"]),
    help="Import only these; all by default.",
)
@console_options
def import_(
    name: str, folder: Path, output: Path, every: int, splits: tuple[str, ...], console: Console
) -> None:
    """Convert a third-party data set to one layout: arrays, WAV, TextGrids and a table.

    NAME is one of `phonanim corpus datasets`. FOLDER has the layout that its owners publish.

    \b
    Example:
      phonanim corpus import vocaset vocaset/ -o work/vocaset --every 2
    """
    from collections import Counter

    from phonanim.corpus.importing import import_dataset

    with console.progress(name) as progress:
        rows = import_dataset(name, folder, output, every, splits, progress)
    counts = Counter(row["split"] or "no split" for row in rows)
    text = ", ".join(f"{count} {split}" for split, count in sorted(counts.items()))
    console.print(f"wrote {output}: {len(rows)} recordings ({text})")
    console.print_result({"dataset": name, "output": str(output), "recordings": len(rows), "splits": counts})
