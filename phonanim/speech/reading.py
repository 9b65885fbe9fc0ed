"""The language that an alignment's labels were read as, why, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from phonanim.errors import LabelError
from phonanim.speech.alignment import Alignment
from phonanim.speech.alignment_file import quote_label
from phonanim.speech.labels import Language, load_language
from phonanim.speech.language_choice import SURE, rank_languages
from phonanim.speech.language_names import AUTO, is_auto

By = Literal["labels", "option", "format", "fallback"]


@dataclass(frozen=True, slots=True)
class ReadingLanguage:
    """The language of an alignment, and what decided it.

    `certainty` is the probability that the labels are read as they should be, 1 unless the labels decided;
    `probability` is that of the language alone, since others may read the labels alike.
    `runner_up` is the most probable language that reads them otherwise, with its probability. `asked` is the
    language that was named but does not exist, where `fallback` decided. `candidates` are the languages that
    the labels may be in, with their probabilities.
    """

    language: Language
    by: By = "option"
    certainty: float = 1.0
    probability: float = 1.0
    runner_up: str = ""
    runner_up_probability: float = 0.0
    asked: str = ""
    candidates: tuple[tuple[str, float], ...] = ()

    @property
    def sure(self) -> bool:
        """Whether the choice needs no check."""
        return self.certainty >= SURE

    def doubt(self) -> tuple[str, ...]:
        """A note where the choice is unsure."""
        if self.sure:
            return ()
        other = f" or {self.runner_up} ({_percent(self.runner_up_probability)})" if self.runner_up else ""
        name = f"{self.language.name} ({_percent(self.certainty)})"
        return (f"the language is unsure: {name}{other}, which differ in phones; name it with --language",)

    def facts(self) -> dict[str, Any]:
        """The same as JSON values."""
        found: dict[str, Any] = {
            "name": self.language.name,
            "by": self.by,
            "certainty": round(self.certainty, 3),
        }
        if self.by == "labels":
            found["probability"] = round(self.probability, 3)
        if self.runner_up:
            found |= {
                "runner_up": self.runner_up,
                "runner_up_probability": round(self.runner_up_probability, 3),
            }
        if self.candidates:
            found["candidates"] = {name: round(share, 3) for name, share in self.candidates}
        return found | ({"asked": self.asked} if self.asked else {})


def find_reading_language(
    alignment: Alignment, name: str = AUTO, fallback: str | None = None
) -> ReadingLanguage:
    """The language of an alignment: as named, by its format, or by its labels.

    Raises LabelError for a language that does not exist, unless `fallback` names another.
    """
    if is_auto(name) and not alignment.language:
        expected = name.partition(":")[2]
        chosen = rank_languages(
            (interval.label for interval in alignment.intervals),
            load_language(expected).name if expected else "",
        )
        return ReadingLanguage(
            language=chosen.language,
            by="labels",
            certainty=chosen.certainty,
            probability=chosen.probability,
            runner_up=chosen.runner_up,
            runner_up_probability=chosen.runner_up_probability,
            candidates=chosen.candidates,
        )
    by: By = "format" if is_auto(name) else "option"
    name = alignment.language if is_auto(name) else name
    try:
        return ReadingLanguage(load_language(name), by)
    except LabelError:
        if fallback is None:
            raise
    return ReadingLanguage(load_language(fallback), "fallback", asked=name)


def describe_language(facts: Mapping[str, Any]) -> str:
    """The language that `facts` tell, in a line: what decided, how sure that is, and what else it may be."""
    name, by = facts["name"], facts["by"]
    if by == "labels":
        other = facts.get("runner_up")
        rest = f"; otherwise {other} ({_percent(facts['runner_up_probability'])})" if other else ""
        alone = facts.get("probability", 1.0)
        alike = f" of the phones (of the language {_percent(alone)}: others read them alike)"
        shown = alike if alone < SURE <= facts["certainty"] else ""
        return f"language {name}, by its labels, {_percent(facts['certainty'])} sure{shown}{rest}"
    if by == "fallback":
        return f'language {name}, as there is no language "{quote_label(facts["asked"])}"'
    return f"language {name}, " + ("by the format" if by == "format" else "as named")


def _percent(share: float) -> str:
    """A certainty that never claims more than it has: 99.9 % is not 100 %."""
    return f"{min(int(share * 100), 99)} %"
