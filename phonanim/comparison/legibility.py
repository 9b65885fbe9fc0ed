"""Tables of benchmarks/legibility.py: models with and without articulation, and what is read from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from phonanim.comparison.tables import SHOWN
from phonanim.core.decode import read_json
from phonanim.errors import ModelError

FILMS = {
    "lip_gap": ("gap r", "slope", "sd ratio"),
    "lip_width": ("width r", "slope", "sd ratio"),
}
PARTS = ("r", "slope", "sd_ratio")
SENSORS = {
    "jaw_r": "jaw r",
    "jaw_sd_ratio": "jaw sd ratio",
    "lip_gap_r": "gap r",
    "lip_gap_sd_ratio": "gap sd ratio",
    "protrusion_r": "protrusion r",
}
GROUPS = {"with sound": "with audio"}


def read_legibility(path: Path) -> dict[str, Any]:
    """The rows of "films" and of "sensors". Raises ModelError when the file has another structure."""
    try:
        found: dict[str, Any] = read_json(path)
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{path}: cannot be read ({error}); make it with benchmarks/legibility.py"
        ) from error
    if not isinstance(found, dict) or not {"films", "sensors"} <= set(found):
        raise ModelError(f"{path}: has no films and sensors; make it with benchmarks/legibility.py")
    return found


def film_table(found: dict[str, Any]) -> list[list[str]]:
    """Likeness to captured lips in speech, and the share of visemes read right with its interval."""
    heads = [head for names in FILMS.values() for head in names]
    rows = [["model", "articulation", *heads, "visemes read right", "on the head"]]
    for row in found["films"]:
        own = [f"{row[f'{name}_{part}']:.2f}" for name in FILMS for part in PARTS]
        own = own if row["way"] else [""] * len(own)
        read = [_share(row, key) for key in ("legible", "legible_on_head")]
        rows.append([_name(row["model"]), _way(row["way"]), *own, *read[: 2 if row["way"] else 1]])
        rows[-1] += [""] * (len(rows[0]) - len(rows[-1]))
    return rows


def sensor_table(found: dict[str, Any]) -> list[list[str]]:
    """Likeness to sensors in speech, means over sentences, and the share of visemes read right."""
    rows = [["sentences", "model", "articulation", *SENSORS.values(), "visemes read right"]]
    for row in found["sensors"]:
        own = [f"{row[name]:.2f}" if name in row else "" for name in SENSORS]
        group = GROUPS.get(row["group"], row["group"])
        rows.append([group, _name(row["model"]), _way(row["way"]), *own, f"{row['legible']:.0%}"])
    return rows


def _name(model: str) -> str:
    return SHOWN.get(model, model)


def _way(way: str) -> str:
    return {"lips alone": "none", "phones": "from phones", "sound": "from audio"}.get(way, way)


def _share(row: dict[str, Any], key: str) -> str:
    low, high = row[f"{key}_interval"]
    return f"{row[key]:.0%} [{low:.0%}, {high:.0%}]"
