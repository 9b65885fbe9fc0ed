"""The language of streamed labels, found by the first of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from phonanim.speech.labels import is_silent
from phonanim.speech.language_choice import LanguageChoice, rank_languages
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import expected_languages, is_auto
from phonanim.speech.reading import doubt_of, share_of

FEWEST = 8  # spoken labels from which a sure choice is kept
MOST = 60  # spoken labels after which any choice is kept
AT_FIRST = "english"


@dataclass
class StreamedLanguage:
    """The language of the labels so far: as named, or the most probable one, until it is settled.

    It is settled once eight spoken labels make it sure, or after sixty.
    """

    asked: str
    name: str = AT_FIRST
    labels: list[str] = field(default_factory=list)
    choice: LanguageChoice | None = None
    settled: bool = False
    told: bool = False

    def __post_init__(self) -> None:
        if not is_auto(self.asked):
            self.name, self.settled = self.asked, True
        elif expected := expected_languages(self.asked):
            self.name = expected[0]

    def add(self, label: str) -> str:
        """The language to read labels in, once this one has arrived."""
        if self.settled or is_silent(label):
            return self.name
        self.labels.append(label)
        expected = [load_language(name).name for name in expected_languages(self.asked)]
        self.choice = rank_languages(self.labels, expected)
        self.name = self.choice.language.for_labels(self.labels).full_name
        sure = self.choice.sure and len(self.labels) >= FEWEST
        self.settled = sure or len(self.labels) >= MOST
        return self.name

    def forget(self, label: str) -> None:
        """Take back a label that cannot be read, so that it does not decide."""
        if self.labels and self.labels[-1] == label and not self.settled:
            self.labels.pop()

    def news(self) -> str:
        """What was decided, once; "" before that and afterwards."""
        if self.told or not self.settled or self.choice is None:
            return ""
        self.told = True
        return self._line(self.choice)

    def doubt(self) -> tuple[str, ...]:
        """At the end: what was decided if that was not told, and whether it is unsure."""
        if self.choice is None:
            return ()
        decided = () if self.told else (self._line(self.choice),)
        choice = self.choice
        if choice.sure:
            return decided
        told = (choice.language.name, choice.certainty, choice.runner_up, choice.runner_up_probability)
        return (*decided, *doubt_of(*told))

    def _line(self, choice: LanguageChoice) -> str:
        shown = f"language {choice.language.name}, by the first {len(self.labels)} labels"
        return f"{shown}, {share_of(choice.certainty)} sure"
