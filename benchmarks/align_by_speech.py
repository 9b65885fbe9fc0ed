"""Onset errors of `phonanim align --aligner espeak`, against labels by hand and by other aligners.

    python benchmarks/align_by_speech.py RECORDINGS/textgrids RECORDINGS/ema_de RECORDINGS/grid_s1

The phones of the labels and of the alignment are matched in order (longest common subsequences of phones of
the inventory), and the onsets of matched phones are compared. Prices of the path were chosen on the first
table's recordings and on other GRID clips than those reported; the German recordings took no part.
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from pathlib import Path

import numpy as np

from phonanim.aligners.warping import align_by_speech
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import audio_duration
from phonanim.speech.alignment import Alignment
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.labels import is_silent
from phonanim.speech.language import to_phones

ENGLISH = (
    "001_en_LJ001-0012",
    "002_en_LJ006-0114",
    "004_en_LJ030-0031",
    "055_en_SA1",
    "061_en_damon_set_test",
)
GERMAN = {
    "dfgspp_mo1_prosody_0020": "Sie arbeitet in einer Kneipe als Kellnerin.",
    "dfgspp_mo1_prosody_0024": "Morgen muss sie weder Klausur noch Examen schreiben.",
}
CLIPS = slice(30, None, 20)  # of GRID's training clips
CLASSES = {
    "p b m": ("p", "b", "m"),
    "other stops": ("t", "d", "k", "g"),
    "fricatives": ("f", "v", "th", "dh", "s", "z", "sh", "zh", "hh", "ch", "jh"),
    "n ng l r w y": ("n", "ng", "l", "r", "w", "y"),
}


@dataclass(frozen=True)
class Error:
    """A matched phone: its code, errors of onset and end in milliseconds, whether silence is before."""

    code: int
    onset: float
    end: float
    after_silence: bool


def phones_of(alignment: Alignment, language: str) -> list[tuple[int, float, float]]:
    """Code, onset and end in seconds of each phone that is no silence."""
    track, _ = to_phones(alignment, language, unknown="nearest")
    rows = zip(track.codes.tolist(), track.bounds[:-1].tolist(), track.bounds[1:].tolist(), strict=True)
    return [row for row in rows if row[0]]


def compare(audio: Path, labels: Alignment, text: str, voice: str, language: str) -> list[Error]:
    """The errors of each matched phone; prints a line for the recording."""
    started = time.process_time()
    found = align_by_speech(audio, text, voice)
    seconds = time.process_time() - started
    reference = phones_of(labels, language)
    ours = phones_of(replace(labels, intervals=found.phones), "ipa")
    matcher = SequenceMatcher(None, [row[0] for row in reference], [row[0] for row in ours], autojunk=False)
    errors = []
    for i, j, size in matcher.get_matching_blocks():
        for (code, onset, end), (_, begin, stop), before in zip(
            reference[i : i + size], ours[j : j + size], [None, *reference][i : i + size], strict=True
        ):
            first = before is None or onset - before[2] > 0.01
            errors.append(Error(code, 1000 * (begin - onset), 1000 * (stop - end), first))
    shown = summary([error.onset for error in errors])
    speed = audio_duration(audio) / seconds
    print(f"{audio.stem:<28} {len(errors):4}/{len(reference):<4} {shown}  {speed:6.0f}")
    return errors


def summary(errors: list[float]) -> str:
    """Bias, median and 90th percentile of errors in milliseconds."""
    size = np.abs(errors)
    return f"{np.median(errors):6.0f} {np.median(size):6.0f} {np.percentile(size, 90):6.0f}"


def by_class(errors: list[Error]) -> None:
    """A line for each class of phones, and for closures of the lips by place, with their ends."""
    names = INVENTORY.phones
    consonants = {phone for phones in CLASSES.values() for phone in phones}
    groups = {**CLASSES, "vowels": tuple(set(names) - consonants)}
    for name, phones in groups.items():
        mine = [error for error in errors if names[error.code] in phones]
        print(f"{name:<28} {len(mine):9} {summary([one.onset for one in mine])}")
    lips = [error for error in errors if names[error.code] in CLASSES["p b m"]]
    for title, silent in (("after silence", True), ("within speech", False)):
        mine = [error for error in lips if error.after_silence is silent]
        for edge in ("onset", "end"):
            shown = summary([getattr(one, edge) for one in mine])
            print(f"{'p b m ' + title + ', ' + edge:<28} {len(mine):9} {shown}")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    for name in ("textgrids", "german", "grid"):
        options.add_argument(name, type=Path)
    chosen = options.parse_args()
    compare_all(chosen.textgrids, chosen.german, chosen.grid)


def compare_all(textgrids: Path, german: Path, grid: Path) -> None:
    """Print a table for each source, and the classes of all."""
    print(f"{'recording':<28} {'matched':>9}   bias median   90 %  x real time")
    pooled = []
    for name in ENGLISH:
        labels = read_alignment(textgrids / f"{name}.TextGrid")
        words = (w.label for w in labels.words if not is_silent(w.label) and not w.label.startswith("["))
        pooled += compare(textgrids / f"{name}.wav", labels, " ".join(words), "en-us", "auto")
    for name, text in GERMAN.items():
        labels = read_alignment(german / f"{name}_bndl.json")
        pooled += compare(german / f"{name}.wav", labels, text, "de", "german")
    with (grid / "clips.csv").open(newline="") as file:
        clips = [row["clip"] for row in csv.DictReader(file) if row["split"] == "train"][CLIPS]
    commands = []
    for clip in clips:
        labels = read_alignment(grid / "textgrid" / f"{clip}.TextGrid")
        text = " ".join(word.label for word in labels.words if not is_silent(word.label))
        commands += compare(grid / "audio" / f"{clip}.flac", labels, text, "en-gb", "auto")
    for title, errors in (("sentences", pooled), ("GRID", commands)):
        print(f"{title:<28} {len(errors):9} {summary([error.onset for error in errors])}")
    by_class(pooled + commands)


if __name__ == "__main__":
    main()
