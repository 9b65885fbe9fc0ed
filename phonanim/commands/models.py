"""`phonanim models`: list the available models and their scores."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console, console_options

if TYPE_CHECKING:
    from phonanim.core.catalog import ModelEntry


@click.command()
@console_options
def command(console: Console) -> None:
    """List the available models.

    These are the shipped models, and those in ./models or in the folders of PHONANIM_MODELS.

    \b
    Examples:
      phonanim models
      phonanim models --json
    """
    from phonanim.core.catalog import list_models

    entries = list_models()
    console.print_result([model_facts(entry) for entry in entries], "\n".join(map(model_line, entries)))


def model_facts(entry: ModelEntry) -> dict[str, Any]:
    """One model for scripts: where it is, and its model.json."""
    return {"name": entry.name, "path": str(entry.path), "shipped": entry.shipped, **entry.card}


def model_line(entry: ModelEntry) -> str:
    """One model as text: name, kind, size and held-out scores."""
    scores = entry.card.get("provenance", {}).get("scores", {})
    figures = (f"{name} {value:g}" for name, value in scores.items() if isinstance(value, (int, float)))
    origin = "shipped" if entry.shipped else str(entry.path)
    return f"{entry.name:<16} {entry.card.get('kind', '?'):<12} {origin:<10} {', '.join(figures)}"
