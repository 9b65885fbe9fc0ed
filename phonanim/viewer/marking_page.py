"""The page on which a person marks a face on a character, for `phonanim rig fit --landmarks`."""

from __future__ import annotations

import html
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.core.files import write_text
from phonanim.core.pages import fill_page, script_data
from phonanim.rig.align import OPENINGS
from phonanim.rig.character import load_painted_character
from phonanim.rig.face_points import face_points
from phonanim.rig.head import Head
from phonanim.rig.landmarks import HEADER, MeshLandmarks
from phonanim.rig.meshes import head_bytes
from phonanim.rig.names import known_controls
from phonanim.rig.portrait import LIDS
from phonanim.viewer.page import base64_text, read_page_part

SCRIPTS = ("three.js", "data.js", "stage.js", "marking/marking.js")
STYLES = ("style.css", "marking/marking.css")


def write_marking_page(character: Path, page: Path, marked: MeshLandmarks | None = None) -> None:
    """Write the page for a character, with the points that are `marked` already.

    Raises RigError when the character cannot be read, OutputError when the page cannot be written.
    """
    head, opens = _shown(load_painted_character(character))
    saved = f"{character.stem}.points.csv"
    data = {
        "head": base64_text(head_bytes(head, painted=True)),
        "first": [part.start for part in head.parts.values()],
        "targets": [[0, 0, 0, 1]] if opens else [],
        "opens": opens,
        "points": [asdict(point) for point in face_points()],
        "marked": _rows(marked),
        "header": ",".join(HEADER),
        "saved": saved,
        "command": f"phonanim rig fit {character.name} --landmarks {saved}",
    }
    fields = {
        "title": html.escape(f"Mark the face of {character.name}"),
        "style": "\n".join(map(read_page_part, STYLES)),
        "data": script_data(data),
        "script": "\n".join(map(read_page_part, SCRIPTS)),
    }
    write_text(page, fill_page(read_page_part("marking/page.html"), fields))


def _shown(head: Head) -> tuple[Head, bool]:
    """The head with its opening mouth first, if any, and what closes its eyes: enough to find its face."""
    opening = [
        row for name in OPENINGS for row, shape in enumerate(head.targets) if name in known_controls(shape)
    ][:1]
    lids = [row for row, name in enumerate(head.targets) if LIDS.search(name) and row not in opening]
    moving = opening or [int(np.abs(head.deltas).sum(axis=(1, 2)).argmax())] if len(head.targets) else []
    rows = [*moving, *lids]
    drawn = np.unique(head.triangles)
    shown = replace(
        head,
        targets=tuple(head.targets[row] for row in rows),
        deltas=head.deltas[rows],
        parts={n: p for n, p in head.parts.items() if ((drawn >= p.start) & (drawn < p.stop)).any()},
    )
    return shown, bool(moving)


def _rows(marked: MeshLandmarks | None) -> list[dict[str, Any]]:
    """The points of the page among those that are marked."""
    if marked is None:
        return []
    asked = [point.landmark for point in face_points()]
    known = marked.take([number for number in asked if number in marked.numbers])
    return [
        {"landmark": int(number), "corners": corners.tolist(), "weights": weights.tolist()}
        for number, corners, weights in zip(known.numbers, known.corners, known.weights, strict=True)
    ]
