"""`phonanim evaluate --lips-read`: the words that a network reads from the lips of takes."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def read_lips(
    predictions: Path, reference: Path | None, alignment: Path | None, network: Path, words: Path
) -> tuple[dict[str, Any], str]:
    """Results for scripts, and a table: of the predictions, and of the references where they are given.

    Words are those of the alignment, or those that a take carries. Raises EvaluationError.
    """
    from phonanim.errors import EvaluationError
    from phonanim.evaluation.predictions import motions_of, pair_files
    from phonanim.evaluation.words import load_word_reader, word_summary

    reader = load_word_reader(network, words)
    paths = motions_of(predictions) if predictions.is_dir() else [predictions]
    pairs = [(path, path) for path in paths]
    sides = {"predicted": pairs}
    if reference is not None:
        matched = pair_files(predictions, reference)
        sides = {"predicted": [(mine, mine) for mine, _ in matched], "reference": matched}
    facts: dict[str, Any] = {}
    for side, chosen in sides.items():
        found = {mine.name: _read(mine, shown, alignment, reader) for mine, shown in chosen}
        every = [one for rows in found.values() for one in rows]
        if not every:
            raise EvaluationError(
                f"{predictions}: none of its words is in {words}; give an --alignment with words"
            )
        facts[side] = {
            "files": {name: [vars(one) for one in rows] for name, rows in found.items()},
            "summary": word_summary(every),
        }
    return facts, "\n".join(_table(facts))


def _read(prediction: Path, shown: Path, alignment: Path | None, reader: Any) -> Any:
    from phonanim.animation.animation import Animation
    from phonanim.errors import EvaluationError
    from phonanim.evaluation.predictions import read_motion
    from phonanim.evaluation.words import read_words
    from phonanim.inputs.alignment import read_alignment

    take = read_motion(shown)
    if not isinstance(take, Animation):
        raise EvaluationError(f"{shown}: is a mesh; words are read from curves, which move the shipped head")
    if alignment is None:
        return read_words(take, reader)
    return read_words(take, reader, read_alignment(find_alignment(alignment, prediction)).words)


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


def _table(facts: dict[str, Any]) -> list[str]:
    lines = []
    for side, found in facts.items():
        for name, rows in found["files"].items():
            lines += [
                f"{name:<24} {one['word']:<14} rank {one['rank']:>3} log p {one['log_p']:6.2f} {one['best']}"
                for one in rows
            ]
        total = found["summary"]
        lines.append(
            f"{side}: {total['words']:.0f} words; read first {total['top1']:.0%}, among five "
            f"{total['top5']:.0%}; median rank {total['median_rank']:g}; log p {total['word_log_p']:.2f}"
        )
    return lines
