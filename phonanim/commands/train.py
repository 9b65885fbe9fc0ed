"""`phonanim train`: a configuration to a model folder."""

from __future__ import annotations

from pathlib import Path

import click

from phonanim.commands import Talk, talk_options


@click.command()
@click.argument("config", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Model folder to write."
)
@click.option("--seed", type=click.IntRange(min=0), help="Overrides the seed of the configuration.")
@talk_options
def command(config: Path, output: Path | None, seed: int | None, talk: Talk) -> None:
    """Train a model as a TOML file says, and write its folder.

    \b
    Examples:
      phonanim train default.toml
      phonanim train default.toml -o models/mine --seed 3
    """
    from phonanim.training import train

    with talk.progress(config.stem) as progress:
        folder = train(config, output=output, seed=seed, progress=progress)
    talk.say(f"wrote {folder}; animate with --model {folder}")
    talk.result({"model": str(folder)})
