"""Errors of words that were read from lips: WER and CER as of Medina 2023, 4.9, and errors of their visemes.

A read is one word for each word that was said. So a word is right or substituted, and the word error rate is
the share of words that are not the first guess.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.evaluation.legibility import VISEMES
from phonanim.evaluation.statistics import bootstrap_interval, ratio
from phonanim.evaluation.words import WordRead
from phonanim.metrics import edit_distance
from phonanim.speech.cmu_dictionary import find_cmu_dictionary
from phonanim.speech.espeak_phones import pronounce_words, reading_language
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import is_auto, one_expected
from phonanim.speech.pronunciations import load_pronunciations
from phonanim.speech.spelling import sound_out

ENGLISH = "english"
TONGUE = "tongue"
SHOWN = {phone: viseme for viseme, phones in VISEMES.items() for phone in phones.split()}
SEED = 0  # of the bootstrap, so that the same words give the same intervals
RESAMPLES = 2000


@dataclass(frozen=True)
class Spelled:
    """The visemes of words, () for one without a pronunciation, and the words spelled by their letters."""

    visemes: Mapping[str, tuple[str, ...]]
    by_letters: frozenset[str] = frozenset()


def spell_visemes(words: Iterable[str], language: str = "auto") -> Spelled:
    """What lips show of words: the visemes of `phonanim.evaluation.legibility`, "tongue" for other phones.

    English words are looked up in the CMU dictionary of an installed package; one that it lacks is spelled
    by its letters. Those of another language are spelled by the rules of eSpeak NG. Raises LabelError for a
    language that does not exist, MissingExtraError without the extra `espeak`.
    """
    wanted = tuple(dict.fromkeys(words))
    spoken = (one_expected(language) or ENGLISH) if is_auto(language) else language
    code = load_language(spoken).code or "en"
    if not code.startswith("en"):
        found = pronounce_words(wanted, code)
        return Spelled({word: _visemes(found[word], reading_language(code)) for word in wanted})
    path = find_cmu_dictionary()
    known = load_pronunciations(path) if path else {}
    phones = {word: known.get(word) or sound_out(word) for word in wanted}
    guessed = frozenset(word for word in wanted if word not in known and phones[word])
    return Spelled({word: _visemes(phones[word], ENGLISH) for word in wanted}, guessed)


def _visemes(labels: Sequence[str], language: str) -> tuple[str, ...]:
    sounds = [load_language(language).resolve(label) for label in labels]
    names = [INVENTORY.phones[code] for sound in sounds if sound for code in sound.codes]
    return tuple(SHOWN.get(name, TONGUE) for name in names)


def word_sums(
    found: Sequence[WordRead], visemes: Mapping[str, tuple[str, ...]]
) -> dict[str, NDArray[np.float64]]:
    """Of each word what a rate sums and what it is divided by, (words, 2), by measure.

    A word without visemes, said or read, counts as 0 of 0 in `viseme_error`.
    """

    def column(values: Iterable[tuple[float, float]]) -> NDArray[np.float64]:
        return np.array(list(values), np.float64).reshape(-1, 2)

    return {
        "wer": column((one.best != one.word, 1) for one in found),
        "cer": column((edit_distance(one.best, one.word), len(one.word)) for one in found),
        "viseme_error": column(viseme_errors(one, visemes) for one in found),
        "top1": column((one.rank == 1, 1) for one in found),
        "top5": column((one.rank <= 5, 1) for one in found),
        "word_log_p": column((one.log_p, 1) for one in found),
    }


def viseme_errors(one: WordRead, visemes: Mapping[str, tuple[str, ...]]) -> tuple[int, int]:
    """Edits from the visemes of the word that was read to those of the word that was said; their number.

    (0, 0) where one of both words has no visemes.
    """
    read, said = visemes.get(one.best, ()), visemes.get(one.word, ())
    return (edit_distance(read, said), len(said)) if read and said else (0, 0)


def word_summary(found: Sequence[WordRead], spelled: Spelled) -> dict[str, Any]:
    """Rates over all words, their 95 % intervals over words, the median rank, and how words were spelled.

    `viseme_error` is NaN where no word has visemes. A single word has no intervals. Raises MissingExtraError
    without scipy.
    """
    sums = word_sums(found, spelled.visemes)
    used = [(one.word, one.best) for one in found]
    rng = np.random.default_rng
    resampled = sums if len(found) > 1 else {}
    return {
        "words": len(found),
        **{name: float(ratio(rows.sum(axis=0))) for name, rows in sums.items()},
        "median_rank": float(np.median([one.rank for one in found])),
        "intervals": {
            name: bootstrap_interval(rows, rng(SEED), resamples=RESAMPLES) for name, rows in resampled.items()
        },
        "words_spelled_by_letters": sum(bool(spelled.by_letters.intersection(pair)) for pair in used),
        "words_without_pronunciation": sum(not all(map(spelled.visemes.get, pair)) for pair in used),
    }
