"""Choose the language of an alignment by its labels: which language writes such labels most probably?"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.label_frequencies import (
    ANY,
    EDGE,
    SILENCES,
    Notation,
    Pairs,
    count_pairs,
    named_silences,
    notations,
    united_notations,
)
from phonanim.speech.labels import LONGEST, Language, is_silent
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import language_names, language_weights
from phonanim.speech.letters import script_languages

SURE, SURE_OF_FEW = 0.95, 0.985
"""Certainty from which a choice is not questioned, and that for a line of at most FEW labels.

Of short lines that were wrong, the surest had 0.983 (benchmarks/languages.py).
"""

EXPECTED = 0.97
"""Share of lines in the languages that are expected, as the lines of a batch are in one language or a few."""

SHARPNESS = 0.8
"""Exponent of the likelihoods: neighbouring labels tell in part the same."""

CONSIDERED = 24
"""Notations that are compared by pairs of labels, after a comparison by single labels."""

FEW = 12
"""Labels of a line up to which all notations are compared by pairs: single labels tell too little."""

MOST = 36
NEGLIGIBLE = 1e-3
"""How many languages are candidates at most, and the share below which one is not."""

UNREADABLE = 1e-2
"""Factor for each label that a language does not have."""

LISTED = 0.1
"""Share of a language that lists every label, where no probable language can read them all."""

MOST_LABELS = 1000
"""Different labels that decide; the syllables of Mandarin with tones, which are the most, are 1300."""

TOLD = 0.01
"""Share from which a language is among the candidates."""

# Notations that were not counted, with the probability of each label they have and their share of all files.
ALPHABETS = {"ipa": (1 / 600, 0.05), "sampa": (1 / 600, 0.004)}
UNNAMED = math.log(0.02)
"""Logarithm of the share of files in none of the notations of their language alone."""

OWN_SHARE = 0.002
UNSEEN = 1e-9

USUAL = -4.2
"""Mean logarithm of the probability of a label, above which labels occur as they do in text."""

APART = 3.0
"""Difference for each label of the logarithms by single labels, from which pairs of labels change nothing."""

HOPELESS = 20.0
"""Difference of logarithms from which a language has no part in the result."""


@dataclass(frozen=True, slots=True)
class LanguageChoice:
    """A language that was chosen by labels.

    `probability` is that of the language; `certainty` is that of all languages that read the labels as the
    same phones. `runner_up` is the most probable of those that read them otherwise ("" without one), and
    `runner_up_probability` is that of all that read them as it does. `candidates` are the most probable
    languages with their probabilities. `needed` is the certainty from which the choice is not questioned.
    """

    language: Language
    probability: float = 1.0
    certainty: float = 1.0
    runner_up: str = ""
    runner_up_probability: float = 0.0
    candidates: tuple[tuple[str, float], ...] = ()
    needed: float = SURE

    @property
    def sure(self) -> bool:
        """Whether the phones can be relied on."""
        return self.certainty >= self.needed


def choose_language(labels: Iterable[str]) -> Language:
    """The language that labels are most probably in."""
    return rank_languages(labels).language


def rank_languages(labels: Iterable[str], expected: Sequence[str] = ()) -> LanguageChoice:
    """The language that labels are most probably in, with how sure that is.

    `expected` are the languages of which the labels are in one unless they tell otherwise.
    """
    labels = _most_frequent(labels)
    spoken = tuple(label for label in labels if not is_silent(label))
    if not spoken:
        return LanguageChoice(load_language(next(iter(expected), "english")))
    shares = _candidates(language_probabilities(labels, expected))
    groups: dict[tuple[object, ...], list[str]] = {}
    distinct = tuple(dict.fromkeys(spoken))
    readings = {name: _reading(name, distinct) for name in shares}
    if not any(map(all, readings.values())):
        listing = _listing_all(distinct)
        shares |= {name: max(shares.get(name, 0.0), LISTED) for name in listing}
        shares = {name: share / sum(shares.values()) for name, share in shares.items()}
        readings |= {name: _reading(name, distinct) for name in listing}
    shares = _without_unreadable(shares, readings)
    for name in sorted(shares, key=lambda name: -shares[name]):
        groups.setdefault(readings[name], []).append(name)
    ranked = sorted(groups.values(), key=lambda names: -sum(shares[name] for name in names))
    best, *others = ranked
    return LanguageChoice(
        language=load_language(best[0]),
        probability=shares[best[0]],
        certainty=sum(shares[name] for name in best),
        runner_up=others[0][0] if others else "",
        runner_up_probability=sum(shares[name] for name in others[0]) if others else 0.0,
        candidates=tuple((name, shares[name]) for names in ranked for name in names if shares[name] >= TOLD),
        needed=SURE if expected or len(spoken) > FEW else SURE_OF_FEW,
    )


def _most_frequent(labels: Iterable[str]) -> tuple[str, ...]:
    """Labels in their order, without those beyond the MOST_LABELS most frequent, each cut to LONGEST."""
    kept = tuple(label[:LONGEST] for label in labels)
    counts = Counter(kept)
    if len(counts) <= MOST_LABELS:
        return kept
    frequent = {label for label, _ in counts.most_common(MOST_LABELS)}
    return tuple(label for label in kept if label in frequent)


def _candidates(shares: dict[str, float]) -> dict[str, float]:
    """The most probable languages."""
    ranked = sorted(shares, key=lambda name: -shares[name])
    return {name: shares[name] for name in ranked[:MOST] if shares[name] >= NEGLIGIBLE}


def _listing_all(labels: tuple[str, ...]) -> list[str]:
    """The languages with a list of labels of their own that has all of these."""
    languages = map(load_language, language_names())
    return [one.name for one in languages if all(one.resolve_listed(label) for label in labels)]


def _without_unreadable(
    shares: dict[str, float], readings: dict[str, tuple[object, ...]]
) -> dict[str, float]:
    """Probabilities where a language that lacks a label gives way to those that have them all."""
    missing = {name: sum(sound is None for sound in readings[name]) for name in shares}
    least = min(missing.values())  # a power of many labels would be 0 for every language
    weighed = {name: share * UNREADABLE ** (missing[name] - least) for name, share in shares.items()}
    total = sum(weighed.values())
    return {name: weight * sum(shares.values()) / total for name, weight in weighed.items()}


def language_probabilities(labels: Iterable[str], expected: Sequence[str] = ()) -> dict[str, float]:
    """The probability of each language, given the labels of a line, without those that are far off."""
    labels = _most_frequent(labels)
    if written := script_languages(label for label in labels if not is_silent(label)):
        return written
    spoken = tuple(EDGE if is_silent(label) else label.strip() for label in labels)
    silent = {label.strip().lower() for label in labels if is_silent(label)}
    silences = frozenset(silent & named_silences())
    pairs = count_pairs(spoken)
    scores = {
        name: score + math.log(_prior(name, expected)) for name, score in _scores(pairs, silences).items()
    }
    best = max(scores.values())
    weights = {name: math.exp(score - best) for name, score in scores.items()}
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}


def recognized_share(labels: Iterable[str]) -> float:
    """The share of labels that the chosen language has as phones; 0 when nothing is spoken."""
    spoken = [label for label in labels if not is_silent(label)]
    if not spoken:
        return 0.0
    language = choose_language(spoken)
    return sum(bool(language.resolve(label)) for label in spoken) / len(spoken)


def _scores(pairs: Pairs, silences: frozenset[str]) -> dict[str, float]:
    """The logarithm of the likelihood of each language: that of its best notation."""
    singles: dict[str, int] = {}
    for (_, label), count in pairs.items():
        if label != EDGE:
            singles[label] = singles.get(label, 0) + count
    found: dict[str, float] = {}
    for notation in _near(singles):
        score = SHARPNESS * notation.log_likelihood(pairs) + notation.log_silences(silences)
        score += 0.0 if notation.name else UNNAMED
        found[notation.language] = max(score, found.get(notation.language, -math.inf))
    counted = {notation.language for notation in notations()}
    for name in language_names():
        if name not in counted or name in ALPHABETS:
            silent = len(silences) * math.log(SILENCES[False])
            # A language without counts that has each label cannot win where this is too far off.
            most = SHARPNESS * _most_even(name, singles) + silent
            if most > max(found.values(), default=-math.inf) - HOPELESS:
                even = SHARPNESS * _even(load_language(name), singles, pairs) + silent
                found[name] = max(even, found.get(name, -math.inf))
    return found


def _near(singles: dict[str, int]) -> list[Notation]:
    """The notations that fit best by single labels.

    Those of a language are also taken as one, unless a single one has every label, about as often as in text.
    """
    fits = dict(zip(notations(), _log_shares(singles, notations()), strict=True))
    usual = USUAL * sum(singles.values())
    if not any(fit > usual and one.language != ANY and one.lists(singles) for one, fit in fits.items()):
        fits |= zip(united_notations(), _log_shares(singles, united_notations()), strict=True)
    count = sum(singles.values())
    ranked = sorted(fits, key=lambda one: -fits[one])[: CONSIDERED if count > FEW else None]
    least = fits[ranked[0]] - APART * count - HOPELESS
    return [one for one in ranked if fits[one] >= least]


def _log_shares(singles: dict[str, int], among: tuple[Notation, ...]) -> list[float]:
    """The logarithm of the probability of labels, one by one, each with its count, in each notation."""
    total = np.zeros(len(among))
    for label, count in singles.items():
        total += count * _label_shares(label, among)
    found: list[float] = total.tolist()
    return found


@lru_cache(maxsize=4096)
def _label_shares(label: str, among: tuple[Notation, ...]) -> NDArray[np.float64]:
    """The logarithm of the probability of a label in each notation, (notations,)."""
    return np.array([notation.log_share(label) for notation in among])


def _most_even(name: str, singles: dict[str, int]) -> float:
    """The most that `_even` can be."""
    share = ALPHABETS[name][0] if name in ALPHABETS else 1.0
    return math.log(share) * sum(singles.values())


def _even(language: Language, singles: dict[str, int], pairs: Pairs) -> float:
    """The logarithm of the likelihood where every label that a language has is as frequent."""
    knows = language.resolve if language.name in ALPHABETS else language.resolve_listed
    own = len(language.phones) + len(language.ipa) + len(language.closures)
    share = ALPHABETS[language.name][0] if language.name in ALPHABETS else 1 / (own + 1)
    score = sum(count * math.log(share if knows(label) else UNSEEN) for label, count in singles.items())
    return score + math.log(0.1) * sum(count for (_, label), count in pairs.items() if label == EDGE)


def _prior(name: str, expected: Sequence[str]) -> float:
    weights = language_weights()
    counted = weights.get(name, 0.0) / sum(weights.values())
    share = counted or ALPHABETS.get(name, (0.0, OWN_SHARE))[1]
    if not expected:
        return share
    return EXPECTED / len(expected) if name in expected else (1 - EXPECTED) * share


def _reading(name: str, labels: tuple[str, ...]) -> tuple[object, ...]:
    """What a language makes of labels."""
    language = load_language(name).for_labels(labels)
    return tuple(sound and (sound.kind, sound.codes) for sound in map(language.resolve, labels))
