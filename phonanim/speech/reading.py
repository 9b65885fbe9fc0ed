"""The language that an alignment's labels were read as, why, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from phonanim.errors import LabelError
from phonanim.speech.alignment import Alignment
from phonanim.speech.alignment_file import quote_label
from phonanim.speech.labels import Language
from phonanim.speech.language_choice import SURE, rank_languages
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import AUTO, expected_languages, is_auto

By = Literal["labels", "option", "format", "fallback"]


@dataclass(frozen=True, slots=True)
class ReadingLanguage:
    """The language of an alignment, and what decided it.

    `certainty` is the probability that the labels are read as they should be, 1 unless the labels decided;
    `probability` is that of the language alone, since others may read the labels alike.
    `runner_up` is the most probable language that reads them otherwise, with its probability. `asked` is the
    language that was named but does not exist, where `fallback` decided. `candidates` are the languages that
    the labels may be in, with their probabilities. `needed` is the certainty from which no check is needed.
    """

    language: Language
    by: By = "option"
    certainty: float = 1.0
    probability: float = 1.0
    runner_up: str = ""
    runner_up_probability: float = 0.0
    asked: str = ""
    candidates: tuple[tuple[str, float], ...] = ()
    needed: float = SURE

    @property
    def sure(self) -> bool:
        """Whether the choice needs no check."""
        return self.certainty >= self.needed

    def doubt(self) -> tuple[str, ...]:
        """A note where the choice is unsure."""
        if self.sure:
            return ()
        return doubt_of(self.language.name, self.certainty, self.runner_up, self.runner_up_probability)

    def facts(self) -> dict[str, Any]:
        """The same as JSON values."""
        found: dict[str, Any] = {
            "name": self.language.name,
            "by": self.by,
            "certainty": round(self.certainty, 3),
        }
        if self.by == "labels":
            found |= {"probability": round(self.probability, 3), "sure": self.sure}
        if self.runner_up:
            found |= {
                "runner_up": self.runner_up,
                "runner_up_probability": round(self.runner_up_probability, 3),
            }
        if self.candidates:
            found["candidates"] = {name: round(share, 3) for name, share in self.candidates}
        return found | ({"asked": self.asked} if self.asked else {})


def doubt_of(name: str, certainty: float, runner_up: str, probability: float) -> tuple[str, ...]:
    """A note that a choice of a language is unsure."""
    other = f" or {runner_up} ({share_of(probability)})" if runner_up else ""
    shown = f"{name} ({share_of(certainty)}){other}"
    return (f"the language is unsure: {shown}, which differ in phones; name it with --language",)


def find_reading_language(
    alignment: Alignment, name: str = AUTO, fallback: str | None = None
) -> ReadingLanguage:
    """The language of an alignment: as named, by its format, or by its labels.

    Raises LabelError for a language that does not exist, unless `fallback` names another.
    """
    labels = tuple(interval.label for interval in alignment.intervals)
    if is_auto(name) and not alignment.language:
        chosen = rank_languages(labels, [load_language(one).name for one in expected_languages(name)])
        return ReadingLanguage(
            language=chosen.language.for_labels(labels),
            by="labels",
            certainty=chosen.certainty,
            probability=chosen.probability,
            runner_up=chosen.runner_up,
            runner_up_probability=chosen.runner_up_probability,
            candidates=chosen.candidates,
            needed=chosen.needed,
        )
    by: By = "format" if is_auto(name) else "option"
    name = alignment.language if is_auto(name) else name
    try:
        return ReadingLanguage(load_language(name).for_labels(labels), by)
    except LabelError:
        if fallback is None:
            raise
    return ReadingLanguage(load_language(fallback).for_labels(labels), "fallback", asked=name)


def describe_language(facts: Mapping[str, Any]) -> str:
    """The language that `facts` tell, in a line: what decided, how sure that is, and what else it may be."""
    name, by = facts["name"], facts["by"]
    if by == "labels":
        other = facts.get("runner_up")
        rest = f"; otherwise {other} ({share_of(facts['runner_up_probability'])})" if other else ""
        alone = facts.get("probability", 1.0)
        alike = f" of the phones (of the language {share_of(alone)}: others read them alike)"
        shown = alike if alone < SURE <= facts["certainty"] else ""
        return f"language {name}, by its labels, {share_of(facts['certainty'])} sure{shown}{rest}"
    if by == "fallback":
        return f'language {name}, as there is no language "{quote_label(facts["asked"])}"'
    return f"language {name}, " + ("by the format" if by == "format" else "as named")


def share_of(share: float) -> str:
    """A certainty that never claims more than it has: 99.9 % is not 100 %."""
    return f"{min(int(share * 100), 99)} %"
