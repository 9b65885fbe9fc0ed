"""The page of a study: one HTML file with the videos, which works offline and saves the answers."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from phonanim.core.files import write_text
from phonanim.core.pages import fill_page, script_data
from phonanim.errors import StudyError
from phonanim.study.plan import Take, Trial
from phonanim.study.takes import TYPES

FORMAT = "phonanim study 1"
PARTS = Path(__file__).parent / "page"
SCRIPTS = ("chance.js", "player.js", "study.js")
ADDRESS = re.compile(r"https?://[A-Za-z0-9.:_\[\]-]+(/[^\s;,\"']*)?")
QUESTION = "In which take does the face fit the speech better?"
MAX_MEGABYTES = 300
"""Largest size of the videos in a page: browsers refuse texts of about 500 MB, and base64 adds a third."""


@dataclass(frozen=True, slots=True)
class Wording:
    """The texts and settings of a study.

    Each of `questions` is asked about every pair, in this order; stars and controls belong to the first.
    `limit` is the number of test trials per participant, drawn at random; 0 for all. `post` is the address
    that receives the answers; without it, or when it cannot be reached, participants download them.
    """

    title: str = "Which animation fits the speech?"
    questions: tuple[str, ...] = (QUESTION,)
    thanks: str = "Thank you. That was all."
    choices: str = "forced"
    rating: bool = True
    limit: int = 0
    post: str = ""


def write_page(path: Path, trials: Sequence[Trial], wording: Wording) -> int:
    """Write the page and return its size in bytes.

    Raises StudyError when the videos are too large, two questions are the same, or `post` is not a web
    address, OutputError when the destination cannot be written.
    """
    if len({*wording.questions}) < len(wording.questions) or not all(map(str.strip, wording.questions)):
        raise StudyError("--question: each must be another text; change or leave out the one given twice")
    if wording.post and not ADDRESS.fullmatch(wording.post):
        raise StudyError(f"--post {wording.post}: is not a web address; begin it with https://")
    fields = {
        "title": html.escape(wording.title),
        "style": _part("study.css"),
        "data": script_data(_data(trials, wording)),
        "script": "\n".join(map(_part, SCRIPTS)),
    }
    post = urlsplit(wording.post)
    page = fill_page(_part("study.html"), fields, f"{post.scheme}://{post.netloc}" if wording.post else "")
    write_text(path, page)
    return len(page.encode())


def _data(trials: Sequence[Trial], wording: Wording) -> dict[str, Any]:
    """The data for the scripts: the texts, the videos once each, and the trials that refer to them."""
    films = list(dict.fromkeys(film for trial in trials for take in trial.takes for film in _films(take)))
    _check_size(films)
    number = {film: index for index, film in enumerate(films)}
    data = {
        "format": FORMAT,
        **asdict(wording),
        "trials": [_trial(trial, number) for trial in trials],
        "films": [_address(film) for film in films],
    }
    digest = hashlib.sha256(json.dumps(data, sort_keys=True).encode())
    return {"id": digest.hexdigest()[:12], **data}


def _films(take: Take) -> tuple[Path, Path]:
    return take.picture, take.sound


def _check_size(films: Sequence[Path]) -> None:
    megabytes = sum(film.stat().st_size for film in films) / 1e6
    if megabytes > MAX_MEGABYTES:
        raise StudyError(
            f"the videos have {megabytes:.0f} MB, but a page can have {MAX_MEGABYTES}: "
            "make them smaller, or make two studies"
        )


def _trial(trial: Trial, number: dict[Path, int]) -> dict[str, Any]:
    takes = [
        {"system": take.system, "picture": number[take.picture], "sound": number[take.sound]}
        for take in trial.takes
    ]
    return {"item": trial.item, "kind": trial.kind, "takes": takes, "expected": trial.expected}


def _address(film: Path) -> str:
    """A video as a data address."""
    return f"data:{TYPES[film.suffix.lower()]};base64,{base64.b64encode(film.read_bytes()).decode('ascii')}"


def _part(name: str) -> str:
    return (PARTS / name).read_text(encoding="utf-8")
