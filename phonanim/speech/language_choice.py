"""Choose the language of an alignment by its labels alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from phonanim.speech.labels import Language, is_silent, language_names, load_language

FIRST_TRIED = ("english", "ipa", "sampa", "mandarin", "japanese")
"""`auto` takes the first language that has every label, so the most common languages come first."""

ENOUGH = 0.75
"""Share of labels above which a file is ARPAbet. SAMPA can parse almost any letters, so without this limit
one mistyped label would turn a file into SAMPA. Real files of other alphabets stay below 0.7."""


def choose_language(labels: Iterable[str]) -> Language:
    """The first language that has all labels, in its list or its alphabet; else the one that has most.

    ARPAbet is chosen when it has most labels. A language with a list is judged by its list; otherwise every
    IPA label would count as English.
    """
    counts = Counter(label for label in labels if not is_silent(label))
    best, best_share = load_language(FIRST_TRIED[0]), -1.0
    for name in _tried():
        language = load_language(name)
        share = _share(language, counts)
        if share == 1.0 or (name == FIRST_TRIED[0] and share >= ENOUGH):
            return language
        if share > best_share:
            best, best_share = language, share
    return best


def _tried() -> Iterator[str]:
    """The languages to try; the folder is listed only where the first do not fit."""
    yield from FIRST_TRIED
    yield from (name for name in language_names() if name not in FIRST_TRIED)


def recognized_share(labels: Iterable[str]) -> float:
    """The largest share of labels that any one language has as phones; 0 when nothing is spoken."""
    spoken = Counter(label for label in labels if not is_silent(label))
    return _share(choose_language(spoken.elements()), spoken) if spoken else 0.0


def _share(language: Language, counts: Counter[str]) -> float:
    own = language.resolve_listed if language.phones or language.ipa else language.resolve
    known = sum(count for label, count in counts.items() if own(label))
    return known / counts.total() if counts else 1.0
