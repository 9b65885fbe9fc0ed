"""The review of a run: its lines, what a page lists of them, and the page that plays one of them."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from phonanim.animation.animation import Animation
from phonanim.animation.correction_file import parse_corrections
from phonanim.animation.corrections import Corrections
from phonanim.animation.other_rig import move_to_rig
from phonanim.core.decode import DAMAGE, read_utf8
from phonanim.core.files import make_folder_within, write_text
from phonanim.core.pages import fill_page, script_data
from phonanim.dubbing.align_lines import SOUND, SUFFIX, sound_place
from phonanim.dubbing.decisions import Decisions, State
from phonanim.dubbing.ledger import read_ledger
from phonanim.dubbing.line import Line
from phonanim.dubbing.lines import Lines
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.report import worst_first
from phonanim.dubbing.row import CORRECTIONS
from phonanim.dubbing.run import fault_outcomes
from phonanim.errors import OptionError, OutputError
from phonanim.exporters import find_exporter, load, needed_rig
from phonanim.exporters.html import viewer_page
from phonanim.inputs.alignment import read_alignment

PAGE = Path(__file__).parent / "page"
RICHEST = (".npz", ".json", ".glb", ".gltf")  # the formats that hold phones, and so are shown first
NOTHING = Corrections()


@dataclass(frozen=True, slots=True)
class Review:
    """The lines of a run, the worst first, its folder, and the lines of its source by id, if one is known."""

    folder: Path
    outcomes: tuple[Outcome, ...]
    lines: Mapping[str, Line] = field(default_factory=dict)

    def decisions(self) -> Decisions:
        """The decisions on these lines, beside which corrections are kept."""
        return Decisions(self.folder, self.keep)

    def keep(self, id: str, text: str | None) -> str:
        """Write the corrections of a line ("" removes them, None keeps them); returns what was there."""
        if id not in self.lines:
            return ""
        path = corrections_path(self, self.lines[id])
        before = path.read_text("utf-8") if path.is_file() else ""
        if text is not None:
            make_folder_within(path.parent, self.folder)
        if text:
            write_text(path, text)
        elif text is not None:
            path.unlink(missing_ok=True)
        return before


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


def corrections_path(review: Review, line: Line) -> Path:
    """Where the corrections of a line are kept."""
    return review.folder / f"{line.output}{CORRECTIONS}"


def line_corrections(review: Review, line: Line) -> Corrections:
    """The corrections of a line. Raises OptionError where their file is damaged."""
    path = corrections_path(review, line)
    if not path.is_file():
        return NOTHING
    try:
        return parse_corrections(read_utf8(path))
    except (OSError, *DAMAGE) as error:
        raise OptionError(f"{path}: is not a file of corrections: {error}; move it away") from error


def list_page(review: Review, decisions: Decisions, token: str, who: str = "") -> str:
    """The page that lists the lines; it asks the server for each with `token`."""
    states = decisions.states()
    entries = [list_entry(outcome, states.get(outcome.id, State())) for outcome in review.outcomes]
    return list_of(review, entries, {"token": token, "who": who, "last": decisions.news(0)[0]})


def list_of(review: Review, entries: list[dict[str, Any]], about: Mapping[str, Any]) -> str:
    """The page of a list of lines, which are pages of a server, or of files beside it."""
    fields = {
        "title": html.escape(f"{review.folder.resolve().name}: {len(entries)} lines"),
        "style": (PAGE / "review.css").read_text("utf-8"),
        "data": script_data({**about, "lines": entries}),
        "script": (PAGE / "review.js").read_text("utf-8"),
    }
    page = (PAGE / "review.html").read_text("utf-8")
    return fill_page(page, fields, "'self'", frames="'self' file:" if about.get("fixed") else "'self'")


def list_entry(outcome: Outcome, state: State) -> dict[str, Any]:
    """What the list shows of a line."""
    language = outcome.facts.get("language") or {}
    flags = outcome.facts.get("flags", ())
    return {
        "id": outcome.id,
        "place": outcome.place,
        "status": "failed" if not outcome.done else "flagged" if flags else "good",
        "decision": state.status,
        "revision": state.revision,
        "comments": state.comments,
        "rig": Path(str(outcome.origin.get("options", {}).get("rig", ""))).stem,
        "language": str(language.get("name", "")),
        "seconds": outcome.facts.get("seconds", 0),
        "checks": [flag["check"] for flag in flags],
        "text": outcome.error or "; ".join(f"{flag['check']}: {flag['text']}" for flag in flags),
    }


def delivered_page(review: Review, number: int) -> str:
    """The viewer of a line as it was delivered. Raises OutputError where no output can be shown."""
    outcome = review.outcomes[number]
    animation = delivered_take(review, outcome)
    return viewer_page(
        replace(animation, provenance={**animation.provenance, "input": outcome.id}), outcome.id
    )


def delivered_take(review: Review, outcome: Outcome) -> Animation:
    """The output of a line, on a rig that the shipped head shows. Raises OutputError."""
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
    return animation


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
