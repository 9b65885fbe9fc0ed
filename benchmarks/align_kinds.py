"""How far do onsets move, and recognized phones change, when a recording is of another kind?

    python benchmarks/align_kinds.py RECORDINGS/textgrids

One sentence of LJSpeech is written as files of other kinds, and made worse: noise, music, silence around it,
clipping, an offset, a low level. Prints for each the median and the 90th percentile of the shift of phone
onsets, in milliseconds, by pocketsphinx and by made speech, and the share of 10 ms steps that are recognized
as the same phone without a text, all against the recording as it is.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np
import soundfile

from phonanim.aligners.long import align_recording
from phonanim.errors import PhonanimError
from phonanim.media.audio import read_sound, resample
from phonanim.recognition.recognizer import recognize_phones
from phonanim.recognition.scores import NETWORK
from phonanim.speech.alignment import Interval

NAME = "002_en_LJ006-0114.wav"
TEXT = "they bought their offices from one another and were thus considered to have a vested interest in them"
AROUND = 10.0  # seconds of silence before and after
CHORD = (220.0, 277.2, 329.6, 440.0, 554.4)  # hertz
Floats = np.ndarray
Phones = tuple[Interval, ...]


def kinds(folder: Path, x: Floats, rate: int) -> Iterator[tuple[str, Path, float]]:
    """Name, file, and seconds by which the speech is later."""
    chance = np.random.default_rng(0)
    rms = float(np.sqrt((x**2).mean()))
    times = np.arange(len(x)) / rate
    chord = np.sum([np.sin(2 * np.pi * hertz * times) for hertz in CHORD], axis=0)
    chord *= rms / np.sqrt((chord**2).mean())
    silence = np.zeros(round(AROUND * rate))
    around = np.concatenate([silence, x, silence])

    def write(
        name: str, samples: Floats, rate: int = rate, end: str = "wav", kind: str | None = "PCM_16"
    ) -> Path:
        path = folder / f"{name}.{end}".replace(" ", "_")
        soundfile.write(path, samples, rate, **({"subtype": kind} if kind else {}))
        return path

    yield "as it is", write("plain", x), 0.0
    yield "right of two channels", write("right", np.stack([0 * x, x], axis=1)), 0.0
    for other in (8000, 11025, 96000):
        yield f"{other} Hz", write(f"rate {other}", resample(x, rate, other), other), 0.0
    for kind in ("PCM_U8", "PCM_24", "FLOAT"):
        yield kind, write(kind, x, kind=kind), 0.0
    for end in ("ogg", "mp3", "flac"):
        yield end, write("coded", x, end=end, kind=None), 0.0
    for end, codec in (("m4a", "aac"), ("mp4", "aac"), ("webm", "libopus")):
        path = folder / f"film.{end}"
        encode(path, codec, resample(x, rate, 48000))
        yield end, path, 0.0
    for decibels in (20, 10, 0):
        music, noise = chord * 10 ** (-decibels / 20), chance.normal(0, rms, len(x)) * 10 ** (-decibels / 20)
        yield f"chord {decibels} dB below", write(f"music {decibels}", x + music), 0.0
        yield f"noise {decibels} dB below", write(f"noise {decibels}", x + noise), 0.0
    yield "10 s of silence around", write("silence", around), AROUND
    noisy = around + chance.normal(0, 1e-3, len(around))
    yield "10 s of noise at -60 dB around", write("floor", noisy), AROUND
    yield "clipped, 18 dB", write("clipped", np.clip(8 * x, -1, 1)), 0.0
    yield "offset 0.3", write("offset", np.clip(0.5 * x + 0.3, -1, 1)), 0.0
    yield "40 dB quieter", write("quiet 40", 0.01 * x), 0.0
    yield "60 dB quieter, 24 bit", write("quiet 60", 0.001 * x, kind="PCM_24"), 0.0


def encode(path: Path, codec: str, samples: Floats) -> None:
    with av.open(str(path), "w") as film:
        track = film.add_stream(codec, rate=48000, layout="mono")
        for begin in range(0, len(samples), 960):
            part = (32767 * samples[begin : begin + 960]).astype("<i2")[None]
            frame = av.AudioFrame.from_ndarray(part, format="s16", layout="mono")
            frame.rate, frame.pts = 48000, begin
            film.mux(track.encode(frame))
        film.mux(track.encode(None))


def phones_of(path: Path, way: str) -> Phones:
    if way == "recognized":
        return recognize_phones(read_sound(path), NETWORK, str(path)).intervals
    return align_recording(path, TEXT, "en-us" if way == "made speech" else None)[0].phones


def shift(found: Phones, known: Phones, later: float) -> str:
    if len(found) != len(known):
        return f"{len(found)} phones, not {len(known)}"
    moved = [1000 * abs(a.start - later - b.start) for a, b in zip(found, known, strict=True)]
    return f"{np.median(moved):.0f} / {np.percentile(moved, 90):.0f}"


def same(found: Phones, known: Phones, later: float, seconds: float) -> str:
    steps = np.arange(0, seconds, 0.01)
    labels = []
    for phones, by in ((found, later), (known, 0.0)):
        said = np.full(len(steps), "", object)
        for one in phones:
            said[(steps >= one.start - by) & (steps < one.end - by)] = one.label
        labels.append(said)
    return f"{np.mean(labels[0] == labels[1]):.0%}"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("textgrids", type=Path)
    x, rate = soundfile.read(options.parse_args().textgrids / NAME, dtype="float32")
    known: dict[str, Phones] = {}
    print("| recording | pocketsphinx, ms | made speech, ms | recognized alike |\n|---|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for name, path, later in kinds(Path(folder), x, rate):
            cells = []
            for way in ("pocketsphinx", "made speech", "recognized"):
                try:
                    found = phones_of(path, way)
                except PhonanimError as error:
                    cells.append(str(error).replace(str(path), "").strip(": ")[:60])
                    continue
                known.setdefault(way, found)
                is_text = way != "recognized"
                cells.append(
                    shift(found, known[way], later)
                    if is_text
                    else same(found, known[way], later, len(x) / rate)
                )
            print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
