"""A review to send: a folder of pages that need no server, with the lines as they are now."""

from __future__ import annotations

import html
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import Any

from phonanim.core.files import make_folder_within, write_text
from phonanim.core.pages import page_policy
from phonanim.dubbing.correct_line import make_take, shown_head
from phonanim.dubbing.decisions import State
from phonanim.dubbing.languages import keep_expected
from phonanim.dubbing.review import (
    PAGE,
    Review,
    delivered_take,
    line_corrections,
    list_entry,
    list_of,
)
from phonanim.dubbing.review_line import Desk
from phonanim.dubbing.review_table import review_csv, told_events
from phonanim.errors import PhonanimError
from phonanim.exporters.html import Extras, viewer_page, viewer_script
from phonanim.rig.head import SHIPPED
from phonanim.viewer.page import base64_text

KINDS = ("failed", "flagged", "good", "approved", "rejected", "undecided", "commented")
LINES = "lines"


def export_review(
    desk: Desk, folder: Path, only: Collection[str] = (), tell: Callable[[float], None] = lambda share: None
) -> int:
    """Write index.html, review.csv, a page for each line and what these share; returns the number of lines.

    `only` are kinds of lines (`KINDS`), all by default; `tell` is called with the share that is done. Raises
    OutputError when the folder cannot be written.
    """
    states = desk.decisions.states()
    chosen = [
        outcome
        for outcome in desk.review.outcomes
        if not only or set(only) & set(_kinds(list_entry(outcome, states.get(outcome.id, State()))))
    ]
    sent = replace(desk.review, outcomes=tuple(chosen))
    make_folder_within(folder / LINES, folder)
    heads: dict[Path, str] = {}
    for number in range(len(chosen)):
        write_text(folder / LINES / f"{number}.html", _page(sent, number, folder, heads))
        tell((number + 1) / len(chosen))
    script = viewer_script((PAGE / "sent.js").read_text("utf-8"))
    write_text(folder / "viewer.js", script)
    entries = [
        list_entry(outcome, states.get(outcome.id, State()))
        | {"said": told_events(desk.decisions.events(outcome.id)) if outcome.id in states else ""}
        for outcome in chosen
    ]
    write_text(folder / "index.html", list_of(sent, entries, {"fixed": True}))
    write_text(folder / "review.csv", review_csv(replace(desk, review=sent)))
    return len(chosen)


def _kinds(entry: dict[str, Any]) -> list[str]:
    return [entry["status"], entry["decision"] or "undecided", *(["commented"] if entry["comments"] else [])]


def _page(review: Review, number: int, folder: Path, heads: dict[Path, str]) -> str:
    """The page of a line; its head is written once for all lines that it shows."""
    outcome = review.outcomes[number]
    line = review.lines.get(outcome.id)
    try:
        if line is None:
            animation, character = delivered_take(review, outcome), SHIPPED
        else:
            line = keep_expected(line, outcome)
            animation = make_take(line, review.folder, line_corrections(review, line)).animation
            character = shown_head(line)
        animation = replace(animation, provenance={**animation.provenance, "input": outcome.id})
        if character not in heads:
            heads[character] = f"head{len(heads)}.js"
            data = base64_text(character.read_bytes())
            write_text(folder / heads[character], f'window.phonanimHead = "{data}";\n')
        shared = (f"../{heads[character]}", "../viewer.js")
        return viewer_page(animation, outcome.id, None, character, Extras(shared=shared))
    except PhonanimError as error:
        return (
            '<!doctype html><meta charset="utf-8"><meta name="color-scheme" content="dark">'
            f'<meta http-equiv="Content-Security-Policy" content="{page_policy()}">'
            f"<title>phonanim</title><p>{html.escape(str(error))}</p>"
        )
