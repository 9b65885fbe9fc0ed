"""Draw folds of withheld words and phones that no decision has seen, as keys of a plan.

    python benchmarks/draw_folds.py work/corpus --seed 2026 --without benchmarks/compare.toml

Words of the sentence, letters and digits that the other plan withholds are left out, and so are its phones.
Each fold of words has a word of the sentence, three letters and a digit; the phones are consonants and a
vowel that at most a third of the clips have.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

from phonanim.comparison.plan import read_plan
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.features.indicators import VOWEL
from phonanim.speech.inventory import INVENTORY

FOLDS, LETTERS, CONSONANTS = 4, 3, 3
COMMON = 1 / 3  # share of the clips
DIGITS = {"zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine"}


def draw_words(corpus: Corpus, seen: set[str], rng: np.random.Generator) -> list[list[str]]:
    """Folds of words: one of the sentence, three letters and a digit each."""
    words = {word.label for clip in corpus.clips_of("train") for word in corpus.words[clip]} - seen
    letters = rng.permutation(sorted(word for word in words if len(word) == 1))
    digits = rng.permutation(sorted(words & DIGITS))
    others = rng.permutation(sorted(word for word in words - DIGITS if len(word) > 1))
    return [
        [str(others[n]), *map(str, letters[LETTERS * n : LETTERS * (n + 1)]), str(digits[n])]
        for n in range(FOLDS)
    ]


def draw_phones(corpus: Corpus, seen: set[str], rng: np.random.Generator) -> list[str]:
    """Consonants and a vowel that are not in most clips."""
    train = corpus.clips_of("train")
    counts = Counter(int(code) for clip in train for code in set(corpus.tracks[clip].codes))
    rare = [code for code, n in sorted(counts.items()) if code and n <= COMMON * len(train)]
    rare = [code for code in rare if INVENTORY.phones[code] not in seen]
    consonants = rng.permutation([code for code in rare if not VOWEL[code]])[:CONSONANTS]
    vowels = rng.permutation([code for code in rare if VOWEL[code]])[:1]
    return [INVENTORY.phones[code] for code in (*consonants, *vowels)]


def main() -> None:
    """Print the folds."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--without", type=Path, required=True, help="The plan whose folds were used before.")
    given = parser.parse_args()
    corpus, before = load_corpus(given.corpus), read_plan(given.without)
    rng = np.random.default_rng(given.seed)
    print("words = [")
    seen = {word for fold in before.words for word in fold}
    for fold in draw_words(corpus, seen, rng):
        print(f"    {fold},".replace("'", '"'))
    phones = draw_phones(corpus, set(before.phones), rng)
    print(f"]\nphones = {phones}".replace("'", '"'))


if __name__ == "__main__":
    main()
