"""Which p, b and m of unknown voices does the recognizer find, and what would a lower threshold add?

    python benchmarks/audio_alone_closures.py RECORDINGS CLONES

The recordings are the English ones of align_confidence.py, without GRID, whose voice was learned. Their p b m
are those of pocketsphinx with the text. Beside what is recognized, a closure is also taken where the
probabilities of p, b and m together exceed a threshold. Prints how many p b m are found, the share of what is
found that is due, and how many of it a second are not.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from align_confidence import LONG, sources

from phonanim.aligners.pocketsphinx import align_sound
from phonanim.errors import PhonanimError
from phonanim.media.audio import Sound, level, read_sound, resample
from phonanim.recognition.network import NetworkStream, load_network
from phonanim.recognition.recognizer import recognize_phones
from phonanim.recognition.scores import NETWORK
from phonanim.recognition.spectrum import RATE, STEP, WINDOW, MelSpectrum, voice_mean
from phonanim.speech.alignment import Alignment
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones

CLOSED = [INVENTORY.code(name) for name in "pbm"]
NEAR = 0.04  # seconds by which a closure may be beside
THRESHOLDS = (1.0, 0.5, 0.3, 0.2, 0.1)  # 1: what is recognized alone
Spans = list[tuple[float, float]]


def spans(mask: np.ndarray) -> Spans:
    """Begin and end in seconds of the runs of a mask over steps."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(STEP * a, STEP * b) for a, b in edges.reshape(-1, 2)]


def near(one: tuple[float, float], others: Spans) -> bool:
    return any(one[0] < end + NEAR and one[1] > begin - NEAR for begin, end in others)


def closures(sound: Sound, text: str) -> tuple[Spans, list[Spans]]:
    """The p b m of the text, and those found with each threshold."""
    found = align_sound(sound, text, "a recording")
    track, _ = to_phones(Alignment(found.phones, sound.duration, "", ""), "english", unknown="nearest")
    due = [
        (float(a), float(b))
        for code, a, b in zip(track.codes, track.bounds[:-1], track.bounds[1:], strict=True)
        if code in CLOSED
    ]
    samples = level(sound.samples)
    whole = np.concatenate([samples, np.zeros(WINDOW // 2, np.float32)])
    steps = voice_mean(samples).subtract(MelSpectrum().push(whole))
    shares = np.exp(NetworkStream(load_network(NETWORK)).push(steps, last=True))[:, CLOSED].sum(axis=1)
    recognized, _ = to_phones(recognize_phones(sound, NETWORK, "a recording"), "ipa", unknown="nearest")
    told = np.isin(recognized.sample(np.arange(len(shares), dtype=np.float64) * STEP), CLOSED)
    return due, [spans(told | (shares > threshold)) for threshold in THRESHOLDS]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("recordings", type=Path)
    options.add_argument("clones", type=Path)
    chosen = options.parse_args()
    hit, due, right, told = (np.zeros(len(THRESHOLDS)) for _ in range(4))
    seconds, voices, count = 0.0, set(), 0
    for speaker, voice, path, text in sources(chosen.recordings, chosen.clones):
        if voice or speaker == "GRID":
            continue
        sound = read_sound(path)
        if sound.duration >= LONG:
            continue
        try:
            truth, found = closures(Sound(resample(sound.samples, sound.rate, RATE), RATE), text)
        except PhonanimError:
            continue
        seconds, count = seconds + sound.duration, count + 1
        voices.add(speaker)
        for n, mine in enumerate(found):
            hit[n] += sum(near(one, mine) for one in truth)
            due[n] += len(truth)
            right[n] += sum(near(one, truth) for one in mine)
            told[n] += len(mine)
    print(f"{count} recordings of {len(voices)} voices, {seconds:.0f} s\n")
    print("| threshold | p b m found | due | not due, a second |\n|---|---:|---:|---:|")
    for n, threshold in enumerate(THRESHOLDS):
        name = "recognized alone" if threshold == 1.0 else f"{threshold:g}"
        wrong = (told[n] - right[n]) / seconds
        print(f"| {name} | {hit[n]:.0f} of {due[n]:.0f} | {right[n] / told[n]:.0%} | {wrong:.1f} |")


if __name__ == "__main__":
    main()
