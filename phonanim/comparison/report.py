"""Write the report of a comparison: one page that can be read, the long tables behind it, and its figures."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from phonanim.comparison.figures import draw_all
from phonanim.comparison.fit import load_cached_corpus, reference_face
from phonanim.comparison.overview import overview_table, spoken_seconds
from phonanim.comparison.pages import CAPTIONS, Part, all_pages
from phonanim.comparison.plan import Plan
from phonanim.comparison.published import published_text, write_published
from phonanim.comparison.tables import SHOWN, markdown
from phonanim.core.decode import read_json
from phonanim.core.files import make_folder_within, write_text
from phonanim.errors import ModelError

Document = dict[str, Any]
DATA = "benchmark"  # the folder of pages, figures and tables beside benchmark.md
SUMS = "sums.json"


def write_document(document: Document, work: Path) -> Path:
    """Write sums.json into the folder of models: every sum of every clip, for any statistic."""
    path = work / SUMS
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(document, separators=(",", ":")) + "\n")
    return path


def read_document(work: Path) -> Document:
    """Read the output of `write_document`. Raises ModelError when it is missing, or of an older version."""
    path = work / SUMS
    try:
        found: Document = read_json(path)
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read as a comparison ({error}); run it first") from error
    if not isinstance(found, dict) or "effort" not in found:
        raise ModelError(f"{path}: was written by an older version; run the comparison again")
    return found


def write_report(document: Document, plan: Plan, folder: Path) -> Path:
    """Write benchmark.md into a folder; into benchmark/ its figures, the pages of long tables, all tables
    (benchmark.json), and the sums of the test clips (test_sums.json), which another plan may name.
    """
    write_published(document, make_folder_within(folder / DATA, folder))
    document = with_shown_names(document)
    corpus = load_cached_corpus(plan.corpus)
    face = reference_face(plan.corpus, tuple(corpus.clips_of("train").tolist()))
    clip = corpus.clips.index(document["folds"]["test"]["clips"][0])
    captured = face.project(corpus.landmarks[corpus.rows([clip])])[:, 0]
    figures = draw_all(document, face, corpus.fps, captured, "raw", folder / DATA)
    pages = all_pages(document, plan, figures)
    return write_pages(_overview(document, plan, pages, spoken_seconds(corpus)), pages, folder)


def write_pages(overview: list[Part], pages: dict[str, list[Part]], folder: Path) -> Path:
    """Write benchmark.md, and into benchmark/ the other pages and all tables as JSON."""
    for name, parts in pages.items():
        write_text(folder / DATA / f"{name}.md", render(parts))
    write_text(folder / DATA / "benchmark.json", list_tables({"": overview, **pages}))
    path = folder / "benchmark.md"
    write_text(path, "\n\n".join(_text(part) for part in overview) + "\n")
    return path


def with_shown_names(document: Document) -> Document:
    """The document with the shown names of its models, in the same order, also in sweeps over models."""
    models = {SHOWN.get(name, name): found for name, found in document["models"].items()}
    reference = document["reference"]
    sweeps = {name: _with_shown_rows(found) for name, found in document.get("sweeps", {}).items()}
    shown = {**document, "models": models, "reference": SHOWN.get(reference, reference)}
    return shown | {"sweeps": sweeps} if sweeps else shown


def _with_shown_rows(sweep: dict[str, Any]) -> dict[str, Any]:
    rows = [
        row | {"model": SHOWN.get(row["model"], row["model"])} if "model" in row else row
        for row in sweep["rows"]
    ]
    return {**sweep, "rows": rows}


def render(parts: list[Part]) -> str:
    """A page in benchmark/: its first heading is its title, and its links to pages go one folder up."""
    text = "\n\n".join(_text(part) for part in parts) + "\n"
    text = re.sub(r"^##(#?) ", r"#\1 ", text, flags=re.MULTILINE)
    back = "Back to [the benchmark](../benchmark.md), which explains intervals and p values.\n"
    return re.sub(r"\]\((?!https?:)([^)#]+\.md)", r"](../\1", text) + "\n" + back


def list_tables(pages: dict[str, list[Part]]) -> str:
    """All tables as JSON, in the order of the pages: `page`, the `heading` above it, and its `rows`."""
    found, heading = [], ""
    for page, parts in pages.items():
        for part in parts:
            if isinstance(part, list):
                found.append({"page": page, "heading": heading, "rows": part})
            elif part.startswith("#"):
                heading = part.lstrip("# ")
    lines = ",\n".join(json.dumps(table, ensure_ascii=False) for table in found)
    return f"[\n{lines}\n]\n"


def _overview(
    document: Document, plan: Plan, pages: dict[str, list[Part]], seconds: tuple[float, float]
) -> list[Part]:
    """The page that can be read on its own."""
    corpus, folds = document["corpus"], document["folds"]
    links = [f"- [{_title(parts)}]({DATA}/{name}.md)" for name, parts in pages.items()]
    opening = (
        f"This page compares predicted motion with captured lips. Every model learned from the same "
        f"{folds['test']['train']} clips of {corpus['source']} and is scored on the same "
        f"{len(folds['test']['clips'])} others: {seconds[0]:.0f} s, of which {seconds[1]:.0f} s are speech."
    )
    legend = (
        "Aperture and width are measured in speech, pooled over its frames; the error over all frames. The "
        "sd ratio is the deviation of the predicted curve divided by that of the captured one, 1 at best: "
        "correlation does not detect a mouth that moves too little. Brackets hold 95 % intervals by "
        "bootstrap over sentences. In the long tables p values are of paired permutation tests over "
        "sentences, Holm-corrected within a table, in parentheses where they do not reach 0.05. The measures "
        "are those of `phonanim evaluate` ([measures](measures.md))."
    )
    picture = f"![{CAPTIONS['bars']}]({DATA}/bars.png)\n\n*{CAPTIONS['bars']}.*"
    table = overview_table(document, plan)
    command = "```\nphonanim compare benchmarks/compare.toml -o docs --work work/compare\n```"
    made = f"The tables are made by a plan ([comparing models](comparison.md)), such as\n\n{command}"
    parts: list[Part] = ["# Benchmark", opening, made, picture, table, legend]
    parts += [text for text in [published_text(document)] if text]
    if plan.notes.get("overview"):
        parts += ["## What the table shows", plan.notes["overview"]]
    data = (
        f"All tables as JSON: [benchmark.json]({DATA}/benchmark.json). The sums of every test clip, with "
        "which a model of your own joins these tables ([how](comparison.md#a-plan-of-your-own)): "
        f"[test_sums.json]({DATA}/test_sums.json)."
    )
    return [*parts, "## The long tables", "\n".join(links), data]


def _title(parts: list[Part]) -> str:
    return str(parts[0]).lstrip("# ")


def _text(part: Part) -> str:
    return markdown(part) if isinstance(part, list) else part
