"""What the page of a line asks of a review: corrections, decisions, undo. JSON in, JSON out."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from phonanim.animation.animation import Animation
from phonanim.animation.correction_file import corrections_text, parse_settings, plain_settings
from phonanim.animation.corrections import WHOLE
from phonanim.articulation.styles import RANGES, read_styles
from phonanim.core.decode import DAMAGE, decode_list, decode_number, decode_table, decode_text, decode_whole
from phonanim.dubbing.correct_line import Points, Take, corrected, make_take, shown_head, shows_own_rig
from phonanim.dubbing.decisions import STATUSES, Change, Decisions, State
from phonanim.dubbing.languages import keep_expected
from phonanim.dubbing.line import Line
from phonanim.dubbing.review import NOTHING, PAGE, Review, delivered_page, delivered_take, line_corrections
from phonanim.errors import OptionError, PhonanimError
from phonanim.exporters.html import Extras, take_data, viewer_page
from phonanim.life.emotion import emotion_names
from phonanim.pipeline import load_cached_rig
from phonanim.rig.head import SHIPPED
from phonanim.speech.intervals import pack_intervals, unpack_intervals
from phonanim.speech.language_names import language_names

SCRIPTS = ("corrections.js", "bench.js", "editor.js")
LONGEST = 2000  # letters of a comment
POINTS = 100_000  # of a drawn curve


@dataclass(frozen=True, slots=True)
class Desk:
    """A review that people work on: its lines and its decisions."""

    review: Review
    decisions: Decisions


def line_page(desk: Desk, number: int, compare: bool, token: str, who: str) -> str:
    """The page of a line: made anew where its source is known, else as it was delivered."""
    line = _line(desk, number)
    if line is None:
        return delivered_page(desk.review, number)
    take = make_take(line, desk.review.folder, line_corrections(desk.review, line))
    beside = _previous(desk.review, number, line) if compare else None
    about = {"number": number, "token": token, "who": who, "compare": compare, **_about(desk, line, take)}
    extras = Extras(
        {"review": about | {"choices": _choices()}},
        (PAGE / "editor.css").read_text("utf-8"),
        "\n".join((PAGE / name).read_text("utf-8") for name in SCRIPTS),
        "'self'",
    )
    named = {**take.animation.provenance, "input": line.id, "name": "now"}
    animation = replace(take.animation, provenance=named)
    return viewer_page(animation, line.id, beside, shown_head(line), extras)


def correct_line(desk: Desk, number: int, asked: Mapping[str, Any]) -> dict[str, Any]:
    """Keep corrections of a line and make it anew. Raises ConflictError, and what making it raises."""
    line = _editable(desk, number)
    folder, revision = desk.review.folder, decode_whole(asked["revision"], "revision", 0, 2**53)
    before = make_take(line, folder, line_corrections(desk.review, line))
    spoken = unpack_intervals(decode_list(asked["spoken"], "the phones"))
    settings, style = parse_settings(asked["settings"]), decode_text(asked["style"], "the style")
    drawn = {channel: _points(points) for channel, points in decode_table(asked["drawn"], "curves").items()}
    wanted = corrected(before, line, folder, spoken, settings, style, drawn)
    take = make_take(line, folder, wanted)
    if take.fault and not before.fault:  # what cannot be made is not kept
        raise OptionError(take.fault)
    text = "" if wanted.empty else corrections_text(wanted)
    what = decode_text(asked["what"], "what was done")[:LONGEST]
    who = _who(asked)
    state = desk.decisions.record(Change(line.id, revision, who, "corrected", what, "", text))
    return _answer(desk, line, take, state)


def decide_line(desk: Desk, number: int, asked: Mapping[str, Any]) -> dict[str, Any]:
    """Approve, reject, reopen or comment a line. Raises ConflictError, OptionError."""
    id = desk.review.outcomes[number].id
    revision = decode_whole(asked["revision"], "revision", 0, 2**53)
    text, who = decode_text(asked["text"], "the comment").strip()[:LONGEST], _who(asked)
    status = asked.get("status")
    if status is None:
        if not text:
            raise OptionError("the comment is empty; write one")
        state = desk.decisions.record(Change(id, revision, who, "comment", text))
    else:
        if status not in STATUSES:
            raise OptionError(f"the status {status!r:.40} is not one of approved and rejected")
        state = desk.decisions.record(Change(id, revision, who, status or "reopened", text, status))
    return _decided(desk, id, state)


def undo_line(desk: Desk, number: int, asked: Mapping[str, Any]) -> dict[str, Any]:
    """Take back the last correction or decision of a line. Raises ConflictError, OptionError."""
    outcome, revision = desk.review.outcomes[number], decode_whole(asked["revision"], "revision", 0, 2**53)
    state = desk.decisions.undo(outcome.id, revision, _who(asked))
    line = _line(desk, number)
    if line is None:
        return _decided(desk, outcome.id, state)
    take = make_take(line, desk.review.folder, line_corrections(desk.review, line))
    return _answer(desk, line, take, state)


ACTIONS = {"/correct": correct_line, "/decide": decide_line, "/undo": undo_line}


def act(desk: Desk, path: str, asked: Any) -> dict[str, Any]:
    """The answer to a request of a page. Raises PhonanimError, which says what is wrong with it."""
    try:
        started = time.thread_time()
        table = decode_table(asked, "the request")
        number = decode_whole(table["line"], "line", 0, len(desk.review.outcomes) - 1)
        answer = ACTIONS[path](desk, number, table)
        answer["review"]["spent"] = round(1000 * (time.thread_time() - started))  # ms of processor time
        return answer
    except DAMAGE as error:
        raise OptionError(f"the request is damaged: {error}") from error


def _line(desk: Desk, number: int) -> Line | None:
    """The line of the source, as the run made it."""
    outcome = desk.review.outcomes[number]
    line = desk.review.lines.get(outcome.id)
    return None if line is None else keep_expected(line, outcome)


def _editable(desk: Desk, number: int) -> Line:
    line = _line(desk, number)
    if line is None:
        raise OptionError("the source of this line is not known; give --source to correct it")
    return line


def _previous(review: Review, number: int, line: Line) -> Animation:
    """The take to compare with: the one that was delivered, or else the line without corrections."""
    if shown_head(line) == SHIPPED:
        try:
            found = delivered_take(review, review.outcomes[number])
            return replace(found, provenance={**found.provenance, "name": "delivered"})
        except PhonanimError:
            pass
    found = make_take(line, review.folder, NOTHING).animation
    return replace(found, provenance={**found.provenance, "name": "uncorrected"})


def _about(desk: Desk, line: Line, take: Take, state: State | None = None) -> dict[str, Any]:
    """A line for its page, besides its curves."""
    state = state or desk.decisions.state(line.id)
    corrections = take.corrections
    drawn = sorted({edit.channel for edit in corrections.curves.edits}) if corrections.curves else []
    notes = (
        [] if shows_own_rig(line) else [f"shown on {take.animation.rig}; the line moves {line.options.rig}"]
    )
    return {
        "id": line.id,
        "revision": state.revision,
        "status": state.status,
        "events": [asdict(event) for event in desk.decisions.events(line.id)],
        "read": pack_intervals(take.read),
        "settings": plain_settings(corrections.settings),
        "style": corrections.style,
        "drawn": drawn,
        "controls": list(load_cached_rig(line.options.rig).controls),
        "now": plain_settings({name: getattr(take.options, name) for name in NOW}),
        "notes": [*notes, *take.notes],
    }


NOW = (*WHOLE, "gains", "emotions", "closures")


def _choices() -> dict[str, Any]:
    """What may be chosen for a line."""
    return {
        "styles": {name: dict(dials) for name, dials in read_styles().items()},
        "languages": ["auto", *language_names()],
        "emotions": list(emotion_names()),
        "dials": {name: list(limits) for name, limits in RANGES.items()},
    }


def _answer(desk: Desk, line: Line, take: Take, state: State) -> dict[str, Any]:
    return {"take": take_data(take.animation), "review": _about(desk, line, take, state)}


def _decided(desk: Desk, id: str, state: State) -> dict[str, Any]:
    events = [asdict(event) for event in desk.decisions.events(id)]
    return {"review": {"revision": state.revision, "status": state.status, "events": events}}


def _who(asked: Mapping[str, Any]) -> str:
    return decode_text(asked["who"], "who").strip()[:100] or "unknown"


def _points(points: Any) -> Points:
    items = decode_list(points, "a curve")
    if len(items) > POINTS:
        raise OptionError(f"a drawn curve has {len(items)} points; draw at most {POINTS}")
    return [(decode_number(time, "a time"), decode_number(value, "a value")) for time, value in items]
