"""Masks: the vertices of a mesh that belong to the lips, the mouth or the upper face.

The masks of the package (lexicon/masks, made by scripts/build_masks.py) are for the reference face's
landmarks and for its head. Masks of the user are lists of vertex numbers, as text, JSON or .npy.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import read_array, read_json, read_utf8
from phonanim.core.lexicon import LEXICON
from phonanim.errors import EvaluationError
from phonanim.face.model import FaceModel

FOLDER = LEXICON / "masks"
Rows = NDArray[np.int64]
Masks = dict[str, Rows]
MAX_BYTES = 1 << 26  # of a list of vertex numbers
PICKLES = (".pkl", ".pickle", ".p")


@cache
def head_masks() -> Masks:
    """Vertices of the package's head by region, rows of `phonanim.rig.head.load_head().vertices`."""
    return read_masks(FOLDER / "head.json")


@cache
def landmark_numbers() -> Masks:
    """MediaPipe face-mesh numbers by region."""
    return read_masks(FOLDER / "landmarks.json")


def landmark_masks(face: FaceModel) -> Masks:
    """Rows of the reference face's landmarks by region."""
    return {
        name: np.flatnonzero(np.isin(face.indices, numbers)) for name, numbers in landmark_numbers().items()
    }


def read_masks(path: Path) -> Masks:
    """Read a JSON object of lists of vertex numbers by region. Raises EvaluationError."""
    tree = _json(path)
    if not isinstance(tree, dict):
        raise EvaluationError(f"{path}: is a list without a name; give it one: --mask lips={path}")
    return {
        str(name): _numbers(values, f"{path}, {name}") for name, values in tree.items() if name != "source"
    }


def read_mask(path: Path) -> Rows:
    """Read one list of vertex numbers: text (numbers with commas or spaces), a JSON list, or .npy.

    An .npy has numbers, or a boolean for each vertex. Pickles are refused, because reading one can run any
    code in it. Raises EvaluationError, which names the file and the fix.
    """
    suffix = path.suffix.lower()
    if suffix in PICKLES:
        raise EvaluationError(
            f"{path}: a pickle may run code when it is read; open it where this is safe and save numbers: "
            "numpy.savetxt('lips.txt', numbers, '%d')"
        )
    if suffix == ".npy":
        return _numbers(_array(path), str(path))
    if suffix == ".json":
        return _numbers(_json(path), str(path))
    return _numbers(_words(path), str(path))


def parse_masks(texts: tuple[str, ...]) -> Masks:
    """Masks from REGION=FILE, or from a JSON file of several regions. Raises EvaluationError."""
    found: Masks = {}
    for text in texts:
        name, sign, file = text.partition("=")
        if not sign and not text.lower().endswith(".json"):
            raise EvaluationError(f"--mask {text}: name its region, such as lips={text}")
        found |= {name: read_mask(Path(file))} if sign else read_masks(Path(text))
    return found


def check_masks(masks: Masks, vertices: int) -> Masks:
    """The masks unchanged. Raises EvaluationError when one has a vertex number beyond the mesh."""
    for name, rows in masks.items():
        if rows.max() >= vertices:
            raise EvaluationError(
                f"mask {name} has vertex {rows.max()}, but the last vertex is {vertices - 1}; use another"
            )
    return masks


def _numbers(values: Any, where: str) -> Rows:
    try:
        array = np.asarray(values)
    except ValueError:  # lists of different lengths
        array = np.empty(0)
    if array.dtype == bool and array.ndim == 1:
        array = np.flatnonzero(array)
    if array.ndim != 1 or array.size == 0 or not np.issubdtype(array.dtype, np.integer) or array.min() < 0:
        raise EvaluationError(f"{where}: is not a list of vertex numbers (whole, from 0)")
    return np.unique(array.astype(np.int64))


def _words(path: Path) -> list[int]:
    try:
        words = [word for word in re.split(r"[\s,;]+", read_utf8(path, MAX_BYTES)) if word]
        return [int(word) for word in words]
    except (OSError, ValueError) as error:
        raise EvaluationError(f"{path}: cannot be read as vertex numbers: {error}") from error


def _json(path: Path) -> Any:
    try:
        return read_json(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        raise EvaluationError(f"{path}: cannot be read: {error}") from error


def _array(path: Path) -> NDArray[Any]:
    try:
        return read_array(path)
    except (OSError, ValueError) as error:
        raise EvaluationError(f"{path}: cannot be read: {error}") from error
