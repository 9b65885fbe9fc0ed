"""`phonanim train`: train a model from a configuration, and write its folder."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Console, console_options
from phonanim.core.device import DEVICES, PRECISIONS, use_device


@click.command()
@click.argument("config", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Model folder to write."
)
@click.option("--seed", type=click.IntRange(min=0), help="Overrides the seed of the configuration.")
@click.option(
    "--device",
    type=click.Choice(DEVICES),
    default="cpu",
    show_default=True,
    help="Where PyTorch trains; auto takes a graphics processor if there is one.",
)
@click.option(
    "--precision",
    type=click.Choice(PRECISIONS),
    default="single",
    show_default=True,
    help="bf16: products of matrices have 16 bits, which is faster on a graphics processor.",
)
@click.option("--plot", is_flag=True, help="Draw loss.csv of the folder as loss.png (extra plots).")
@console_options
def command(
    config: Path,
    output: Path | None,
    seed: int | None,
    device: str,
    precision: str,
    plot: bool,
    console: Console,
) -> None:
    """Train a model from a TOML configuration, and write its folder.

    \b
    Examples:
      phonanim train default.toml
      phonanim train default.toml -o models/mine --seed 3
      phonanim train phisanet.toml --plot
      phonanim train facediffuser.toml --device auto --precision bf16
    """
    from phonanim.articulation.styles import read_styles, spell_learned
    from phonanim.core.catalog import learned_styles
    from phonanim.training.losses import check_drawable, draw_losses
    from phonanim.training.recipe import read_recipe
    from phonanim.training.recipes import train

    if plot:
        check_drawable(read_recipe(config).kind, config)
    with console.progress(config.stem) as progress, use_device(device, precision):
        folder = train(config, output=output, seed=seed, progress=progress)
    pictures = draw_losses(folder) if plot else []
    styles = learned_styles(folder)
    console.print(f"wrote {', '.join(map(str, (folder, *pictures)))}; animate with --model {folder}")
    if styles:
        console.print(f"styles, for --style: {', '.join(spell_learned(styles, read_styles()))}")
    facts = {"model": str(folder), "styles": list(styles), "pictures": list(map(str, pictures))}
    console.print_result(facts)
