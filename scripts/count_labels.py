"""Count how often each label and each pair of labels occurs, for the choice of the language.

python scripts/count_labels.py DICTIONARIES

Writes lexicon/frequencies: `labels.tsv`, one row a notation of a language, and `<language>.tsv`, one row a
label with the labels that follow it. scripts/label_lines.py says where words and labels come from;
DICTIONARIES is a folder with the dictionaries of the Montreal Forced Aligner. A notation whose dictionary is
not there is left out, and said.
"""

from __future__ import annotations

import sys
from collections import Counter, defaultdict
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from label_lines import Notation, read_notations, speller, weighted_words  # noqa: E402

from phonanim.speech.language_files import load_language  # noqa: E402

FOLDER = ROOT / "lexicon" / "frequencies"
SENTENCE = 7  # words between two silences
RARE = 2e-5  # share of all labels below which a label is left out, unless it is listed
RARE_PAIR = 0.004  # share of the followers of a label below which a pair is left out
EDGE = "#"

Counts = dict[str, Counter[str]]


def count_pairs(notation: Notation, dictionaries: Path) -> Counts:
    """How often each label follows each other, silence included, in words of their frequencies."""
    spell = speller(notation, dictionaries)
    pairs: Counts = defaultdict(Counter)
    firsts: Counter[str] = Counter()
    lasts: Counter[str] = Counter()
    if spell is None:
        return pairs
    for word, weight in weighted_words(notation, dictionaries):
        labels = spell(word)
        for one, two in pairwise(labels):
            pairs[one][two] += weight
        if labels:
            firsts[labels[0]] += weight
            lasts[labels[-1]] += weight
    total = sum(firsts.values())
    for last, weight in lasts.items():
        pairs[last][EDGE] += weight / SENTENCE
        for first, share in firsts.items():
            pairs[last][first] += weight * share / total * (1 - 1 / SENTENCE)
    for first, weight in firsts.items():
        pairs[EDGE][first] += weight / SENTENCE
    return pairs


def label_row(pairs: Counts, listed: Iterable[str]) -> str:
    """Labels by frequency, with their number in a million; those that are listed occur."""
    counts = {label: sum(after.values()) for label, after in pairs.items()}
    total = sum(counts.values())
    counts |= {label: max(counts.get(label, 0.0), RARE * total) for label in listed}
    kept = sorted((label for label in counts if counts[label] >= RARE * total), key=lambda x: (-counts[x], x))
    return " ".join(f"{label} {round(1e6 * counts[label] / total)}" for label in kept)


def pair_rows(pairs: Counts) -> list[str]:
    """Each label with those that follow it, in thousandths."""
    rows = []
    for label in sorted(pairs):
        total = sum(pairs[label].values())
        after = sorted(pairs[label].items(), key=lambda pair: (-pair[1], pair[0]))
        kept = [f"{one} {round(1000 * count / total)}" for one, count in after if count >= RARE_PAIR * total]
        rows.append(f"{label}\t{' '.join(kept)}")
    return rows


def listed_rows(counted: dict[str, list[str]]) -> list[str]:
    """A row for each set of labels that is listed but was not counted, every label as frequent."""
    rows = []
    for language in map(load_language, sorted(counted)):
        known = {row.split("\t")[0] for row in counted[language.name]}
        for notation, labels in language.labels.items():
            if notation not in known:
                evenly = " ".join(f"{label} {round(1e6 / len(labels))}" for label in labels)
                rows.append(f"{language.name}\t{notation}\tlisted\tsil\t{evenly}")
    return rows


def main(dictionaries: Path) -> None:
    """Write the tables."""
    FOLDER.mkdir(exist_ok=True)
    singles: list[str] = []
    after: dict[str, list[str]] = defaultdict(list)
    for notation in read_notations():
        pairs = count_pairs(notation, dictionaries)
        if not pairs:
            print(f"{notation.language} {notation.notation}: no {notation.source}.dict", file=sys.stderr)
            continue
        source = " ".join([notation.method, *notation.source.split()[:1]])
        row = label_row(pairs, load_language(notation.language).labels.get(notation.notation, ()))
        singles.append("\t".join([notation.language, notation.notation, source, notation.silences, row]))
        after[notation.language] += [f"{notation.notation}\t{row}" for row in pair_rows(pairs)]
    singles += listed_rows(after)
    header = "language\tnotation\tsource\tsilences\tlabels, each with its number in a million\n"
    (FOLDER / "labels.tsv").write_text(header + "\n".join(singles) + "\n", "utf-8")
    for language, rows in after.items():
        header = "notation\tlabel\tlabels that follow, in thousandths\n"
        (FOLDER / f"{language}.tsv").write_text(header + "\n".join(rows) + "\n", "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
