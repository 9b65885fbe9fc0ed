"""`phonanim corpus build`: a training corpus of films, of a data set, or of articulography."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._sensor_options import SensorOptions, sensor_options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from phonanim.corpus.motion import MotionCorpus

ORDER = ("train", "validation", "test", "test_b", "unused")  # the last: recordings without a split


@dataclass(frozen=True)
class DataSet:
    """How a data set is read: its `name`, or "" for an imported one, and files beside it."""

    name: str
    every: int | None
    template: Path | None
    mesh: Path | None
    ignored: Path | None

    def given(self) -> list[str]:
        """The options that are given, but --dataset and --every."""
        found = {"template": self.template, "mesh": self.mesh, "ignore-vertices": self.ignored}
        return [f"--{name}" for name, value in found.items() if value]

    def ignored_vertices(self) -> NDArray[np.int64] | None:
        """The numbers of the vertices to leave out. Raises EvaluationError."""
        from phonanim.face.masks import read_mask

        return read_mask(self.ignored) if self.ignored else None


@click.command()
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "-o", "--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="Folder."
)
@click.option("--dataset", default="", help="Read RECORDINGS as this data set, one of `corpus datasets`.")
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
@click.option(
    "--ignore-vertices",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="With --dataset: a list of vertices to leave out, numbered from 0.",
)
@click.option("--language", default="auto", help="Label set of the phones.")
@sensor_options
@console_options
def build(
    recordings: Path,
    output: Path,
    dataset: str,
    every: int | None,
    template: Path | None,
    mesh: Path | None,
    ignore_vertices: Path | None,
    language: str,
    sensors: SensorOptions,
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
      phonanim corpus build uudamm/ --dataset uudamm --names ray.txt -o work/uudamm
      phonanim corpus build pos/ --names TD,TB,TT,-,LI,UL,LL,NA,EL,ER --reference NA,EL,ER -o work/ema
    """
    source = DataSet(dataset, every, template, mesh, ignore_vertices)
    if holds_sensors(recordings, dataset):
        refuse(source.given(), "vertices, and these are sensors")
        facts = build_sensors(recordings, output, source, sensors, language, console)
    elif dataset or (recordings / "dataset.json").is_file():
        refuse(sensors.given() + ["--rate"] * bool(sensors.rate), "sensors, and the data set has none")
        facts = build_motion(recordings, output, source, sensors.names, language, console)
    else:
        given = source.given() + sensors.given() + ["--every"] * bool(every)
        given += ["--names"] * bool(sensors.names) + ["--rate"] * bool(sensors.rate)
        refuse(given, "data sets and sensors, and these are films")
        facts = build_landmarks(recordings, output, console)
    told = [f"{value} {name}" for name, value in facts.items() if isinstance(value, int)]
    console.print(f"wrote {output}: {', '.join(told)}")
    if splits := facts.get("splits"):
        console.print("splits: " + ", ".join(f"{count} {name}" for name, count in splits.items()))
    for note in facts.get("guessed", ()):
        console.print(note)
    console.print_result(facts)


def refuse(given: list[str], of: str) -> None:
    """Raise UsageError for options that are of something else."""
    if given:
        raise click.UsageError(f"{', '.join(given)}: is for {of}; leave it out")


def holds_sensors(folder: Path, dataset: str) -> bool:
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


def build_sensors(
    folder: Path, output: Path, source: DataSet, sensors: SensorOptions, language: str, console: Console
) -> dict[str, Any]:
    """Build a corpus of sensors, and return what it has."""
    from phonanim.corpus.importing import import_dataset
    from phonanim.ema.corpus import RATE, build_sensor_corpus

    if source.name:
        with console.progress(source.name) as progress:
            import_dataset(source.name, folder, output, source.every or 1, progress=progress)
        folder = output
    elif source.every:
        raise click.UsageError("--every is for --dataset; --rate sets the rate of sensors")
    with console.progress(folder.name) as progress:
        found = build_sensor_corpus(folder, output, sensors.preparation(folder, RATE), language, progress)
    for name, why in found.left_out.items():
        console.print(f"left out {name}: {why}")
    return describe_corpus(found.corpus, folder, output) | {"sensors": len(found.corpus.source.names)}


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
        "splits": dict(Counter(corpus.split)),
    }


def build_motion(
    recordings: Path,
    output: Path,
    source: DataSet,
    names: tuple[str, ...],
    language: str,
    console: Console,
) -> dict[str, Any]:
    """Build a corpus of controls or vertices, and return what it has."""
    from phonanim.corpus.motion_build import build_from_dataset, build_motion_corpus
    from phonanim.evaluation.predictions import read_templates
    from phonanim.rig.mesh_file import read_mesh

    rests = read_templates(source.template) if source.template else None
    triangles = read_mesh(source.mesh)[1] if source.mesh else None
    with console.progress(source.name or "corpus") as progress:
        if source.name:
            every, ignored = source.every or 1, source.ignored_vertices()
            corpus = build_from_dataset(
                source.name, recordings, output, every, rests, language, triangles, progress, names, ignored
            )
        elif source.every or source.ignored:
            raise click.UsageError(
                "--every and --ignore-vertices are for --dataset; give them to phonanim corpus import"
            )
        else:
            corpus = build_motion_corpus(recordings, output, rests, language, triangles, names)
    return describe_corpus(corpus, output if source.name else recordings, output)


def describe_corpus(corpus: MotionCorpus, imported: Path, output: Path) -> dict[str, Any]:
    """The facts of a corpus of controls, sensors or vertices, which was built from an imported folder."""
    from phonanim.corpus.motion_build import read_imported

    splits = Counter(clip.split for clip in corpus.clips)
    if (imported / "dataset.json").is_file():
        rows = read_imported(imported)[1]
        unused = sum(not row["split"] for row in rows) if any(row["split"] for row in rows) else 0
        splits += Counter({ORDER[-1]: unused})
    width = prod(corpus.frames(0).shape[1:])
    order = (*ORDER, *sorted(set(splits) - set(ORDER)))
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
        "splits": {name: splits[name] for name in order if splits[name]},
        "guessed": list(corpus.provenance.get("guessed", ())),
    }
