"""Stress and rate against articulography: what gains by them change in r, over the speech of each sentence.

    python benchmarks/effort.py RECORDINGS/ema_de RECORDINGS/ema_en

Targets of lexicon/articulation.csv have seen these sentences; what is compared is the gains alone. Only
sentences with marked stress can tell anything of stress.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.articulation import articulate
from phonanim.articulation.effort import USUAL, stress_curve, syllable_rate, vowel_stress
from phonanim.ema.channels import Recording, load_recordings
from phonanim.metrics import correlation
from phonanim.speech.prosody import VOWELS

Array = NDArray[np.float64]
CHANNELS = ("jaw", "lip_gap")
REST = {"jaw": 1.5, "lip_gap": 0.0}  # mm
STRESSES = (0.0, 0.03, 0.06, 0.1, 0.2, 0.35)
POWERS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5)


def scaled(one: Recording, channel: str, gains: Array) -> Array:
    """The channel that phones give, scaled around rest, in speech."""
    curve = articulate(one.track, one.times).channel(channel)
    return (REST[channel] + gains * (curve - REST[channel]))[one.speech]


@click.command(help=__doc__)
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
def main(folders: tuple[Path, ...]) -> None:
    """Tables of stress and of rate."""
    recordings = [one for folder in folders for one in load_recordings(folder)]
    marked = [one for one in recordings if np.isfinite(vowel_stress(one.track)).any()]
    vowels = sum(int(VOWELS[one.track.codes].sum()) for one in marked)
    print(f"stress: {len(marked)} of {len(recordings)} sentences have marks, {vowels} vowels\n")
    print("| gain | " + " | ".join(f"r of {c}" for c in CHANNELS) + " |\n|---:|---:|---:|")
    for amount in STRESSES:
        print(row(marked, amount, lambda one, a: 1 + a * stress_curve(one.track, one.times)))
    rates = np.concatenate([syllable_rate(one.track, one.times[one.speech]) for one in recordings])
    print(f"\nrate: {len(recordings)} sentences, {np.quantile(rates, 0.05):.1f} to "
          f"{np.quantile(rates, 0.95):.1f} syllables a second (5th to 95th percentile)\n")  # fmt: skip
    print("| exponent | " + " | ".join(f"r of {c}" for c in CHANNELS) + " |\n|---:|---:|---:|")
    for power in POWERS:
        print(row(recordings, power, lambda one, a: (syllable_rate(one.track, one.times) / USUAL) ** -a))


def row(recordings: list[Recording], amount: float, gains: Callable[[Recording, float], Array]) -> str:
    """Mean r of each channel at an amount."""
    cells = []
    for channel in CHANNELS:
        found = [
            correlation(scaled(one, channel, gains(one, amount)), one.curves[channel][one.speech])
            for one in recordings
            if channel in one.curves
        ]
        cells.append(f"{np.mean(found):.4f}" if found else "")
    return f"| {amount:g} | {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
