"""The one table of a comparison's first page: likeness, size, jaw and legibility of every model and tool."""

from __future__ import annotations

import re
from typing import Any

from phonanim.comparison import legibility, tools
from phonanim.comparison.plan import Plan
from phonanim.comparison.run import seeded_rows
from phonanim.comparison.tables import SHOWN, Table, interval_text
from phonanim.corpus.corpus import Corpus
from phonanim.evaluation.statistics import pooled_sd_ratio
from phonanim.metrics import speech_mask

Document = dict[str, Any]
KINDS = ("phones", "audio", "both")
CAPTURED = "captured motion"
ALONE = "lips alone"
HEADER = [
    *("model", "driven by", "aperture r", "sd ratio", "width r", "sd ratio", "vertex error, mm"),
    *("visemes read right", "jaw r, sensors"),
]


def overview_table(document: Document, plan: Plan) -> Table:
    """One row per model, then models with articulation, then other tools and captured motion."""
    read = legibility.read_legibility(plan.legibility) if plan.legibility else {"films": [], "sensors": []}
    known = [*plan.models, *document.get("published", {"models": ()})["models"]]
    names = {SHOWN.get(name, name): name for name in known}
    rows = [
        _model_row(document, shown, name, read)
        for kind in KINDS
        for shown, name in names.items()
        if document["models"][shown]["driven_by"] == kind
    ]
    shown = {name: shown for shown, name in names.items()}
    for found in read["films"]:
        if found["way"] in ("phones", "sound") and found["model"] == plan.reference:
            rows.append(_articulated_row(found, shown.get(found["model"], found["model"]), read))
    if "tools" in document:
        cells = tools.tools_table(document["tools"], document["seed"])
        rows += [_tool_row(cells[0], row) for row in cells[1:]]
    for found in read["films"]:
        if not found["way"]:
            rows.append([CAPTURED, "", "1", "1", "1", "1", "0", _read_right(found), ""])
    return [HEADER, *rows]


def spoken_seconds(corpus: Corpus) -> tuple[float, float]:
    """Seconds of the test clips, and of the speech in them."""
    clips = [int(clip) for clip in corpus.clips_of("test")]
    spoken = sum(int(speech_mask(corpus.tracks[clip], corpus.times(clip)).sum()) for clip in clips)
    return float(corpus.frames[clips].sum()) / corpus.fps, spoken / corpus.fps


def _model_row(document: Document, shown: str, name: str, read: dict[str, Any]) -> list[str]:
    speech = seeded_rows(document, shown, "raw", "test/speech")
    every = seeded_rows(document, shown, "raw", "test/all")
    row = [shown, document["models"][shown]["driven_by"]]
    for measure in ("aperture_r", "width_r"):
        text = interval_text(document, speech[measure], measure) if speech else ""
        row += [text, f"{pooled_sd_ratio(speech[measure].sum(axis=(0, 1))):.2f}" if speech else ""]
    row.append(interval_text(document, every["vertex_error"], "vertex_error") if every else "")
    films = [one for one in read["films"] if one["model"] == name and one["way"] == ALONE]
    return [*row, _read_right(films[0]) if films else "", _jaw(read, name, ALONE)]


def _articulated_row(found: dict[str, Any], shown: str, read: dict[str, Any]) -> list[str]:
    own = [f"{found[f'{name}_{part}']:.2f}" for name in legibility.FILMS for part in ("r", "sd_ratio")]
    jaw = _jaw(read, found["model"], found["way"])
    label = f"{shown}, with articulation"
    return [label, "audio" if found["way"] == "sound" else found["way"], *own, "", _read_right(found), jaw]


def _tool_row(header: list[str], row: list[str]) -> list[str]:
    """A row of the table of tools: values on the shipped head, without their p."""
    cells = {head: cell.partition(", p")[0] for head, cell in zip(header, row, strict=True)}
    found = [cells["in speech"], _value(cells["aperture sd ratio in speech"])]
    found += [cells["width r in speech"], _value(cells["width sd ratio in speech"])]
    return [f"{row[0]}, on the head", "", *found, cells["vertex error, mm"], _percent(cells), ""]


def _value(cell: str) -> str:
    """0.84 of "0.841 [0.812, 0.870]"."""
    number = cell.partition(" ")[0]
    return f"{float(number):.2f}" if number else ""


def _percent(cells: dict[str, str]) -> str:
    """76% [74%, 79%] of "0.757 [0.740, 0.790]"."""
    return re.sub(r"\d\.\d+", lambda found: f"{float(found.group()):.0%}", cells["visemes read right"])


def _read_right(found: dict[str, Any]) -> str:
    low, high = found["legible_interval"]
    return f"{found['legible']:.0%} [{low:.0%}, {high:.0%}]"


def _jaw(read: dict[str, Any], name: str, way: str) -> str:
    """Of all sentences where the model has them, else of those with sound."""
    known = [one for one in read["sensors"] if one["model"] == name and one["way"] == way and "jaw_r" in one]
    known.sort(key=lambda one: one["group"] != "all sentences")
    return f"{known[0]['jaw_r']:.2f}" if known else ""
