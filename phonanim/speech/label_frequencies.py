"""How often each label occurs in each notation of each language, and after which: lexicon/frequencies.

scripts/count_labels.py counts them.
"""

from __future__ import annotations

import math
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

from phonanim.core.lexicon import LEXICON
from phonanim.speech.ipa import ipa_diacritics, ipa_substitutes

FOLDER = LEXICON / "frequencies"
ANY = "ipa"
"""The language of notations of languages without a file of their own."""

EDGE = "#"
"""Silence, among the labels of a table."""

UNSEEN = 1e-8
"""Probability of a label that a notation does not have."""

DISGUISED = 0.05
"""Factor for a label that is in a notation but for stress, length, tones or keyboard letters."""

RECASED = 5e-4
"""Factor for a label that is in a notation but for case, as SAMPA tells sounds apart by case."""

FOLLOWED = 0.7
"""Weight of the frequency after the label before, against the frequency alone."""

UNITED = 0.2
"""Factor for a label when the notations of a language are taken as one."""

SILENCES = {True: 0.5, False: 0.05}
"""Probability of a label of silence that a notation uses, and of another."""

MOST_PAIRS = 10_000
"""Pairs of labels that a notation remembers."""

Pairs = Mapping[tuple[str, str], int]


@dataclass(frozen=True, eq=False)
class Notation:
    """A notation of a language: the probability of each label, and its labels of silence."""

    language: str
    name: str
    silences: frozenset[str]
    shares: Mapping[str, float]

    def log_share(self, label: str) -> float:
        """The logarithm of the probability of a label alone."""
        return self._known(label)[1]

    def lists(self, labels: Iterable[str]) -> bool:
        """Whether the notation has every label, as it is written."""
        return all(label in self.shares for label in labels)

    def log_likelihood(self, pairs: Pairs) -> float:
        """The logarithm of the probability of labels, each with the label before it and its count."""
        total, followed = 0.0, self._followed
        for pair, count in pairs.items():
            if pair not in followed:
                if len(followed) >= MOST_PAIRS:
                    followed.clear()
                followed[pair] = self._log_follower(*pair)
            total += count * followed[pair]
        return total

    def _log_follower(self, before: str, label: str) -> float:
        """The logarithm of the probability of a label after another."""
        known, log_share = self._known(label)
        after = _follower_rows(self.language) if self.name else {}
        row = _parse_row(after.get((self.name, self._known(before)[0]), ""))
        if not row:
            return log_share
        share = FOLLOWED * row.get(known, 0.0) * math.exp(log_share - self._listed(known))
        return math.log(share + (1 - FOLLOWED) * math.exp(log_share))

    def log_silences(self, labels: frozenset[str]) -> float:
        """The logarithm of the probability of labels of silence."""
        return sum(math.log(SILENCES[label in self.silences]) for label in labels)

    def _listed(self, label: str) -> float:
        return math.log(self.shares.get(label, UNSEEN))

    def _known(self, label: str) -> tuple[str, float]:
        """The label as the table has it, and the logarithm of its probability."""
        if label in self._found:
            return self._found[label]
        found = label, math.log(UNSEEN)
        if label in self.shares:
            found = label, math.log(self.shares[label])
        else:
            for spelling, factor in _spellings(label).items():
                if spelling in self.shares:
                    found = spelling, math.log(max(self.shares[spelling] * factor, UNSEEN))
                    break
        self._found[label] = found
        return found

    @cached_property
    def _followed(self) -> dict[tuple[str, str], float]:
        return {}

    @cached_property
    def _found(self) -> dict[str, tuple[str, float]]:
        return {EDGE: (EDGE, 0.0) if EDGE not in self.shares else (EDGE, math.log(self.shares[EDGE]))}


@cache
def notations() -> tuple[Notation, ...]:
    """Every notation that was counted."""
    found = []
    for line in (FOLDER / "labels.tsv").read_text("utf-8").splitlines()[1:]:
        language, name, _, silences, counted = line.split("\t")
        parts = counted.split(" ")
        shares = {label: float(count) / 1e6 for label, count in zip(parts[::2], parts[1::2], strict=True)}
        found.append(Notation(language, name, frozenset(silences.split()), shares))
    return tuple(found)


@cache
def named_silences() -> frozenset[str]:
    """The labels of silence that some notation uses."""
    return frozenset(label for notation in notations() for label in notation.silences)


@cache
def united_notations() -> tuple[Notation, ...]:
    """For each language, all of its notations as one, for a file that mixes or lists labels."""
    shares: dict[str, dict[str, float]] = {}
    silences: dict[str, frozenset[str]] = {}
    for notation in notations():
        if notation.language == ANY:
            continue
        silences[notation.language] = silences.get(notation.language, frozenset()) | notation.silences
        merged = shares.setdefault(notation.language, {})
        for label, share in notation.shares.items():
            merged[label] = max(merged.get(label, 0.0), UNITED * share)
    united = [Notation(language, "", silences[language], merged) for language, merged in shares.items()]
    even = [
        Notation(one.language, "", one.silences, dict.fromkeys(one.shares, 1 / len(one.shares)))
        for one in united
    ]
    return (*united, *even)


@cache
def _follower_rows(language: str) -> dict[tuple[str, str], str]:
    """For each notation of a language and each label, the labels that follow with their counts, as text."""
    found: dict[tuple[str, str], str] = {}
    for line in (FOLDER / f"{language}.tsv").read_text("utf-8").split("\n")[1:-1]:
        notation, label, after = line.split("\t")
        found[notation, label] = after
    return found


@lru_cache(maxsize=4096)
def _parse_row(row: str) -> dict[str, float]:
    """The probability of each label that follows, from the text of a row."""
    parts = row.split(" ") if row else []
    return {label: float(count) / 1e3 for label, count in zip(parts[::2], parts[1::2], strict=True)}


@cache
def _spellings(label: str) -> dict[str, float]:
    """Other spellings of a label with their factors: in IPA letters, without marks, in capitals or small."""
    marks = ipa_diacritics()
    plain = label.rstrip("0123456789")
    ipa = "".join(ipa_substitutes().get(letter, letter) for letter in plain)
    letters = unicodedata.normalize("NFD", ipa)
    bare = "".join(letter for letter in letters if marks.get(letter, ("",))[0] != "none")
    positioned = label[:-2] if label[-2:].upper() in ("_B", "_I", "_E", "_S") else label
    spelled = (
        positioned,
        plain,
        positioned.rstrip("012"),
        ipa,
        bare,
        bare + "ː",
        plain.rstrip(":"),
        plain + ":",
    )
    cased = (positioned.rstrip("012").upper(), plain.lower(), label.lower())
    return dict.fromkeys(cased, RECASED) | dict.fromkeys(spelled, DISGUISED)


def count_pairs(labels: tuple[str, ...]) -> Counter[tuple[str, str]]:
    """Each label with the label before it; `labels` has EDGE for silence."""
    return Counter(
        pair for pair in zip((EDGE, *labels), (*labels, EDGE), strict=True) if pair != (EDGE, EDGE)
    )
