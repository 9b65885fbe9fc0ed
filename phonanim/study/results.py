"""Read the answers of a study, and exclude inattentive participants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from phonanim.core.decode import DAMAGE, decode_text, read_json
from phonanim.errors import StudyError

MAX_BYTES = 1 << 26  # of a file
FORMAT = "phonanim study result 1"
SIDES = ("left", "right")


@dataclass(frozen=True, slots=True)
class Answer:
    """One trial: the systems by side, the choice ("left", "right", "none" or "equal"), 1 to 5 stars.

    `choices` are those of all questions about the pair, of which `choice` is the first.
    """

    item: str
    kind: str
    left: str
    right: str
    choice: str
    rating: int | None
    expected: str | None
    choices: tuple[str, ...] = ()

    @property
    def attentive(self) -> bool:
        """Whether a control was answered attentively; that includes one star when neither take fits."""
        right = self.expected in (None, self.choice)
        return right and not (self.expected == "none" and self.rating not in (None, 1))


@dataclass(frozen=True, slots=True)
class Participant:
    """The answers of one participant; `ended` is empty when some trials are missing.

    `questions` are those that were asked about every pair; none where the study had one.
    """

    name: str
    study: str
    ended: str
    answers: tuple[Answer, ...]
    questions: tuple[str, ...] = ()

    @property
    def failed(self) -> int:
        """Number of failed controls."""
        return sum(answer.kind == "control" and not answer.attentive for answer in self.answers)


@dataclass(frozen=True, slots=True)
class Exclusion:
    """A participant whose answers do not count, and the reason."""

    name: str
    reason: str


def read_results(paths: Sequence[Path]) -> tuple[Participant, ...]:
    """The participants in JSON files, and in folders of them, of one study.

    Raises StudyError when a file is damaged, there are no files, or they are of several studies.
    """
    participants = tuple(_read(file) for path in paths for file in _files(path))
    if not participants:
        raise StudyError(f"{paths[0]}: has no answers (.json)")
    studies = sorted({participant.study for participant in participants})
    if len(studies) > 1:
        raise StudyError(f"the answers are of several studies ({', '.join(studies)}); analyse each alone")
    return participants


def screen_answers(
    participants: Sequence[Participant], allowed: int = 0
) -> tuple[tuple[Participant, ...], tuple[Exclusion, ...]]:
    """Participants whose answers count, and those who did not finish, answered before, or failed more
    controls than `allowed`.
    """
    kept: dict[str, Participant] = {}
    excluded = []
    for participant in sorted(participants, key=lambda one: (one.ended or "~", one.name)):
        reason = _fault(participant, participant.name in kept, allowed)
        if reason:
            excluded.append(Exclusion(participant.name, reason))
        else:
            kept[participant.name] = participant
    return tuple(kept.values()), tuple(excluded)


def _fault(participant: Participant, again: bool, allowed: int) -> str:
    if not participant.ended:
        return "did not finish"
    if again:
        return "answered more than once; the first counts"
    if participant.failed > allowed:
        return f"failed {participant.failed} controls"
    return ""


def _files(path: Path) -> list[Path]:
    return sorted(path.glob("*.json")) if path.is_dir() else [path]


def _read(path: Path) -> Participant:
    try:
        document = read_json(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        raise StudyError(f"{path}: cannot be read: {error}") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise StudyError(f"{path}: has no answers of a study; its format is not {FORMAT!r}")
    try:
        asked = tuple(decode_text(text, "question") for text in document.get("questions", ()))
        questions = asked if len(asked) > 1 else ()
        answers = tuple(_answers(document, len(questions) or 1))
        name, study = (decode_text(document[key], key) for key in ("participant", "study"))
        return Participant(name, study, decode_text(document["ended"] or "", "ended"), answers, questions)
    except DAMAGE as error:
        raise StudyError(f"{path}: is damaged ({error!r}); ask for it again") from error


def _answers(document: dict[str, Any], questions: int) -> Iterator[Answer]:
    for number, answer in enumerate(document["answers"], start=1):
        names = ("item", "kind", "left", "right", "choice", "rating", "expected")
        choices = tuple(answer.get("choices", [answer["choice"]]))
        found = Answer(**{name: answer[name] for name in names}, choices=choices)
        for name in ("item", "kind", "left", "right"):
            decode_text(answer[name], f"{name} of answer {number}")
        for choice in (found.choice, *choices):
            if choice not in (*SIDES, document["choices"]):
                raise ValueError(f"answer {number} chooses {choice!r}")
        if len(choices) != questions or choices[0] != found.choice:
            raise ValueError(f"answer {number} has {len(choices)} choices for {questions} questions")
        if found.rating not in (None, 1, 2, 3, 4, 5):
            raise ValueError(f"answer {number} gives {found.rating!r} stars")
        yield found
