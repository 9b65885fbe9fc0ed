"""Tables of models with and without articulation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from phonanim.comparison.legibility import film_table, read_legibility, sensor_table
from phonanim.comparison.tables import markdown
from phonanim.errors import ModelError

LIKENESS = {f"{name}_{part}": 0.5 for name in ("lip_gap", "lip_width") for part in ("r", "slope", "sd_ratio")}
READ = {
    "legible": 0.6,
    "legible_interval": [0.5, 0.7],
    "legible_on_head": 0.4,
    "legible_on_head_interval": [0.3, 0.5],
}
FOUND: dict[str, Any] = {
    "films": [
        {"model": "captured motion", "way": "", **LIKENESS, **READ},
        {"model": "tree", "way": "phones", **LIKENESS, **READ},
    ],
    "sensors": [
        {"model": "sensors", "way": "", "group": "all sentences", "legible": 0.64, "phones": 9},
        {"model": "tree", "way": "sound", "group": "with sound", "jaw_r": 0.83, "legible": 0.75},
    ],
}


def test_captured_motion_is_not_compared_with_itself() -> None:
    header, captured, tree = film_table(FOUND)
    assert captured[2:-2] == [""] * 6
    assert captured[-2:] == ["60% [50%, 70%]", ""]
    assert tree == ["tree", "from phones", *["0.50"] * 6, "60% [50%, 70%]", "40% [30%, 50%]"]
    assert markdown([header, captured, tree]).count("\n") == 3


def test_what_sensors_lack_stays_empty() -> None:
    rows = sensor_table(FOUND)
    assert rows[1] == ["all sentences", "sensors", "", "", "", "", "", "", "64%"]
    assert rows[2] == ["with audio", "tree", "from audio", "0.83", "", "", "", "", "75%"]


def test_files_of_another_structure_are_refused(tmp_path: Path) -> None:
    (tmp_path / "found.json").write_text(json.dumps(FOUND))
    assert read_legibility(tmp_path / "found.json") == FOUND
    for text, told in (("{", "cannot be read"), ("[]", "has no films"), ('{"films": []}', "has no films")):
        (tmp_path / "found.json").write_text(text)
        with pytest.raises(ModelError, match=told):
            read_legibility(tmp_path / "found.json")
