"""Fit lexicon/english_spelling.csv, how English letters sound in context, to a pronouncing dictionary.

    python scripts/fit_spelling.py DICTIONARY [--rows 12000] [-o lexicon/english_spelling.csv]

DICTIONARY is in the form of CMU, such as the one that pocketsphinx installs. Each letter is aligned with none
to two phones (Viterbi training from co-occurrence), then a tree of contexts is grown: a context is kept where
its commonest phones differ from those of the shorter context (Daelemans and van den Bosch,
"Language-independent data-oriented grapheme-to-phoneme conversion", 1997). Every twentieth word is withheld;
prints the share of these that come out right.
"""

from __future__ import annotations

import argparse
import math
import re
from collections import Counter, defaultdict
from pathlib import Path

from phonanim.core.files import atomic_path
from phonanim.metrics import edit_distance
from phonanim.speech.pronunciations import load_pronunciations
from phonanim.speech.spelling import CONTEXTS, SpellingTable, context_of, spell_word

ROOT = Path(__file__).resolve().parent.parent
ROUNDS = 4
MOST = 2  # phones of one letter
WITHHELD = 20  # one word of so many

Word = tuple[str, tuple[str, ...]]
Aligned = list[tuple[str, int, str]]  # word, place, phones of the letter


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dictionary", type=Path)
    parser.add_argument("--rows", type=int, default=12_000)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "lexicon" / "english_spelling.csv")
    given = parser.parse_args()
    entries = load_pronunciations(given.dictionary)
    words = [(word, tuple(p.rstrip("012") for p in phones)) for word, phones in entries.items()]
    words = [(word, phones) for word, phones in words if re.fullmatch("[a-z]+", word) and len(word) > 1]
    fitted = [word for n, word in enumerate(words) if n % WITHHELD]
    withheld = words[::WITHHELD]
    table = grow(align_all(fitted), given.rows)
    report(table, withheld)
    with atomic_path(given.output) as path:
        rows = "".join(f"{context},{phones}\n" for context, phones in sorted(table.items()))
        path.write_text("context,phones\n" + rows, "utf-8")


def align_all(words: list[Word]) -> Aligned:
    """Each letter of each word with its phones."""
    costs: dict[tuple[str, str], float] = {}
    aligned: list[list[str]] = []
    for _ in range(ROUNDS):
        aligned = [align(word, phones, costs) for word, phones in words]
        counts = Counter(
            (letter, sound)
            for (word, _), sounds in zip(words, aligned, strict=True)
            for letter, sound in zip(word, sounds, strict=False)
        )
        totals: Counter[str] = Counter()
        for (letter, _), count in counts.items():
            totals[letter] += count
        costs = {pair: -math.log(count / totals[pair[0]]) for pair, count in counts.items()}
    return [
        (word, place, sound)
        for (word, _), sounds in zip(words, aligned, strict=True)
        for place, sound in enumerate(sounds)
    ]


def align(word: str, phones: tuple[str, ...], costs: dict[tuple[str, str], float]) -> list[str]:
    """The phones of each letter on the cheapest path; empty where no path leads through."""
    best: dict[int, tuple[float, list[str]]] = {0: (0.0, [])}
    for place, letter in enumerate(word):
        after: dict[int, tuple[float, list[str]]] = {}
        for done, (cost, path) in best.items():
            for size in range(MOST + 1):
                if done + size > len(phones) or len(phones) - done - size > MOST * (len(word) - place - 1):
                    continue
                sound = " ".join(phones[done : done + size])
                price = cost + (
                    costs.get((letter, sound), 12.0) if costs else first_cost(letter, sound, size)
                )
                if done + size not in after or price < after[done + size][0]:
                    after[done + size] = (price, [*path, sound])
        best = after
    return best[len(phones)][1] if len(phones) in best else []


def first_cost(letter: str, sound: str, size: int) -> float:
    """Before anything is known: one phone a letter, and vowels for vowels."""
    vowel = bool(sound) and sound[0] in "AEIOU"
    same = sound[:1].lower() == letter
    return abs(size - 1) * 2.0 + (0.0 if same else 1.0) + 2.0 * (size == 1 and vowel != (letter in "aeiouy"))


def grow(letters: Aligned, most: int) -> SpellingTable:
    """The contexts with the most letters that a shorter context would get wrong, `most` of them."""
    counts: list[dict[str, Counter[str]]] = []
    for sizes in CONTEXTS:
        level: dict[str, Counter[str]] = defaultdict(Counter)
        for word, place, sound in letters:
            level[context_of(word, place, sizes)][sound] += 1
        counts.append(level)
    table: SpellingTable = {}
    gains: dict[str, int] = {}
    for depth, level in enumerate(counts):
        for context, sounds in level.items():
            sound, count = min(sounds.items(), key=lambda pair: (-pair[1], pair[0]))
            shorter = answer(table, context, depth)
            if sound != shorter and (depth == 0 or count - sounds[shorter] >= 2):
                table[context] = sound
                gains[context] = count - sounds[shorter] if depth else 10**9
    kept = sorted(table, key=lambda context: (-gains[context], context))[:most]
    return {context: table[context] for context in kept}


def answer(table: SpellingTable, context: str, depth: int) -> str:
    """What shorter contexts than `context` say of its letter."""
    left, rest = context.split("<")
    letter, right = rest.split(">")
    for before, after in reversed(CONTEXTS[:depth]):
        shorter = f"{left[len(left) - before :]}<{letter}>{right[:after]}"
        if shorter in table:
            return table[shorter]
    return ""


def report(table: SpellingTable, words: list[Word]) -> None:
    """Print how often words that took no part come out right."""
    errors = total = right = 0
    for word, phones in words:
        guess = spell_word(word, table)
        far = edit_distance(guess, phones)
        errors, total, right = errors + far, total + len(phones), right + (far == 0)
    print(
        f"{len(table)} rows; of {len(words)} withheld words {100 * right / len(words):.1f} % are right, ",
        end="",
    )
    print(f"{100 * errors / total:.1f} errors per 100 phones")


if __name__ == "__main__":
    main()
