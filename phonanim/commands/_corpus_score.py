"""`phonanim corpus score`: models of controls, sensors or vertices on their own corpus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from phonanim.commands import Console, console_options


@click.command()
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--model", "models", multiple=True, help="Model to score. Repeatable.")
@click.option(
    "--leave-out",
    "recipes",
    multiple=True,
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Recipe to train anew without each clip in turn, and to score on it. Repeatable.",
)
@click.option("--split", default="test", show_default=True, help="The clips to score.")
@click.option(
    "--mask", "masks", multiple=True, metavar="[REGION=]FILE", help="Vertices or controls of a region."
)
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Also write the motion here."
)
@click.option(
    "--heat",
    "picture",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Also draw the error of each vertex, control or channel, as PNG (extra plots).",
)
@console_options
def score(
    corpus: Path,
    models: tuple[str, ...],
    recipes: tuple[Path, ...],
    split: str,
    masks: tuple[str, ...],
    output: Path | None,
    picture: Path | None,
    console: Console,
) -> None:
    """Score models of controls, sensors or vertices on clips of their corpus, beside a face that is still.

    With -o, predicted and captured motion is written too, for `phonanim evaluate` and other tools.

    With --leave-out, every clip is a test in turn, for corpora that are too small for splits.

    \b
    Examples:
      phonanim corpus score work/facegood --model models/facegood_phisanet --split test -o work/scored
      phonanim corpus score work/facegood --model models/facegood_phisanet --heat heat.png
      phonanim corpus score work/ema_de --leave-out ema_audio.toml
    """
    from phonanim.corpus.motion import load_motion_corpus
    from phonanim.evaluation.corpora import mean_measures, score_left_out, score_models
    from phonanim.evaluation.heat import Heat, check_drawable, draw_heat
    from phonanim.face.masks import parse_masks
    from phonanim.pipeline import load_model

    if bool(models) == bool(recipes):
        raise click.UsageError("give either --model or --leave-out")
    if picture:
        check_drawable()
    loaded, regions, heat = load_motion_corpus(corpus), parse_masks(masks), Heat()
    with console.progress(split) as progress:
        if recipes:
            split, found = (
                "each clip left out",
                score_left_out(recipes, loaded, regions, output, progress, heat),
            )
        else:
            known = {Path(name).name: load_model(name) for name in models}
            found = score_models(known, loaded, split, regions, output, progress, heat)
    if picture:
        draw_heat(heat, picture, f", {loaded.source.unit}" if loaded.source.unit else "")
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
