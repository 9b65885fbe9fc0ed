"""Write benchmark.md and its figures from the document of a comparison."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from phonanim.comparison import legibility, tables, tools
from phonanim.comparison.figures import draw_all
from phonanim.comparison.fit import load_cached_corpus, reference_face
from phonanim.comparison.mouths import WHERE
from phonanim.comparison.plan import Plan
from phonanim.comparison.run import model_rows
from phonanim.comparison.scores import measure_value
from phonanim.comparison.tables import markdown
from phonanim.core.decode import read_json
from phonanim.core.files import write_text
from phonanim.errors import ModelError

Document = dict[str, Any]
DATA = "benchmark"
ERRORS = ("parameter_mse", "shape_mse", "vertex_error", "lip_error")
CURVES = ("aperture_r", "width_r", "speed_error", "pbm_gap")
TESTED = ("parameter_mse", "shape_mse", "aperture_r", "width_r")
PIXELS = ("joint_mse", "pixel_mse", "inner_pixel_mse", "outer_pixel_mse")
SHORT = ("shape_mse", "aperture_r", "width_r")
SHOWN = {"default": "phonanim", "procedural": "dominance (Cohen-Massaro)"}
"""Names of models in tables and figures, for models whose own names are unclear."""


def write_document(document: Document, folder: Path) -> Path:
    """Write benchmark/benchmark.json: every sum of every clip, from which any statistic can be computed."""
    path = folder / DATA / "benchmark.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(document, separators=(",", ":")) + "\n")
    return path


def read_document(folder: Path) -> Document:
    """Read the output of `write_document`. Raises ModelError when it is missing, or of an older version."""
    path = folder / DATA / "benchmark.json"
    try:
        found: Document = read_json(path)
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read as a comparison ({error}); run it first") from error
    if not isinstance(found, dict) or "effort" not in found:
        raise ModelError(f"{path}: was written by an older version; run the comparison again")
    return found


def write_report(document: Document, plan: Plan, folder: Path) -> Path:
    """Write benchmark.md into a folder, and its figures into benchmark/ next to it."""
    document = with_shown_names(document)
    corpus = load_cached_corpus(plan.corpus)
    face = reference_face(plan.corpus, tuple(corpus.clips_of("train").tolist()))
    clip = corpus.clips.index(document["folds"]["test"]["clips"][0])
    captured = face.project(corpus.landmarks[corpus.rows([clip])])[:, 0]
    figures = draw_all(document, face, corpus.fps, captured, "raw", folder / DATA)
    parts = [_opening(document), *_test(document, plan), *_legibility(plan)]
    parts += [*_generalization(document, plan), *_conditions(document, plan)]
    parts += [*_sweeps(document, plan), *_cost(document, plan), *_tools(document, plan)]
    parts += [_picture(name) for name in ("first_mode", "heat") if f"{name}.png" in figures]
    path = folder / "benchmark.md"
    write_text(path, "\n\n".join(part for part in parts if part) + "\n")
    return path


def with_shown_names(document: Document) -> Document:
    """The document with the shown names of its models, in the same order."""
    models = {SHOWN.get(name, name): found for name, found in document["models"].items()}
    reference = document["reference"]
    return {**document, "models": models, "reference": SHOWN.get(reference, reference)}


def _opening(document: Document) -> str:
    corpus, folds = document["corpus"], document["folds"]
    return (
        "# The comparison\n\n"
        f"Every model below learned from the same {folds['test']['train']} clips and is measured on the same "
        f"{len(folds['test']['clips'])} test clips of {corpus['source']}. Square brackets hold 95 % "
        "intervals by bootstrap over sentences; p values are of paired permutation tests over sentences, "
        "Holm-corrected within a table, in parentheses where they do not reach 0.05. "
        "The measures are those of `phonanim evaluate`; all sums are in benchmark/benchmark.json."
    )


def _test(document: Document, plan: Plan) -> list[str]:
    parts = ["## Test clips", plan.notes.get("test", "")]
    for variant, title in (("raw", "As predicted"), ("contacts", "With the closures that `animate` adds")):
        parts += [f"### {title}"]
        parts += [markdown(tables.values_table(document, variant, "test/all", m)) for m in (ERRORS, CURVES)]
        parts += [markdown(tables.differences_table(document, variant, "test/all", TESTED))]
    parts += ["In speech alone, as predicted:"]
    parts += [markdown(tables.values_table(document, "raw", "test/speech", SHORT))]
    parts += [markdown(tables.differences_table(document, "raw", "test/speech", SHORT))]
    return [*parts, _picture("bars"), _picture("sentences"), *_pixels(document, plan)]


def _legibility(plan: Plan) -> list[str]:
    if plan.legibility is None:
        return []
    found = legibility.read_legibility(plan.legibility)
    parts = ["## With articulation, and what can be read", plan.notes.get("legibility", "")]
    parts += ["### Against captured lips", markdown(legibility.film_table(found))]
    if found["sensors"]:
        parts += ["### Against sensors of other speakers", plan.notes.get("sensors", "")]
        parts += [markdown(legibility.sensor_table(found))]
    return parts


def _pixels(document: Document, plan: Plan) -> list[str]:
    if "pixel_bound" not in document:
        return []
    drawn = tables.values_table(document, "raw", WHERE, PIXELS)
    tested = tables.differences_table(document, "raw", WHERE, PIXELS[:2])
    bound = (
        f"The appearance model itself leaves {measure_value('pixel_mse', document['pixel_bound']):.2f} grey²."
    )
    parts = ["### Drawn as a mouth", plan.notes.get("pixels", ""), markdown(drawn), bound]
    return [*parts, markdown(tested)]


def _generalization(document: Document, plan: Plan) -> list[str]:
    parts: list[str] = []
    sections = {
        "words": (("words*/clip", "Words that were never heard"), ("words*/word", "In those words alone")),
        "phones": (("phones/near", "Phones that were never heard"),),
    }
    for note, found in sections.items():
        for where, title in found:
            if model_rows(document, document["reference"], "raw", where) is None:
                continue
            parts += [f"## {title}" if title != "In those words alone" else f"### {title}"]
            parts += [plan.notes.get(note, "")] if where != "words*/word" else []
            parts += [markdown(tables.values_table(document, "raw", where, SHORT))]
            parts += [
                markdown(tables.differences_table(document, "raw", where, SHORT)),
                _absent(document, where),
            ]
    spoken = tables.ema_table(document)
    if spoken:
        parts += ["## Another speaker, another language", plan.notes.get("ema", ""), markdown(spoken)]
    return parts


def _absent(document: Document, where: str) -> str:
    """The models that a table lacks, because they were trained for the test clips only."""
    absent = [f"`{name}`" for name in document["models"] if model_rows(document, name, "raw", where) is None]
    return f"Not trained again for this: {', '.join(absent)}." if absent else ""


def _conditions(document: Document, plan: Plan) -> list[str]:
    """For each measure: the scores, the loss of each model, and its difference from the reference."""
    if not document.get("conditions"):
        return []
    parts = ["## Noise, another voice, an automatic aligner", plan.notes.get("conditions", "")]
    parts += [markdown(tables.aligner_table(document)), _picture("conditions")]
    for measure in SHORT:
        asked = document, "raw", "all", measure
        parts += [f"### Under each condition: {tables.measure_heading(measure)}"]
        parts += [
            markdown(tables.conditions_table(*asked)),
            "Each change of the model's own clean score, and its p:",
        ]
        parts += [
            markdown(tables.losses_table(*asked)),
            "Each difference under the same condition, and its p:",
        ]
        parts += [markdown(tables.conditions_difference_table(*asked))]
    parts += [f"### Under each condition: {tables.measure_heading('aperture_r')}, in speech alone"]
    parts += [markdown(tables.conditions_table(document, "raw", "speech", "aperture_r"))]
    parts += [
        f"### Under each condition: {tables.measure_heading('pbm_gap')}, with the closures of `animate`"
    ]
    return [*parts, markdown(tables.conditions_table(document, "contacts", "all", "pbm_gap"))]


def _sweeps(document: Document, plan: Plan) -> list[str]:
    parts: list[str] = []
    for name, found in document.get("sweeps", {}).items():
        parts += [f"## {found['label']}", plan.notes.get(name, "")]
        parts += [markdown(tables.sweep_table(found, "shape_mse")), _picture(f"sweep_{name}")]
    return parts


def _cost(document: Document, plan: Plan) -> list[str]:
    table = markdown(tables.cost_table(document))
    note = plan.notes.get("cost", "")
    return ["## Speed and size", note, table, _effort(document["effort"]), _picture("cost")]


def _effort(effort: dict[str, float]) -> str:
    """Processor time of the whole comparison; trainings are spread over two workers."""
    if not effort["jobs"]:
        return ""
    total, scoring = effort["training_s"] / 60, effort["scoring_s"] / 60
    halved = max(total / 2, effort["longest_s"] / 60)
    return (
        f"The {effort['jobs']:.0f} trainings of this comparison, folds, mouths and sweeps among them, took "
        f"{total:.0f} minutes of a processor: about {halved:.0f} minutes with two workers. Scoring took "
        f"another {scoring:.0f}."
    )


def _tools(document: Document, plan: Plan) -> list[str]:
    if "tools" not in document:
        return []
    rows = markdown(tools.tools_table(document["tools"], document["seed"]))
    return ["## Other tools, through the same head", plan.notes.get("tools", ""), rows]


def _picture(name: str) -> str:
    return f"![{name.replace('_', ' ')}]({DATA}/{name}.png)"
