"""Folders of the state of a training that has several parts, such as the networks of an ensemble."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from phonanim.regressors import CHECKPOINT


def part_of(journal: Path | None, name: str) -> Path | None:
    """The folder of a part of a training, if there is a journal; without a name it is the journal's own."""
    return journal / name if journal and name else journal


def end_parts(journal: Path | None, names: Iterable[str]) -> None:
    """Delete the states of parts, when all of them are trained; their losses stay."""
    for name in names:
        if journal:
            (journal / name / CHECKPOINT).unlink(missing_ok=True)
