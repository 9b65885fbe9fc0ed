"""Make examples/line.wav and examples/line.TextGrid: a sentence spoken by eSpeak NG and aligned.

    python examples/make_line.py

Needs phonanim[align,espeak]; another version of eSpeak NG makes other samples. It prints how far the phone
onsets of the alignment are from those that the synthesizer itself reports.
"""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np

from phonanim.aligners.espeak import MARGIN, speak
from phonanim.aligners.pocketsphinx import align
from phonanim.media.audio import resample
from phonanim.speech.textgrid import write_textgrid

HERE = Path(__file__).resolve().parent
TEXT = "My father watched Bob move a cheap blue lamp from the wash room."
VOICE, WORDS_PER_MINUTE = "en-us", 150
RATE = 16000
PAUSE = 0.3  # seconds of silence before and after


def write_wav(path: Path, samples: np.ndarray) -> None:
    """Write mono 16-bit samples at RATE."""
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(RATE)
        stream.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def main() -> None:
    made = speak(TEXT, VOICE, WORDS_PER_MINUTE)
    inner = slice(round(MARGIN * made.rate), len(made.samples) - round(MARGIN * made.rate))
    samples = made.samples[inner].astype(np.float32) / 32768
    silence = np.zeros(round(PAUSE * RATE), np.float32)
    write_wav(HERE / "line.wav", np.concatenate([silence, resample(samples, made.rate, RATE), silence]))
    found = align(HERE / "line.wav", TEXT)
    tiers = {"words": found.words, "phones": found.phones}
    write_textgrid(HERE / "line.TextGrid", tiers, found.duration)
    spoken = [phone.start - MARGIN + PAUSE for phone in made.phones]
    compare(spoken, [phone.start for phone in found.phones])


def compare(spoken: list[float], aligned: list[float]) -> None:
    """Print how far the aligned onsets are from the nearest that the synthesizer reported."""
    errors = np.abs(np.subtract.outer(aligned, spoken)).min(axis=1) * 1000
    print(
        f"{len(aligned)} phones: onset error {np.median(errors):.0f} ms median, {errors.max():.0f} ms at most"
    )


if __name__ == "__main__":
    main()
