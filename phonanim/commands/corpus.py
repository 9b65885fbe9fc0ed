"""`phonanim corpus`: make training corpora from recordings."""

from __future__ import annotations

from math import prod
from pathlib import Path
from typing import Any

import click

from phonanim.commands import Console, console_options
from phonanim.commands._films import appearance, track
from phonanim.commands._stereo import reconstruct


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
@click.option("--language", default="auto", help="Label set of a data set's phones.")
@console_options
def build(
    recordings: Path,
    output: Path,
    dataset: str | None,
    every: int | None,
    template: Path | None,
    language: str,
    console: Console,
) -> None:
    """Write a training corpus of a folder: of tracked films, or of a data set.

    Films are what `corpus track` writes: clips.csv, landmarks.npz, textgrid/ and audio/. A data set is what
    `corpus import` wrote, or with --dataset its owners' own layout. docs/targets.md describes such corpora.

    \b
    Examples:
      phonanim corpus build recordings/grid_s1 -o work/corpus
      phonanim corpus build work/vocaset -o work/vocaset --template templates.pkl
      phonanim corpus build facegood/ --dataset facegood -o work/facegood
    """
    if dataset or (recordings / "dataset.json").is_file():
        facts = build_motion(recordings, output, dataset, every, template, language, console)
    elif template or every:
        raise click.UsageError("--template and --every are for data sets; give --dataset, or leave them out")
    else:
        facts = build_landmarks(recordings, output, console)
    counted = ", ".join(f"{value} {name}" for name, value in facts.items() if isinstance(value, int))
    console.print(f"wrote {output}: {counted}")
    console.print_result(facts)


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
    template: Path | None,
    language: str,
    console: Console,
) -> dict[str, Any]:
    """Build a corpus of controls, sensors or vertices, and return what it has."""
    from collections import Counter

    from phonanim.corpus.motion_build import build_from_dataset, build_motion_corpus
    from phonanim.evaluation.predictions import read_templates

    rests = read_templates(template) if template else None
    with console.progress(dataset or "corpus") as progress:
        if dataset:
            corpus = build_from_dataset(dataset, recordings, output, every or 1, rests, language, progress)
        elif every:
            raise click.UsageError("--every is for --dataset; give it to phonanim corpus import")
        else:
            corpus = build_motion_corpus(recordings, output, rests, language)
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
    }


@command.command()
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--model", "models", multiple=True, required=True, help="Model to score. Repeatable.")
@click.option("--split", default="test", show_default=True, help="The clips to score.")
@click.option(
    "--mask", "masks", multiple=True, metavar="[REGION=]FILE", help="Vertices or controls of a region."
)
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Also write the motion here."
)
@console_options
def score(
    corpus: Path,
    models: tuple[str, ...],
    split: str,
    masks: tuple[str, ...],
    output: Path | None,
    console: Console,
) -> None:
    """Score models of controls, sensors or vertices on clips of their corpus, beside a face that is still.

    With -o, predicted and captured motion is written too, for `phonanim evaluate` and other tools.

    \b
    Example:
      phonanim corpus score work/facegood --model models/facegood_phisanet --split test -o work/scored
    """
    from phonanim.corpus.motion import load_motion_corpus
    from phonanim.evaluation.corpora import mean_measures, score_models
    from phonanim.face.masks import parse_masks
    from phonanim.pipeline import load_model

    loaded, known = load_motion_corpus(corpus), {Path(name).name: load_model(name) for name in models}
    with console.progress(split) as progress:
        found = score_models(known, loaded, split, parse_masks(masks), output, progress)
    table = {name: mean_measures(list(scores.values())) for name, scores in found.items()}
    first = next(iter(found.values()))
    seconds = sum(one.frames / one.fps for one in first.values())
    for note in dict.fromkeys(note for one in first.values() for note in one.notes):
        console.print(f"note: {note}")
    facts = {"split": split, "clips": len(first), "seconds": round(seconds, 1), "models": table}
    console.print_result(facts, "\n".join(scores_table(facts)))


def scores_table(facts: dict[str, Any]) -> list[str]:
    """Measures in rows, models in columns."""
    table, wide = facts["models"], 24
    lines = [f"{facts['clips']} clips, {facts['seconds']} s of the split {facts['split']}"]
    lines.append(f"{'':<38}" + "".join(f"{name[: wide - 1]:>{wide}}" for name in table))
    for measure in dict.fromkeys(measure for row in table.values() for measure in row):
        cells = (f"{row[measure]:>{wide}.4f}" if measure in row else " " * wide for row in table.values())
        lines.append(f"{measure:<38}" + "".join(cells))
    return lines


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
