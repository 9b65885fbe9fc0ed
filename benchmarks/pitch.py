"""The built-in pitch against Praat's: errors of voicing and of pitch, and processor time.

    python benchmarks/pitch.py RECORDINGS/grid_s1/audio --clips benchmarks/grid_s1_test.txt
    python benchmarks/pitch.py RECORDINGS/textgrids

Praat on the clean recording is the reference; white noise of so many dB below the recording is added for the
other rows. Voicing error: share of frames that one calls voiced and the other not. Gross error: share of the
frames that both call voiced whose pitches differ by more than 20 % (Rabiner et al. 1976, IEEE Transactions on
Acoustics, Speech, and Signal Processing 24). Fine error: standard deviation of the others, in cents. Nod
error: root mean square of the head's motion with pitch that it changes, in degrees.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.life.head import tune
from phonanim.media.audio import SUFFIXES, read_audio
from phonanim.media.praat import with_praat_pitch
from phonanim.media.voice import FRAMES, Voice, analyze_voice

Array = NDArray[np.float64]
Floats = NDArray[np.float32]

GROSS = 0.2  # of the pitch
NOISES = (None, 20, 10)  # dB


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--clips", type=click.File(), help="Names of the recordings to use, one a line; all by default."
)
def main(folder: Path, clips: Iterable[str] | None) -> None:
    """Print a table of errors."""
    names = None if clips is None else {line.strip() for line in clips}
    paths = sorted(path for path in folder.iterdir() if path.suffix in SUFFIXES)
    chosen = [path for path in paths if names is None or path.stem in names]
    print(f"{len(chosen)} recordings")
    print("| estimate | noise | voicing error | gross error | fine error, cents | nod error | ms a second |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for name in ("built-in", "praat"):
        for noise in NOISES:
            print(f"| {name} | {noise or 'none'} | {' | '.join(errors(name, noise, chosen))} |")


def errors(name: str, noise: int | None, paths: list[Path]) -> Iterator[str]:
    """The cells of one row."""
    pairs, spent, seconds = [], 0.0, 0.0
    for path in paths:
        samples, rate = read_audio(path)
        truth = with_praat_pitch(analyze_voice(samples, rate), samples, rate)
        noisy = samples if noise is None else with_noise(samples, noise)
        begun = time.process_time()
        found = analyze_voice(noisy, rate)
        if name == "praat":
            found = with_praat_pitch(found, noisy, rate)
        spent, seconds = spent + time.process_time() - begun, seconds + len(samples) / rate
        pairs.append((found, truth))
    own, known = (np.concatenate([pair[i].pitch for pair in pairs]) for i in (0, 1))
    both = np.isfinite(own) & np.isfinite(known)
    apart = own[both] / known[both]
    gross = np.abs(apart - 1) > GROSS
    yield f"{100 * (np.isfinite(own) != np.isfinite(known)).mean():.1f} %"
    yield f"{100 * gross.mean():.1f} %"
    yield f"{1200 * np.log2(apart[~gross]).std():.0f}"
    yield f"{np.sqrt(np.mean(np.concatenate([nods(a) - nods(b) for a, b in pairs]) ** 2)):.2f}"
    yield f"{1000 * spent / seconds:.1f}"


def with_noise(samples: Floats, decibels: float) -> Floats:
    """The same recording with white noise so many dB below it."""
    size = np.sqrt((samples**2).mean()) * 10 ** (-decibels / 20)
    return (samples + np.random.default_rng(0).normal(0, size, len(samples))).astype(np.float32)


def nods(voice: Voice) -> Array:
    """Degrees that the head rises with pitch, at 60 frames a second."""
    return tune(voice, np.arange(0, len(voice.level) / FRAMES, 1 / 60))


if __name__ == "__main__":
    main()
