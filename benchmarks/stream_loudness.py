"""The level in a stream against the level of the whole line, in decibels over speech.

    python benchmarks/stream_loudness.py RECORDINGS/grid_s1/textgrid RECORDINGS/grid_s1/audio \\
        --clips benchmarks/grid_s1_test.txt
    python benchmarks/stream_loudness.py RECORDINGS/textgrids RECORDINGS/textgrids --together

With --together all lines count as one long recording with half a second between them.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import find_audio, read_audio, resample
from phonanim.media.voice import FRAMES, analyze_voice
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.language import to_phones
from phonanim.speech.loudness import measure_loudness
from phonanim.speech.prosody import AHEAD
from phonanim.stream.loudness import StreamedLoudness

RATE = 16000
BETWEEN = 0.5  # seconds
Line = tuple[tuple[Interval, ...], NDArray[np.float32]]


@click.command()
@click.argument("alignments", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--clips", type=click.File(), help="Names of the lines to use, one a line; all by default.")
@click.option("--together", is_flag=True, help="Take all lines as one.")
@click.option("--ahead", type=float, default=AHEAD, help="Look-ahead in seconds.")
@click.option("--level", type=float, help="Usual level of speech, in dB of full scale.")
def main(
    alignments: Path,
    recordings: Path,
    clips: Iterable[str] | None,
    together: bool,
    ahead: float,
    level: float | None,
) -> None:
    """Print how far the two levels agree."""
    names = None if clips is None else {line.strip() for line in clips}
    lines = []
    for path in sorted(alignments.glob("*.TextGrid")):
        sound = find_audio(recordings / path.name)
        if sound is not None and (names is None or path.stem in names):
            samples, rate = read_audio(sound)
            lines.append((read_alignment(path).intervals, resample(samples, rate, RATE)))
    found = [levels(line, level, ahead) for line in ([joined(lines)] if together else lines)]
    whole, streamed = (np.concatenate([pair[i] for pair in found]) for i in (0, 1))
    apart, r = np.abs(whole - streamed), np.corrcoef(whole, streamed)[0, 1]
    print(f"{len(lines)} lines, {len(whole) / FRAMES:.0f} s of speech; r {r:.2f}")
    print(f"sd of the whole line's level {whole.std():.2f} dB, of the stream's {streamed.std():.2f} dB")
    print(f"apart by {np.sqrt((apart**2).mean()):.2f} dB rms, 95 % within {np.quantile(apart, 0.95):.1f} dB")


def joined(lines: list[Line]) -> Line:
    """All lines one after the other."""
    phones: list[Interval] = []
    pieces, time = [], 0.0
    for intervals, samples in lines:
        phones += [Interval(i.label, i.start + time, i.end + time) for i in intervals]
        pieces.append(np.pad(samples, (0, round(BETWEEN * RATE))))
        time += len(pieces[-1]) / RATE
    return tuple(phones), np.concatenate(pieces)


def levels(
    line: Line, reference: float | None, ahead: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Decibels in speech a hundred times a second, by the whole line and as they stream, (frames,) each."""
    intervals, samples = line
    seconds = len(samples) / RATE
    track, _ = to_phones(Alignment(intervals, seconds, "phones", "a line"), "english", "nearest")
    voice = analyze_voice(samples, RATE)
    times = np.arange(0, seconds, 1 / FRAMES)
    spoken = track.sample(times) != INVENTORY.code(SILENCE)
    stream = StreamedLoudness(reference, ahead)
    streamed = [stream.until(time, voice, track, 0.0).at(np.array([time])) for time in times.tolist()]
    return measure_loudness(voice, track, reference).at(times)[spoken], np.concatenate(streamed)[spoken]


if __name__ == "__main__":
    main()
