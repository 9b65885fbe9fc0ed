"""The available models: those of the package, and those in local folders."""

from __future__ import annotations

import os
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from phonanim.core.lexicon import search_path
from phonanim.errors import ModelError

SHIPPED = Path(__file__).parent.parent / "models"
DEFAULT_MODEL = "default"
RECOGNITION_MODEL = "audio"  # the shipped model that recognizes phones
MAX_CARD = 1 << 24  # bytes
CARD = "model.json"  # the description in a model folder


@dataclass(frozen=True, slots=True)
class ModelEntry:
    """One model: its name, its folder, and the content of its model.json."""

    name: str
    path: Path
    shipped: bool
    card: dict[str, Any]


def local_folders() -> tuple[Path, ...]:
    """Folders that are searched for local models: those of PHONANIM_MODELS, else ./models.

    The folders `models` on PHONANIM_PATH follow.
    """
    places = os.environ.get("PHONANIM_MODELS", "models")
    own = (Path(place) for place in places.split(os.pathsep) if place)
    return (*own, *(folder / "models" for folder in search_path()))


def list_models() -> tuple[ModelEntry, ...]:
    """Every available model, those of the package first. Raises ModelError when one is damaged."""
    return tuple(
        ModelEntry(path.name, path, folder == SHIPPED, read_card(path))
        for folder in (SHIPPED, *local_folders())
        for path in _models_in(folder)
    )


def find_model(name: str) -> Path:
    """The folder of a model, by its name or its path. Raises ModelError, which suggests the nearest name."""
    if (Path(name) / CARD).is_file():
        return Path(name)
    for folder in (SHIPPED, *local_folders()):
        if (folder / name / CARD).is_file():
            return folder / name
    raise ModelError(f"there is no model {name!r}{_hint(name)}; `phonanim models` lists the available ones")


def read_card(path: Path) -> dict[str, Any]:
    """The model.json of a model folder. Raises ModelError."""
    from phonanim.core.decode import (
        read_json,
    )  # imports NumPy, which comes after the number of threads is set

    try:
        card = read_json(path / CARD, MAX_CARD)
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{path / CARD}: cannot be read ({error}); fetch or train the model again"
        ) from error
    if not isinstance(card, dict):
        raise ModelError(f"{path / CARD}: is not a JSON object; fetch or train the model again")
    return card


def learned_styles(path: Path) -> tuple[str, ...]:
    """The names of the styles that the model of a folder has learned, in their order. Raises ModelError."""
    styles = read_card(path).get("styles", [])
    if not isinstance(styles, list) or not all(isinstance(name, str) for name in styles):
        raise ModelError(f"{path / CARD}: styles is not a list of names; train the model again")
    return tuple(styles)


def _models_in(folder: Path) -> list[Path]:
    return sorted(card.parent for card in folder.glob(f"*/{CARD}"))


def _hint(name: str) -> str:
    names = [path.name for folder in (SHIPPED, *local_folders()) for path in _models_in(folder)]
    near = get_close_matches(name, names, n=1)
    return f"; did you mean {near[0]!r}?" if near else ""
