"""The results of `phonanim evaluate` for scripts: every file, means with intervals, SLCC."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from phonanim.evaluation.scoring import Scores

SEED = 0  # of the bootstrap, so that the same files give the same intervals
RESAMPLES = 2000  # enough for two digits of an interval, for each of some forty measures


def build_report(rows: dict[str, Scores], diversities: list[dict[str, float]]) -> dict[str, Any]:
    """All results, for scripts; NaN becomes null."""
    from phonanim.evaluation.legibility import merge_visemes
    from phonanim.metrics import merge_tables

    summary = summarize(rows)
    for name in dict.fromkeys(name for found in diversities for name in found):
        values = [found[name] for found in diversities if name in found]
        summary[name] = {"mean": sum(values) / len(values), "files": len(values)}
    summary |= intensity_correlations(rows)
    return {
        "files": {
            name: {
                "frames": scores.frames,
                "fps": scores.fps,
                "measures": {key: _number(value) for key, value in scores.measures.items()},
                "error_by_phone": scores.error,
                "phones": [vars(row) for row in scores.phones],
                "classes": [vars(row) for row in scores.classes],
                "visemes": [vars(row) for row in scores.visemes],
                "notes": list(scores.notes),
            }
            for name, scores in rows.items()
        },
        "summary": summary,
        "phones": [vars(row) for row in merge_tables(scores.phones for scores in rows.values())],
        "classes": [vars(row) for row in merge_tables(scores.classes for scores in rows.values())],
        "visemes": [vars(row) for row in merge_visemes(scores.visemes for scores in rows.values())],
    }


def summarize(rows: dict[str, Scores]) -> dict[str, dict[str, Any]]:
    """Mean over files of each measure, and its 95 % bootstrap interval over files."""
    import numpy as np

    from phonanim.evaluation.statistics import bootstrap_interval, mean_rows

    found: dict[str, dict[str, Any]] = {}
    for key in dict.fromkeys(key for scores in rows.values() for key in scores.measures):
        values = np.array([scores.measures.get(key, math.nan) for scores in rows.values()])
        values = values[np.isfinite(values)]
        if len(values) == 0:
            continue
        found[key] = {"mean": float(values.mean()), "files": len(values)}
        if len(values) > 1:
            interval = bootstrap_interval(mean_rows(values), np.random.default_rng(SEED), resamples=RESAMPLES)
            found[key]["interval"] = list(interval)
    return found


def intensity_correlations(rows: dict[str, Scores]) -> dict[str, dict[str, Any]]:
    """SLCC of the predictions and of the references, over three files or more whose level is known."""
    import numpy as np

    from phonanim.metrics import correlation

    found = {}
    for side in ("", "captured_"):
        names = "speech_level_db", f"{side}lip_intensity_mm_s"
        table = np.array(
            [[scores.measures.get(name, math.nan) for name in names] for scores in rows.values()]
        )
        table = table[np.isfinite(table).all(axis=1)]
        value = correlation(table[:, 0], table[:, 1]) if len(table) > 2 else math.nan
        if math.isfinite(value):
            found[f"{side}slcc"] = {"mean": value, "files": len(table)}
    return found


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
