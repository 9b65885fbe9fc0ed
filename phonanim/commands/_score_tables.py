"""Tables of scores for the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from phonanim.evaluation.scoring import Scores

# A table of files shows the first four of these that were measured.
LEADING = (
    "lve_mm",
    "mve_mm",
    "aperture_r",
    "pbm_least_gap_mm",
    "control_mse",
    "control_mae",
    "control_lag_ms",
    "articulation_jaw_r",
    "articulation_lip_gap_r",
)


def score_table(rows: dict[str, Scores], facts: dict[str, Any]) -> list[str]:
    """A table of measures, and one by class of phones."""
    scores = next(iter(rows.values()))
    lines = [f"{key:<38} {value:12.4f}" for key, value in scores.measures.items()]
    tables = [*class_table(rows, facts), *viseme_table(facts)]
    return [f"{scores.frames} frames at {scores.fps:g} fps", *lines, *tables]


def class_table(rows: dict[str, Scores], facts: dict[str, Any]) -> list[str]:
    """The error of each class of phones; empty without an alignment."""
    if not facts["classes"]:
        return []
    lines = [f"{row['name']:<38} {row['mean']:12.4f}  {row['segments']} sounds" for row in facts["classes"]]
    return ["", f"{next(iter(rows.values())).error} by class of phones", *lines]


def viseme_table(facts: dict[str, Any]) -> list[str]:
    """How often each viseme is read right from the lips; empty where nothing was read."""
    from phonanim.evaluation.legibility import VISEMES

    rows = facts["visemes"]
    if not rows:
        return []
    read, captured = (sum(row[side] for row in rows) / len(rows) for side in ("read", "captured"))
    lines = [
        "",
        f"visemes read right: {read:.0%} (captured motion: {captured:.0%}; chance: {1 / len(VISEMES):.0%})",
    ]
    for row in rows:
        told = f"{row['name']:<38} {row['read']:12.0%}"
        lines.append(f"{told}  captured {row['captured']:.0%}, {row['sounds']} sounds")
    return lines


def summary_table(rows: dict[str, Scores], facts: dict[str, Any]) -> list[str]:
    """The leading measures per file, then the mean and interval of all."""
    chosen = [key for key in LEADING if key in facts["summary"]][:4]
    width = max(map(len, rows))
    lines = [" ".join([f"{'':<{width}}", *(f"{key:>22}" for key in chosen)])]
    for name, scores in rows.items():
        lines.append(
            " ".join([f"{name:<{width}}", *(f"{scores.measures.get(k, math.nan):22.4f}" for k in chosen)])
        )
    lines += ["", f"{'mean of files':<38} {'':>12}  95 % interval"]
    for key, entry in facts["summary"].items():
        low, high = entry.get("interval", (math.nan, math.nan))
        lines.append(f"{key:<38} {entry['mean']:12.4f}  {low:.4f} to {high:.4f}")
    return [*lines, *class_table(rows, facts), *viseme_table(facts)]
