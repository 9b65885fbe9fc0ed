"""Align a long recording with a text that is partly wrong: how exact, how fast, in what memory?

    python benchmarks/align_long.py [--minutes 30] [--wrong 0.1] [--noise 20] [--voice en-us]

The recording is speech that eSpeak NG makes of the sentences of docs/, so that the begin of every word is
known. After each ten sentences there are some seconds of a chord with noise. --wrong is the share of
words that are left out of the text, added to it, or changed, a third each. Prints the onset errors of the
words that are in both, the notes, seconds of processor for a minute of recording, and the most memory.
"""

from __future__ import annotations

import argparse
import random
import re
import resource
import tempfile
import time
import wave
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from phonanim.aligners._matching import match_words
from phonanim.aligners.espeak import speak
from phonanim.aligners.long import align_long
from phonanim.aligners.pocketsphinx import SpeechAlignment, split_words
from phonanim.media.audio import resample

ROOT = Path(__file__).resolve().parent.parent
RATE = 16000
SENTENCE = re.compile(r"[A-Z][a-z]+(?: [a-z,]+){5,24}\.")


def sentences() -> Iterator[str]:
    """Sentences of plain words from the documentation, then again from the start."""
    pages = " ".join(" ".join(path.read_text("utf-8").split()) for path in sorted(ROOT.glob("docs/*.md")))
    found = SENTENCE.findall(pages)
    while True:
        yield from found


def chord(seconds: float, seed: int) -> np.ndarray:
    """A chord with noise, (samples,)."""
    times = np.arange(round(seconds * RATE)) / RATE
    tones = sum(np.sin(2 * np.pi * hertz * times) for hertz in (220.0, 277.2, 329.6, 440.0))
    noise = np.random.default_rng(seed).normal(0, 0.3, len(times))
    return np.asarray(0.08 * (tones + noise), np.float32)


def record(minutes: float, voice: str, noise: float) -> tuple[np.ndarray, list[tuple[str, float]]]:
    """Samples (samples,) and each word with its begin in seconds."""
    pieces: list[np.ndarray] = []
    words: list[tuple[str, float]] = []
    length = 0
    for number, sentence in enumerate(sentences(), 1):
        spoken = speak(sentence, voice)
        samples = resample(spoken.samples.astype(np.float32) / 32768, spoken.rate, RATE)
        for word in spoken.words:  # some are spoken as one: the begin of the first is known
            for place, token in enumerate(word.label.split()):
                words.append((token, length / RATE + word.start if place == 0 else np.nan))
        pieces.append(samples)
        if number % 10 == 0 and noise:
            pieces.append(chord(noise, number))
        length = sum(map(len, pieces))
        if length >= 60 * minutes * RATE:
            return np.concatenate(pieces), words
    raise AssertionError


def damage(words: list[str], share: float, seed: int) -> list[str]:
    """The words with a share of them left out, added or changed, a third each."""
    chance, damaged = random.Random(seed), []
    for word in words:
        what = chance.random() / share if share else 1.0
        if what >= 1 / 3:
            damaged.append(word if not 2 / 3 <= what < 1 else chance.choice(words))
        if 1 / 3 <= what < 2 / 3:
            damaged.append(chance.choice(words))
    return damaged


def measured(path: Path, text: str, voice: str | None) -> tuple[SpeechAlignment, float, float, float]:
    """The alignment, seconds of processor, and the most MB of memory before and after."""
    before, start = most_memory(), time.process_time()
    found = align_long(path, text, voice)
    seconds = time.process_time() - start + resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    return found, seconds, before, most_memory()


def most_memory() -> float:
    """The most MB that this process has had, without that of the process that started it (Linux)."""
    return int(re.findall(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[0]) / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--wrong", type=float, default=0.1)
    parser.add_argument("--noise", type=float, default=20)
    parser.add_argument("--voice", default="en-us")
    parser.add_argument("--by-speech", action="store_true", help="warp made speech, as for other languages")
    given = parser.parse_args()
    samples, words = record(given.minutes, given.voice, given.noise)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.wav"
        with wave.open(str(path), "wb") as stream:
            stream.setparams((1, 2, RATE, 0, "NONE", ""))
            stream.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())
        minutes = len(samples) / RATE / 60
        text = " ".join(damage([word for word, _ in words], given.wrong, 0))
        del samples
        voice = given.voice if given.by_speech else None
        with ProcessPoolExecutor(
            1, get_context("spawn")
        ) as process:  # whose memory is that of aligning alone
            found, seconds, before, most = process.submit(measured, path, text, voice).result()
    said = [split_words(word)[0] for word, _ in words]
    pairs = match_words(said, [word.label.lower() for word in found.words])
    errors = np.array([1000 * abs(words[i][1] - found.words[j].start) for i, j in pairs])
    errors = errors[np.isfinite(errors)]
    print(f"{minutes:.1f} minutes, {len(words)} words, {given.wrong:.0%} of the text wrong")
    print(f"{len(pairs)} words found ({len(pairs) / len(words):.1%})")
    print(
        f"onset error: median {np.median(errors):.0f} ms, 90 % {np.percentile(errors, 90):.0f} ms, ", end=""
    )
    print(f"more than 0.5 s: {(errors > 500).mean():.2%}")
    print(f"{seconds:.0f} s of processor, {seconds / minutes:.1f} s a minute; ", end="")
    print(f"{most:.0f} MB at most ({before:.0f} before)")
    for note in found.notes:
        print(f"note: {note[:200]}")


if __name__ == "__main__":
    main()
