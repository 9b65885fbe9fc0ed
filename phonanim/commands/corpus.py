"""`phonanim corpus`: make training corpora from recordings."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.commands._corpus_build import build
from phonanim.commands._corpus_score import score
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
command.add_command(score)
command.add_command(build)


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
@click.option(
    "--ignore-vertices",
    "ignored",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="A list of vertices to leave out, numbered from 0.",
)
@console_options
def import_(
    name: str,
    folder: Path,
    output: Path,
    every: int,
    splits: tuple[str, ...],
    ignored: Path | None,
    console: Console,
) -> None:
    """Convert a third-party data set to one layout: arrays, WAV, TextGrids and a table.

    NAME is one of `phonanim corpus datasets`. FOLDER has the layout that its owners publish.

    \b
    Example:
      phonanim corpus import vocaset vocaset/ -o work/vocaset --every 2
    """
    from collections import Counter

    from phonanim.corpus.importing import import_dataset
    from phonanim.face.masks import read_mask

    without = read_mask(ignored) if ignored else None
    with console.progress(name) as progress:
        rows = import_dataset(name, folder, output, every, splits, progress, without)
    counts = Counter(row["split"] or "no split" for row in rows)
    text = ", ".join(f"{count} {split}" for split, count in sorted(counts.items()))
    console.print(f"wrote {output}: {len(rows)} recordings ({text})")
    console.print_result({"dataset": name, "output": str(output), "recordings": len(rows), "splits": counts})
