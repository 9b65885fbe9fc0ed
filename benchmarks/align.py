"""Onset errors of `phonanim align` against other labels of the same recordings, its speed, and recognition.

    python benchmarks/align.py RECORDINGS/textgrids [RECORDINGS/grid_s1]

Takes every English WAV that has a TextGrid with words beside it (or the praatIO files, which are labelled
by hand). Each word of the reference is compared with the word of the same number in the alignment; each
phone onset of the reference with the nearest phone onset. Then the same recordings without their text: word
error rate (substituted, left out and added words, in hundredths of those spoken) of Whisper and pocketsphinx;
and on twelve commands of the GRID corpus, which no language model expects.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from phonanim.aligners import whisper
from phonanim.aligners.pocketsphinx import align, split_words
from phonanim.errors import PhonanimError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import audio_duration, read_sound
from phonanim.metrics import edit_distance
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.labels import is_silent

NAMES = (
    "059_en_mary",
    "061_en_damon_set_test",
    "001_en_LJ001-0012",
    "002_en_LJ006-0114",
    "004_en_LJ030-0031",
)
COMMANDS = 12
HAND = ("059_en_mary", "061_en_damon_set_test")


def spoken(intervals: tuple[Interval, ...]) -> list[Interval]:
    return [interval for interval in intervals if not is_silent(interval.label)]


def word_errors(reference: Alignment, found: tuple[Interval, ...]) -> np.ndarray:
    """Milliseconds between the onsets of the same words; empty when the words are not the same."""
    words = spoken(reference.words)
    if len(words) != len(found):
        return np.zeros(0)
    return np.array([1000 * abs(a.start - b.start) for a, b in zip(words, found, strict=True)])


def phone_errors(reference: Alignment, found: tuple[Interval, ...]) -> np.ndarray:
    """Milliseconds from each phone onset of the reference to the nearest one found."""
    onsets = np.array([phone.start for phone in spoken(reference.intervals)])
    others = np.array([phone.start for phone in found])
    return 1000 * np.abs(np.subtract.outer(onsets, others)).min(axis=1)


def word_error_rate(spoken: list[str], recognized: list[str]) -> float:
    """Edit distance over the words that were spoken."""
    return edit_distance(recognized, spoken) / len(spoken)


def recognize(folder: Path) -> None:
    """The word error rate without text, by recognizer."""
    print("\nwithout text             word error rate: Whisper   pocketsphinx")
    for name in NAMES:
        words = split_words(
            " ".join(w.label for w in spoken(read_alignment(folder / f"{name}.TextGrid").words))
        )
        rates = [word_error_rate(words, recognized) for recognized in both(folder / f"{name}.wav")]
        print(f"{name:<24} {100 * rates[0]:24.0f} % {100 * rates[1]:12.0f} %")


def both(audio: Path) -> tuple[list[str], list[str]]:
    """The words that Whisper and that pocketsphinx recognize."""
    recognized = split_words(whisper.recognize(read_sound(audio), str(audio)).text)
    return recognized, [word.label for word in align(audio).words]


def recognize_commands(folder: Path) -> None:
    """The word error rates on the first clips of GRID."""
    count, wrong = 0, np.zeros(2)
    for path in sorted((folder / "textgrid").glob("*.TextGrid"))[:COMMANDS]:
        words = split_words(" ".join(word.label for word in spoken(read_alignment(path).words)))
        recognized = both(folder / "audio" / f"{path.stem}.flac")
        count += len(words)
        wrong += [word_error_rate(words, each) * len(words) for each in recognized]
    rates = 100 * wrong / count
    print(f"{COMMANDS} commands of GRID{'':<17} {rates[0]:14.0f} % {rates[1]:12.0f} %")


def show(name: str, labels: str, words: np.ndarray, phones: np.ndarray, speed: float) -> None:
    told = [
        f"{np.median(e):6.0f} {np.percentile(e, 90):6.0f}" if len(e) else " " * 13 for e in (words, phones)
    ]
    print(f"{name:<24} {labels:<6} {told[0]}   {told[1]}   {speed:6.1f}")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("folder", type=Path, metavar="TEXTGRIDS")
    options.add_argument("grid", type=Path, nargs="?", metavar="GRID")
    chosen = options.parse_args()
    align_texts(chosen.folder)
    recognize(chosen.folder)
    if chosen.grid:
        recognize_commands(chosen.grid)


def align_texts(folder: Path) -> None:
    """The onset errors of each recording with its text, and the share of phones near the reference."""
    print("recording                labels   word onset ms   phone onset ms   x real time")
    print("                                  median  90 %    median  90 %")
    pooled: list[np.ndarray] = []
    for name in NAMES:
        reference = read_alignment(folder / f"{name}.TextGrid")
        text = " ".join(word.label for word in spoken(reference.words))
        started = time.process_time()
        try:
            found = align(folder / f"{name}.wav", text)
        except PhonanimError as error:
            print(f"{name:<24} {error}")
            continue
        speed = audio_duration(folder / f"{name}.wav") / (time.process_time() - started)
        phones = phone_errors(reference, found.phones)
        pooled.append(phones)
        show(name, "hand" if name in HAND else "MFA", word_errors(reference, found.words), phones, speed)
    phones = np.concatenate(pooled)
    within = [100 * np.mean(phones <= limit) for limit in (20, 50)]
    print(f"phone onsets within 20 ms: {within[0]:.0f} %, within 50 ms: {within[1]:.0f} %")


if __name__ == "__main__":
    main()
