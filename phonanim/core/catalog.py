"""The models at hand: those that are shipped, and those in local folders."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from phonanim.core.lexicon import search_path
from phonanim.errors import ModelError

SHIPPED = Path(__file__).parent.parent / "models"
DEFAULT_MODEL = "default"
CARD = "model.json"  # what a model folder says of itself


@dataclass(frozen=True, slots=True)
class ModelEntry:
    """One model: its name, its folder, and what its model.json says."""

    name: str
    path: Path
    shipped: bool
    card: dict[str, Any]


def local_folders() -> tuple[Path, ...]:
    """Where local models are looked for: the folders of PHONANIM_MODELS, or else ./models.

    Then the folders `models` on PHONANIM_PATH.
    """
    places = os.environ.get("PHONANIM_MODELS", "models")
    own = (Path(place) for place in places.split(os.pathsep) if place)
    return (*own, *(folder / "models" for folder in search_path()))


def list_models() -> tuple[ModelEntry, ...]:
    """Every model at hand, the shipped ones first. Raises ModelError when one is damaged."""
    return tuple(
        ModelEntry(path.name, path, folder == SHIPPED, read_card(path))
        for folder in (SHIPPED, *local_folders())
        for path in _models_in(folder)
    )


def find_model(name: str) -> Path:
    """The folder of a model, by its name or by its path. Raises ModelError, with the nearest name."""
    if (Path(name) / CARD).is_file():
        return Path(name)
    for folder in (SHIPPED, *local_folders()):
        if (folder / name / CARD).is_file():
            return folder / name
    raise ModelError(f"there is no model {name!r}{_hint(name)}; `phonanim models` lists those at hand")


def read_card(path: Path) -> dict[str, Any]:
    """The model.json of a model folder. Raises ModelError."""
    try:
        card = json.loads((path / CARD).read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{path / CARD}: cannot be read ({error}); fetch or train the model again"
        ) from error
    if not isinstance(card, dict):
        raise ModelError(f"{path / CARD}: is not a table of facts; fetch or train the model again")
    return card


def _models_in(folder: Path) -> list[Path]:
    return sorted(card.parent for card in folder.glob(f"*/{CARD}"))


def _hint(name: str) -> str:
    names = [path.name for folder in (SHIPPED, *local_folders()) for path in _models_in(folder)]
    near = get_close_matches(name, names, n=1)
    return f"; did you mean {near[0]!r}?" if near else ""
