"""Words that a network of isolated words reads from the shipped head, with and without articulation.

    python benchmarks/words.py NETWORK WORDS ljspeech_mfa.tar.xz --count 60

The lines are spread over an archive of alignments; of each, one word that the network knows is read.
"""

from __future__ import annotations

import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path

import click

from phonanim.evaluation.words import load_word_reader, read_words, word_summary
from phonanim.inputs.alignment import read_alignment
from phonanim.pipeline import animate
from phonanim.speech.alignment import Interval

WAYS = {"lips alone": "direct", "with articulation": "auto"}
LONGEST = 0.9  # seconds: a longer word does not fit into the pictures
EDGE = 0.6  # seconds from the ends of a line


def lines_of(archive: Path, folder: Path) -> Iterator[Path]:
    """Every alignment of an archive, in an order that is spread over it."""
    with tarfile.open(archive) as stored:
        members = sorted((one for one in stored if one.name.endswith(".TextGrid")), key=lambda one: one.name)
        for place in range(len(members)):
            member = members[place * 997 % len(members)]
            file = stored.extractfile(member)
            path = folder / Path(member.name).name
            path.write_bytes(file.read() if file else b"")
            yield path


def known_word(path: Path, known: tuple[str, ...]) -> Interval | None:
    """The longest word of a line that the network knows."""
    words = read_alignment(path).words
    fits = [
        word
        for word in words
        if word.label.lower() in known
        and word.end - word.start < LONGEST
        and EDGE < word.start < words[-1].end - EDGE
    ]
    return max(fits, key=lambda word: word.end - word.start, default=None)


@click.command(help=__doc__)
@click.argument("network", type=click.Path(exists=True, path_type=Path))
@click.argument("words", type=click.Path(exists=True, path_type=Path))
@click.argument("archive", type=click.Path(exists=True, path_type=Path))
@click.option("--count", default=60, show_default=True)
def main(network: Path, words: Path, archive: Path, count: int) -> None:
    """Read, and print a table."""
    reader = load_word_reader(network, words)
    with tempfile.TemporaryDirectory() as folder:
        chosen: list[tuple[Path, Interval]] = []
        for path in lines_of(archive, Path(folder)):
            word = known_word(path, reader.words)
            if word is not None:
                chosen.append((path, word))
            if len(chosen) == count:
                break
        print("| mouth | words | first | among five | median rank | log p |\n|---|---:|---:|---:|---:|---:|")
        for way, how in WAYS.items():
            found = []
            for path, word in chosen:
                take = animate(path, rig="arkit", fps=50, life=0.0, retarget=how)
                found += read_words(take, reader, [word])
            total = word_summary(found)
            print(
                f"| {way} | {total['words']:.0f} | {total['top1']:.0%} | {total['top5']:.0%} "
                f"| {total['median_rank']:g} | {total['word_log_p']:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
