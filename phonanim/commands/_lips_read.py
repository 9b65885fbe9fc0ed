"""`phonanim evaluate --lips-read`: the words that a network reads from the lips of takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from phonanim.evaluation.word_errors import Spelled
    from phonanim.evaluation.words import WordRead, WordReader
    from phonanim.speech.alignment import Interval

SHOWN = {
    "wer": ("word error rate", ".0%"),
    "cer": ("character error rate", ".0%"),
    "viseme_error": ("viseme error rate", ".0%"),
    "top1": ("read first", ".0%"),
    "top5": ("among the first five", ".0%"),
    "median_rank": ("median rank", "g"),
    "word_log_p": ("log p of the word said", ".2f"),
}
"""Measures as the table shows them, and their format."""


def read_lips(
    predictions: Path,
    reference: Path | None,
    alignment: Path | None,
    network: Path,
    words: Path,
    language: str,
    progress: Callable[[float], None],
) -> tuple[dict[str, Any], str]:
    """Results for scripts, and a table: of the predictions, and of the references where they are given.

    Words are those of the alignment, or those that a take carries; `language` is theirs. Raises
    EvaluationError, LabelError.
    """
    from phonanim.errors import EvaluationError
    from phonanim.evaluation.predictions import motions_of, pair_files
    from phonanim.evaluation.word_errors import spell_visemes
    from phonanim.evaluation.words import load_word_reader

    reader = load_word_reader(network, words)
    paths = motions_of(predictions) if predictions.is_dir() else [predictions]
    sides = {"predicted": [(path, path) for path in paths]}
    if reference is not None:
        matched = pair_files(predictions, reference)
        sides = {"predicted": [(mine, mine) for mine, _ in matched], "reference": matched}
    found: dict[str, dict[str, list[WordRead]]] = {side: {} for side in sides}
    unlisted = dict.fromkeys(sides, 0)
    steps = [(side, mine, shown) for side, chosen in sides.items() for mine, shown in chosen]
    for done, (side, mine, shown) in enumerate(steps, 1):
        found[side][mine.name], others = _read(mine, shown, alignment, reader)
        unlisted[side] += others
        progress(done / len(steps))
    for side, files in found.items():
        if not any(files.values()):
            where = alignment or (predictions if side == "predicted" else reference)
            mend = (
                "animate lines that say some of them" if unlisted[side] else "give an --alignment with words"
            )
            raise EvaluationError(f"{where}: none of its {unlisted[side]} words is in {words}; {mend}")
    every = [one for files in found.values() for rows in files.values() for one in rows]
    spelled = spell_visemes((word for one in every for word in (one.word, one.best)), language)
    facts = {side: _facts(files, unlisted[side], spelled) for side, files in found.items()}
    return facts, "\n".join(line for side, one in facts.items() for line in _table(side, one))


def _read(
    prediction: Path, shown: Path, alignment: Path | None, reader: WordReader
) -> tuple[list[WordRead], int]:
    """What is read of a take, and how many of its words the reader does not know."""
    from phonanim.animation.animation import Animation
    from phonanim.errors import EvaluationError
    from phonanim.evaluation.predictions import read_motion
    from phonanim.evaluation.words import read_words
    from phonanim.inputs.alignment import read_alignment
    from phonanim.speech.labels import is_silent

    take = read_motion(shown)
    if not isinstance(take, Animation):
        raise EvaluationError(f"{shown}: is a mesh; words are read from curves, which move the shipped head")
    words: Sequence[Interval] = take.words
    if alignment is not None:
        words = read_alignment(find_alignment(alignment, prediction)).words
    words = [word for word in words if not is_silent(word.label)]
    found = read_words(take, reader, words) if words else []
    return found, len(words) - len(found)


def find_alignment(alignment: Path, prediction: Path) -> Path:
    """The alignment of a line: a file, or the one of its stem in a folder. Raises EvaluationError."""
    from phonanim.errors import EvaluationError
    from phonanim.evaluation.predictions import line_name

    if not alignment.is_dir():
        return alignment
    named = sorted(path for path in alignment.iterdir() if path.stem == line_name(prediction))
    if not named:
        raise EvaluationError(
            f"{alignment}: has no alignment named {line_name(prediction)}; leave it out or add it"
        )
    return named[0]


def _facts(files: dict[str, list[WordRead]], unlisted: int, spelled: Spelled) -> dict[str, Any]:
    """Words by file, and the summary; what is undefined is None."""
    from phonanim.evaluation.word_errors import viseme_errors, word_summary
    from phonanim.metrics import edit_distance

    def row(one: WordRead) -> dict[str, Any]:
        wrong, visemes = viseme_errors(one, spelled.visemes)
        known = {"viseme_errors": wrong, "visemes": visemes} if visemes else {}
        return {**vars(one), "character_errors": edit_distance(one.best, one.word), **known}

    summary = word_summary([one for rows in files.values() for one in rows], spelled)
    summary["words_not_in_list"] = unlisted
    return {
        "files": {name: [row(one) for one in rows] for name, rows in files.items()},
        "summary": {name: _finite(value) for name, value in summary.items()},
    }


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, tuple):
        return None if any(map(math.isnan, value)) else list(value)
    return None if isinstance(value, float) and math.isnan(value) else value


def _table(side: str, facts: dict[str, Any]) -> list[str]:
    lines = []
    for name, rows in facts["files"].items():
        lines += [
            f"{name:<24} {one['word']:<14} rank {one['rank']:>3} log p {one['log_p']:6.2f} {one['best']}"
            for one in rows
        ]
    total = facts["summary"]
    lines.append(f"{side}: {_counted(total)}")
    for name, (shown, form) in SHOWN.items():
        if total[name] is not None:
            interval = [format(edge, form) for edge in total["intervals"].get(name) or ()]
            ends = f" [{', '.join(interval)}]" if interval else ""
            lines.append(f"  {shown:<22} {format(total[name], form):>6}{ends}")
    return lines


def _counted(total: dict[str, Any]) -> str:
    others = {
        "words_not_in_list": "more are not in the list",
        "words_spelled_by_letters": "with visemes by their letters, in no dictionary",
        "words_without_pronunciation": "without a pronunciation, left out of the viseme error",
    }
    parts = [f"{total[name]} {what}" for name, what in others.items() if total[name]]
    return "; ".join([f"{total['words']} words read", *parts])
