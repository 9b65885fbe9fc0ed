"""Other tools through the same head: a table with tests, from values per clip (benchmarks/tools.py)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import read_json
from phonanim.errors import ModelError
from phonanim.evaluation.statistics import bootstrap_interval, holm, mean_rows, paired_test

Array = NDArray[np.float64]
OURS = "phonanim default"  # as `phonanim animate` moves a rig, with articulation
SHOWN = {OURS: "phonanim, with articulation"}
COLUMNS = {
    "aperture_r": "aperture r",
    "aperture_r_speech": "in speech",
    "aperture_sd_ratio_speech": "aperture sd ratio in speech",
    "width_r_speech": "width r in speech",
    "width_sd_ratio_speech": "width sd ratio in speech",
    "visemes_right": "visemes read right",
    "vertex_error_mm": "vertex error, mm",
    "lve_mm": "LVE, mm",
    "pbm_gap_mm": "p b m gap, mm",
    "lag_ms": "lag, ms",
}
TESTED = ("aperture_r_speech", "vertex_error_mm", "lve_mm")


def read_tools(path: Path) -> dict[str, Any]:
    """{tool: {clip: {measure: number or null}}}. Raises ModelError when the file has another structure."""
    try:
        found: dict[str, Any] = read_json(path)
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read ({error}); make it with benchmarks/tools.py") from error
    if not isinstance(found, dict) or OURS not in found:
        raise ModelError(f"{path}: has no row {OURS!r}; make it with benchmarks/tools.py")
    return found


def tools_table(tools: dict[str, Any], seed: int) -> list[list[str]]:
    """Mean over clips with its 95 % interval for each tool; p of its difference from ours, Holm-corrected."""
    others = [name for name in tools if name != OURS]
    pairs = [(name, measure) for name in others for measure in TESTED]
    p = dict(zip(pairs, holm([_p(tools, name, measure, seed) for name, measure in pairs]), strict=True))
    rows = [["tool", *COLUMNS.values()]]
    for name in tools:
        cells = []
        for measure in COLUMNS:
            text = _cell(_values(tools, name, measure), seed)
            chance = p.get((name, measure))
            cells.append(text if chance is None or text == "" else f"{text}, p {chance:.4f}")
        rows.append([SHOWN.get(name, name), *cells])
    return rows


def _values(tools: dict[str, Any], name: str, measure: str) -> Array:
    return np.array([np.nan if c.get(measure) is None else c[measure] for c in tools[name].values()], float)


def _cell(values: Array, seed: int) -> str:
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return ""
    low, high = bootstrap_interval(mean_rows(known), np.random.default_rng(seed))
    return f"{known.mean():.3f} [{low:.3f}, {high:.3f}]"


def _p(tools: dict[str, Any], name: str, measure: str, seed: int) -> float:
    ours, theirs = _values(tools, OURS, measure), _values(tools, name, measure)
    both = np.isfinite(ours) & np.isfinite(theirs)
    if not both.any():
        return 1.0
    rng = np.random.default_rng(seed)
    return paired_test(mean_rows(ours[both]), mean_rows(theirs[both]), rng)
