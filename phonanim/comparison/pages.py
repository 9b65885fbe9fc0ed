"""The long tables of a comparison, one page for each question: headings, notes, tables, pictures."""

from __future__ import annotations

from typing import Any

from phonanim.comparison import legibility, tables, tools
from phonanim.comparison.mouths import WHERE
from phonanim.comparison.plan import Plan
from phonanim.comparison.published import published_text
from phonanim.comparison.run import model_rows, seeded_rows
from phonanim.comparison.scores import measure_value
from phonanim.comparison.tables import Table

Document = dict[str, Any]
Part = str | Table  # a paragraph or heading, or a table
ERRORS = ("parameter_mse", "shape_mse", "vertex_error", "lip_error")
CURVES = ("aperture_r", "width_r", "speed_error", "pbm_gap")
TESTED = ("parameter_mse", "shape_mse", "aperture_r", "width_r")
PIXELS = ("joint_mse", "pixel_mse", "inner_pixel_mse", "outer_pixel_mse")
SHORT = ("shape_mse", "aperture_r", "width_r")


def all_pages(document: Document, plan: Plan, figures: list[str]) -> dict[str, list[Part]]:
    """The pages that have something to show, by the stems of their files; each begins with its title."""
    faces: list[Part] = ["## The test clips in pictures"]
    faces += [
        _picture(name) for name in ("first_mode", "first_mode_error", "heat") if f"{name}.png" in figures
    ]
    found = {
        "test": test_page(document, plan),
        "legibility": legibility_page(plan),
        "generalization": generalization_page(document, plan),
        "conditions": conditions_page(document, plan),
        "tools": tools_page(document, plan),
        "sweeps": sweeps_page(document, plan),
        "cost": cost_page(document, plan),
        "pictures": faces if len(faces) > 1 else [],
    }
    return {name: [part for part in parts if part] for name, parts in found.items() if parts}


def test_page(document: Document, plan: Plan) -> list[Part]:
    """Every measure of every model on the test clips."""
    parts: list[Part] = ["## Test clips", plan.notes.get("test", "")]
    for variant, title in (("raw", "As predicted"), ("contacts", "With the closures that `animate` adds")):
        parts += [f"### {title}", scored_text(document, "test/all")]
        parts += [tables.values_table(document, variant, "test/all", m) for m in (ERRORS, CURVES)]
        parts += [tables.differences_table(document, variant, "test/all", TESTED)]
    parts += [f"In speech alone, as predicted. {scored_text(document, 'test/speech')}"]
    parts += [tables.values_table(document, "raw", "test/speech", SHORT)]
    parts += [tables.differences_table(document, "raw", "test/speech", SHORT)]
    parts += ["### How far it moves"]
    parts += [
        "In speech, as predicted. A slope or ratio below 1 is under-articulation. "
        f"{scored_text(document, 'test/speech')}"
    ]
    parts += [tables.size_table(document, "raw", "test/speech")]
    return [*parts, _picture("bars"), _picture("sentences"), *_pixels(document, plan)]


def legibility_page(plan: Plan) -> list[Part]:
    """Models with and without articulation."""
    if plan.legibility is None:
        return []
    found = legibility.read_legibility(plan.legibility)
    parts: list[Part] = ["## Articulation and legibility", plan.notes.get("legibility", "")]
    parts += ["### Against captured lips", legibility.film_table(found)]
    if found["sensors"]:
        parts += ["### Against sensors of other speakers", plan.notes.get("sensors", "")]
        parts += [legibility.sensor_table(found)]
    return parts


def _pixels(document: Document, plan: Plan) -> list[Part]:
    if "pixel_bound" not in document:
        return []
    drawn = tables.values_table(document, "raw", WHERE, PIXELS)
    tested = tables.differences_table(document, "raw", WHERE, PIXELS[:2])
    bound = (
        f"The appearance model itself leaves {measure_value('pixel_mse', document['pixel_bound']):.2f} grey²."
    )
    note = plan.notes.get("pixels", "")
    return ["### Drawn as a mouth", note, scored_text(document, "test/all"), drawn, bound, tested]


def generalization_page(document: Document, plan: Plan) -> list[Part]:
    """Words and phones that were withheld, and articulography of another speaker."""
    parts: list[Part] = []
    sections = {
        "words": (("words*/clip", "Withheld words"), ("words*/word", "The withheld words alone")),
        "phones": (("phones/near", "Withheld phones"),),
    }
    for note, found in sections.items():
        for where, title in found:
            if model_rows(document, document["reference"], "raw", where) is None:
                continue
            parts += [f"### {title}"]
            parts += [plan.notes.get(note, "")] if where != "words*/word" else []
            parts += [scored_text(document, where), tables.values_table(document, "raw", where, SHORT)]
            parts += [
                tables.differences_table(document, "raw", where, SHORT),
                tables.size_table(document, "raw", where),
                _absent(document, where),
            ]
    spoken = tables.ema_table(document)
    if spoken:
        parts += ["### Another speaker, another language", plan.notes.get("ema", ""), spoken]
    return ["## Words, phones and speakers that training lacks", *parts] if parts else []


def scored_text(document: Document, where: str) -> str:
    """How many seconds of whose speech a table rests on, and over how many seeds."""
    rows = seeded_rows(document, document["reference"], "raw", where)
    assert rows is not None
    clips = len(rows["shape_mse"])
    seconds = rows["shape_mse"][:, 0, 1].sum() / document["corpus"].get("fps", 25.0)
    source, seeds = document["corpus"]["source"], _seeds(document, where)
    return f"Scored on {seconds:.0f} s in {clips} clips of {source}{seeds}."


def _seeds(document: Document, where: str) -> str:
    """How often the models of a table are trained, where it is more than once."""
    found = {name: seeded_rows(document, name, "raw", where) for name in document["models"]}
    counts = {name: rows["shape_mse"].shape[1] for name, rows in found.items() if rows is not None}
    most, once = max(counts.values()), [f"`{name}`" for name, count in counts.items() if count == 1]
    if most == 1:
        return ""
    if not once:
        return f"; every model is trained with {most} seeds, which the intervals cover"
    return f"; trained with {most} seeds, which the intervals cover, except {', '.join(once)}: these once"


def _absent(document: Document, where: str) -> str:
    """The models that a table lacks, because they were trained for the test clips only."""
    absent = [f"`{name}`" for name in document["models"] if model_rows(document, name, "raw", where) is None]
    return f"Not trained again for this: {', '.join(absent)}." if absent else ""


def conditions_page(document: Document, plan: Plan) -> list[Part]:
    """For each measure: the scores, the loss of each model, and its difference from the reference."""
    if not document.get("conditions"):
        return []
    parts: list[Part] = ["## Noise, another voice, an automatic aligner", plan.notes.get("conditions", "")]
    parts += [tables.aligner_table(document), _picture("conditions"), scored_text(document, "test/all")]
    for measure in SHORT:
        asked = document, "raw", "all", measure
        parts += [f"### Under each condition: {tables.measure_heading(measure)}"]
        parts += [
            tables.conditions_table(*asked),
            "Change from the model's own clean score, and its p:",
        ]
        parts += [
            tables.losses_table(*asked),
            "Difference from the reference under the same condition, and its p:",
        ]
        parts += [tables.conditions_difference_table(*asked)]
    parts += [f"### Under each condition: {tables.measure_heading('aperture_r')}, in speech alone"]
    parts += [tables.conditions_table(document, "raw", "speech", "aperture_r")]
    parts += [
        f"### Under each condition: {tables.measure_heading('pbm_gap')}, with the closures of `animate`"
    ]
    return [*parts, tables.conditions_table(document, "contacts", "all", "pbm_gap")]


def sweeps_page(document: Document, plan: Plan) -> list[Part]:
    """One recipe with several values of a setting."""
    parts: list[Part] = []
    for name, found in document.get("sweeps", {}).items():
        parts += [f"### {found['label']}", plan.notes.get(name, "")]
        if "seconds" in found:
            source = document["corpus"]["source"]
            parts += [f"Scored on {found['seconds']:.0f} s in {found['clips']} clips of {source}."]
        parts += [tables.sweep_table(found, "shape_mse")]
        if all("speech_shape_mse" in row for row in found["rows"]):
            parts += ["In speech alone:", tables.sweep_table(found, "speech_shape_mse")]
        parts += [_picture(f"sweep_{name}", f"{found['label']}: shape error on held-out training clips")]
    return ["## Settings and amounts of data, one at a time", *parts] if parts else []


def cost_page(document: Document, plan: Plan) -> list[Part]:
    """What a model costs."""
    table = tables.cost_table(document)
    note = plan.notes.get("cost", "")
    parts: list[Part] = ["## Speed and size", note, published_text(document), table]
    return [*parts, _effort(document["effort"]), _picture("cost")]


def _effort(effort: dict[str, float]) -> str:
    """Processor time of the whole comparison; trainings are spread over two workers."""
    if not effort["jobs"]:
        return ""
    halved = max(effort["training_s"] / 2, effort["longest_s"])
    jobs = "training" if effort["jobs"] == 1 else f"{effort['jobs']:.0f} trainings"
    return (
        f"The {jobs} of this comparison, folds, mouths and sweeps among them, took "
        f"{_duration(effort['training_s'])} of a processor: about {_duration(halved)} with two workers. "
        f"Scoring took another {_duration(effort['scoring_s'])}."
    )


def _duration(seconds: float) -> str:
    return f"{seconds / 60:.0f} minutes" if seconds >= 120 else f"{seconds:.0f} s"


def tools_page(document: Document, plan: Plan) -> list[Part]:
    """Other tools on the same clips."""
    if "tools" not in document:
        return []
    rows = tools.tools_table(document["tools"], document["seed"])
    note = plan.notes.get("tools", "")
    return ["## Other tools on the same head", note, scored_text(document, "test/all"), rows]


CAPTIONS = {
    "bars": "Vertex error, and lip gap in speech, of every model on the test clips, with 95 % intervals",
    "sentences": "Parameter error of every test sentence by model, sorted by the error of the reference",
    "first_mode": "First shape mode of one test clip over time: captured, and predicted by each model",
    "first_mode_error": "Squared error of the first shape mode over the same clip, for each model",
    "heat": "Mean error of each landmark on the mean face, for each model, in millimetres",
    "conditions": "Aperture correlation of every model, on clean sound and under each condition",
    "cost": "Speed of every model against its shape error; the area of a dot is the model's size",
}
"""What each figure shows; that of a sweep is its label."""


def _picture(name: str, caption: str = "") -> str:
    """A picture with its alternative text, and the same text below it."""
    caption = caption or CAPTIONS[name]
    return f"![{caption}]({name}.png)\n\n*{caption}.*"
