"""The report of a comparison on controls, sensors or vertices: a page with one table, a page of details."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.comparison import plots, tables
from phonanim.comparison.figures import draw_file
from phonanim.comparison.measures import MEASURES, curve_r, curve_sd_ratio
from phonanim.comparison.motion_scores import KINDS, MILLIMETRES, PIECE
from phonanim.comparison.pages import Part
from phonanim.comparison.plan import LEFT_OUT, Plan
from phonanim.comparison.report import DATA, write_pages
from phonanim.comparison.run import Document, model_rows, seeded_rows
from phonanim.comparison.scores import measure_value
from phonanim.comparison.tables import NOTHING, Table, interval, interval_text
from phonanim.core.files import make_folder_within
from phonanim.evaluation.corpora import STILL
from phonanim.evaluation.heat import Heat, draw_heat

Array = NDArray[np.float64]
FEWEST = 6  # clips or pieces that an interval needs
BARS = "Mean r of the curves and error of every model"
HEAT = "Mean error of each vertex, control or channel, for each model"
MEANINGS = {
    "controls": "r and the sd ratio are means over the controls that move most in training, "
    "MCE is the mean distance of all controls, LCE of those of the mouth (Stan 2023), L1 the sum of their "
    "differences (Medina 2023)",
    "sensors": "r, the sd ratio and the error (root mean square) are means over the channels of articulation "
    "that the sensors show, each less its mean in the recording",
    "vertices": "r and the sd ratio are of the displacements of all vertices from the face at rest, MVE is "
    "the mean distance of a vertex, LVE the mean over frames of the largest of a lip vertex",
}


def write_motion_report(document: Document, plan: Plan, folder: Path) -> Path:
    """Write benchmark.md into a folder, and into benchmark/ its figures, the details and benchmark.json."""
    pages = {"details": details(document, plan)}
    draw_figures(document, make_folder_within(folder / DATA, folder))
    return write_pages(overview(document, plan), pages, folder)


def main_fold(document: Document) -> str:
    """The fold of the test clips, or that of each clip left out."""
    return "test" if "test" in document["folds"] else f"{LEFT_OUT}*"


def main_frames(document: Document, fold: str) -> str:
    """Speech where it is known, else all frames."""
    known = model_rows(document, STILL, "raw", f"{fold}/speech")
    return f"{fold}/all" if known is None else f"{fold}/speech"


def overview(document: Document, plan: Plan) -> list[Part]:
    """The page that can be read on its own."""
    where = main_frames(document, main_fold(document))
    picture = f"![{BARS}]({DATA}/bars.png)\n\n*{BARS}.*"
    parts: list[Part] = ["# Comparison", _opening(document), picture, overview_table(document, where)]
    parts.append(_legend(document, where))
    if plan.notes.get("overview"):
        parts += ["## What the table shows", plan.notes["overview"]]
    links = (
        f"- [Each curve, differences, other clips]({DATA}/details.md)\n"
        f"- [All tables as JSON]({DATA}/benchmark.json)"
    )
    return [*parts, "## More", links]


def _opening(document: Document) -> str:
    folds = [fold for name, fold in document["folds"].items() if name == "test" or name.startswith(LEFT_OUT)]
    first, count = folds[0], sum(len(fold["clips"]) for fold in folds)
    seconds, spoken = sum(fold["seconds"] for fold in folds), sum(fold["spoken_s"] or 0 for fold in folds)
    people = sorted({name for fold in folds for name in fold["speakers"]})
    data = f"{document['kind']} of {document['corpus']['data']}"
    tested = f"{_clips(count)}, {seconds:.1f} s of {_people(people)}"
    if spoken:
        tested += f", of which {spoken:.1f} s are speech"
    if main_fold(document) == "test":
        return (
            f"Every model learned the {data} from the same {_clips(first['train'])}, "
            f"{first['train_s']:.0f} s of {_people(first['train_speakers'])}, and is scored on {tested}."
        )
    longest = max(fold["train_s"] for fold in folds)
    return (
        f"Every model learned the {data} anew without each clip in turn, from at most {longest:.1f} s, and "
        f"is scored on the clip that was left out: in all {tested}."
    )


def _clips(count: int) -> str:
    return "1 clip" if count == 1 else f"{count} clips"


def _people(names: list[str]) -> str:
    return f"one speaker ({names[0]})" if len(names) == 1 else f"{len(names)} speakers"


def overview_table(document: Document, where: str) -> Table:
    """One row per model, the still face last: each measure with its 95 % interval."""
    measures = measures_of(document, where)
    header = [
        "model",
        "driven by",
        *[MEASURES[name].heading for name in measures],
        "frames/s",
        "training, min",
    ]
    rows = [header]
    for name, model in document["models"].items():
        found = seeded_rows(document, name, "raw", where)
        if found is None:
            continue
        cells = [cell(document, found[measure], measure) for measure in measures]
        rows.append([name, model["driven_by"], *cells, *_cost(model)])
    return rows


def measures_of(document: Document, where: str) -> list[str]:
    """The measures that the corpus has, r and the sd ratio first."""
    known = model_rows(document, STILL, "raw", where) or {}
    return ["curves_r", "curves_sd_ratio", *(name for name in KINDS[document["kind"]] if name in known)]


def _cost(model: dict[str, Any]) -> list[str]:
    speed = f"{model['predicted'] / max(model['predicting_s'], 1e-6):,.0f}" if model.get("predicted") else ""
    seconds = model.get("training_s")
    return [speed, "" if seconds is None else f"{seconds / 60:.1f}"]


def _legend(document: Document, where: str) -> str:
    fold = next(iter(document["folds"].values()))
    frames = "all frames"
    if where.endswith("speech"):
        frames = "speech, by the phones" if fold["aligned"] else "speech, by the level of the sound"
    text = f"Scored in {frames}: {MEANINGS[document['kind']]}. "
    if document["kind"] == "vertices":
        unit = document["corpus"]["unit"]
        text += f"Distances are in {'mm' if unit in MILLIMETRES else unit or 'the unit of the data set'}. "
    return text + (
        "The sd ratio is the deviation of the predicted curves divided by that of the captured ones, 1 at "
        f"best: r does not detect a motion that is too small. {_uncertainty(document, where)} frames/s are "
        "those of one thread, features of the sound included unless they are in the cache. The last row, "
        f"{STILL}, does not move."
    )


def _uncertainty(document: Document, where: str) -> str:
    count = units(document, where)
    if count < FEWEST:
        return f"{_clips(count)} allow no interval and no test."
    return (
        f"Brackets hold 95 % intervals by bootstrap over {count} clips; long ones are cut into pieces "
        f"of about {PIECE:.0f} s."
    )


def units(document: Document, where: str) -> int:
    """The number of clips and pieces that intervals are over."""
    return len((model_rows(document, STILL, "raw", where) or {})["curves_r"])


def cell(document: Document, rows: Array, measure: str) -> str:
    """A value with its interval where there are enough clips, (clips, seeds, sums)."""
    text = interval_text(document, rows, measure)
    return text if len(rows) >= FEWEST else text.partition(" ")[0]


def details(document: Document, plan: Plan) -> list[Part]:
    """Each curve, the differences from the reference with their p values, heat, and the other folds."""
    where = main_frames(document, main_fold(document))
    parts: list[Part] = ["## Details", "### Each curve", "r, and the sd ratio in parentheses."]
    parts += [curves_table(document, where)]
    measures = tuple(name for name in measures_of(document, where) if name != "curves_sd_ratio")
    if len(document["models"]) > 1 and units(document, where) >= FEWEST:
        parts += [
            f"### Differences from {document['reference']}",
            "Errors change by a share, r by a difference. p by paired permutation over clips or pieces, "
            "Holm-corrected, in parentheses where it does not reach 0.05.",
            tables.differences_table(document, "raw", where, measures),
        ]
    parts += [f"![{HEAT}](heat.png)\n\n*{HEAT}.*"]
    for fold, title, frames in _other_folds(document):
        parts += [f"### {title}", plan.notes.get(fold.rstrip("*"), "")]
        for frame, heading in frames.items():
            parts += [heading, _values(document, f"{fold}/{frame}")]
    return [part for part in parts if part]


def _other_folds(document: Document) -> list[tuple[str, str, dict[str, str]]]:
    """Folds beside the main one: their names, titles, and headings by frames."""
    names, found = document["folds"], []
    if "unseen speakers" in names:
        found.append(("unseen speakers", "Speakers that training lacks", {"all": "All frames:"}))
    if any(name.startswith("words") for name in names):
        frames = {"clip": "Speech of the clips:", "word": "The withheld words:"}
        found.append(("words*", "Withheld words", frames))
    if "phones" in names:
        found.append(("phones", "Withheld phones", {"near": "The phones and their neighbours:"}))
    return found


def _values(document: Document, where: str) -> Table:
    known = measures_of(document, where)
    rows = [["model", *[MEASURES[name].heading for name in known]]]
    for name in document["models"]:
        found = seeded_rows(document, name, "raw", where)
        if found is not None:
            rows.append([name, *[cell(document, found[measure], measure) for measure in known]])
    return rows


def curves_table(document: Document, where: str) -> Table:
    """A row for each curve, a column for each model that moves: r and the sd ratio."""
    columns, names = [], []
    for name in document["models"]:
        found = model_rows(document, name, "raw", where)
        if found is not None and name != STILL:
            total = found["curves_r"].sum(axis=0)
            columns.append(zip(curve_r(total), curve_sd_ratio(total), strict=True))
            names.append(name)
    cells = [[f"{r:.2f} ({sd:.2f})" if np.isfinite(r) else NOTHING for r, sd in column] for column in columns]
    return [["curve", *names], *[list(row) for row in zip(document["curves"], *cells, strict=True)]]


def draw_figures(document: Document, folder: Path) -> None:
    """Draw bars.png and heat.png."""
    folder.mkdir(parents=True, exist_ok=True)
    where = main_frames(document, main_fold(document))
    error = KINDS[document["kind"]][0]
    names = [name for name in document["models"] if model_rows(document, name, "raw", where) is not None]
    shown = [
        plots.Shown(name, document["models"][name]["driven_by"], name == document["reference"])
        for name in names
    ]
    panels = {
        MEASURES[measure].heading: np.array([_bar(document, name, where, measure) for name in names])
        for measure in ("curves_r", error)
    }
    draw_file(lambda figure: plots.draw_bars(figure, shown, panels), folder / "bars.png")
    unit = document["corpus"]["unit"]
    draw_heat(Heat.from_facts(document["heat"]), folder / "heat.png", f", {unit}" if unit else "")


def _bar(document: Document, name: str, where: str, measure: str) -> Array:
    """A measure and its interval, or the measure alone three times; 0 where it is no number."""
    found = (seeded_rows(document, name, "raw", where) or {})[measure]
    value = measure_value(measure, found.sum(axis=1))
    alone = len(found) < FEWEST
    bounds = (value, value) if alone else interval(document, found, MEASURES[measure].statistic)
    return np.nan_to_num([value, *bounds])
