"""The review of a run: what a page lists of its lines, and the page that plays one of them."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from phonanim.animation.other_rig import move_to_rig
from phonanim.core.pages import fill_page, script_data
from phonanim.dubbing.align_lines import SOUND, SUFFIX, sound_place
from phonanim.dubbing.ledger import read_ledger
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Lines
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.report import worst_first
from phonanim.dubbing.run import fault_outcomes
from phonanim.errors import OptionError, OutputError
from phonanim.exporters import find_exporter, load, needed_rig, save
from phonanim.inputs.alignment import read_alignment

PAGE = Path(__file__).parent / "page"
RICHEST = (".npz", ".json", ".glb", ".gltf")  # the formats that hold phones, and so are shown first


@dataclass(frozen=True, slots=True)
class Review:
    """The lines of a run, the worst first, its folder, and the lines of its source by id, if one is given."""

    folder: Path
    outcomes: tuple[Outcome, ...]
    lines: Mapping[str, Line]


def open_review(folder: Path, source: Lines | None = None) -> Review:
    """Read the ledger of a run; with a source, its lines alone, and its invalid rows.

    Raises OptionError where there is no ledger.
    """
    known = read_ledger(folder)
    if not known:
        raise OptionError(f"{folder}: has no ledger of a run; name the output folder of phonanim batch")
    if source is None:
        return Review(folder, tuple(worst_first(known.values())), {})
    by_id = {line.id: line for line in source.lines}
    chosen = [outcome for outcome in known.values() if outcome.id in by_id]
    return Review(folder, tuple(worst_first([*chosen, *fault_outcomes(source)])), by_id)


def list_page(review: Review, token: str) -> str:
    """The page that lists the lines; it asks the server for each with `token`."""
    data = {"token": token, "lines": [_entry(outcome) for outcome in review.outcomes]}
    fields = {
        "title": f"{review.folder.name}: {len(review.outcomes)} lines",
        "style": (PAGE / "review.css").read_text("utf-8"),
        "data": script_data(data),
        "script": (PAGE / "review.js").read_text("utf-8"),
    }
    return fill_page((PAGE / "review.html").read_text("utf-8"), fields, frames="'self'")


def line_page(review: Review, number: int) -> str:
    """The viewer of a line, by its place in the list. Raises OutputError where no output can be shown."""
    outcome = review.outcomes[number]
    path = _shown_output(review.folder, outcome)
    animation = load(path)
    if rig := needed_rig(Path("line.html"), animation.channels):
        moved = move_to_rig(animation, rig)
        if moved is None:
            raise OutputError(f"{path}: its rig {animation.rig} cannot be shown on the shipped head")
        animation = moved[0]
    line = review.lines.get(outcome.id)
    given = sound_place(line, review.folder) if line is not None else None
    sound = given if isinstance(given, Path) else animation.audio
    animation = replace(animation, audio=sound if sound is not None and sound.is_file() else None)
    if line is not None and not animation.phones and line.text is None and isinstance(line.alignment, Path):
        options = line.options
        read = read_alignment(line.alignment, options.tier, options.speaker, options.lexicon)
        animation = replace(animation, phones=read.intervals, words=read.words)
    animation = replace(animation, provenance={**animation.provenance, "input": outcome.id})
    with tempfile.TemporaryDirectory(prefix="phonanim-") as folder:
        page = Path(folder) / "line.html"
        save(animation, page)
        return page.read_text("utf-8")


def _shown_output(folder: Path, outcome: Outcome) -> Path:
    """The output of a line that holds the most of what can be shown. Raises OutputError."""
    if not outcome.done:
        raise OutputError(f"{outcome.id}: failed: {outcome.error}")
    paths = [folder / name for name in outcome.outputs if not name.endswith((SUFFIX, SOUND))]
    paths = [path for path in paths if hasattr(find_exporter(path), "read")]
    if not paths:
        raise OutputError(f"{outcome.id}: no output can be read back; add --format npz to the batch")
    ranked = {suffix: place for place, suffix in enumerate(RICHEST)}
    return min(paths, key=lambda path: (ranked.get(path.suffix, len(RICHEST)), path.name))


def _entry(outcome: Outcome) -> dict[str, Any]:
    """What the list shows of a line."""
    language = outcome.facts.get("language") or {}
    flags = outcome.facts.get("flags", ())
    return {
        "id": outcome.id,
        "place": outcome.place,
        "status": "failed" if not outcome.done else "flagged" if flags else "good",
        "rig": Path(str(outcome.origin.get("options", {}).get("rig", ""))).stem,
        "language": str(language.get("name", "")),
        "seconds": outcome.facts.get("seconds", 0),
        "checks": [flag["check"] for flag in flags],
        "text": outcome.error or "; ".join(f"{flag['check']}: {flag['text']}" for flag in flags),
    }
