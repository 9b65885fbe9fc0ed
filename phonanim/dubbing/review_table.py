"""The list of a review as a table: each line with its flags, its decision, and who said what."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from phonanim.dubbing.decisions import Event, State
from phonanim.dubbing.review import list_entry
from phonanim.dubbing.review_line import Desk

COLUMNS = ("id", "decision", "who", "at", "comments", "corrections")
LISTED = ("status", "text", "language", "rig", "seconds", "place")
FORMULA = ("=", "+", "-", "@", "\t", "\r")


def review_csv(desk: Desk) -> str:
    """CSV in UTF-8, one row a line, the worst first."""
    states = desk.decisions.states()
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    table.writerow((*COLUMNS, *("flags" if name == "text" else name for name in LISTED)))
    for outcome in desk.review.outcomes:
        entry = list_entry(outcome, states.get(outcome.id, State()))
        events = desk.decisions.events(outcome.id) if outcome.id in states else []
        row = (entry["id"], entry["decision"], *_done(events), *(entry[name] for name in LISTED))
        table.writerow([_cell(str(value)) for value in row])
    return stream.getvalue()


def _done(events: Sequence[Event]) -> tuple[str, str, str, str]:
    """Who did the last thing and when, what was said, and what was corrected, the oldest first."""
    if not events:
        return "", "", "", ""
    corrected = [event.text for event in events if event.kind == "corrected" and not event.undone]
    return events[0].who, events[0].at, told_events(events), " | ".join(reversed(corrected))


def told_events(events: Sequence[Event]) -> str:
    """What people said of a line, the oldest first."""
    said = [f"{event.who}: {event.text}" for event in events if event.kind not in QUIET and event.text]
    return " | ".join(reversed(said))


QUIET = ("corrected", "undo")
"""Kinds of events whose text is not a comment."""


def _cell(text: str) -> str:
    """A cell that a spreadsheet shows and does not calculate."""
    return f"'{text}" if text.startswith(FORMULA) else text
