"""What a face does besides speaking, beside what is published of it, and what it costs.

    python benchmarks/life.py [ALIGNMENT] [--minutes 10] [--seeds 5]

The sentence of an alignment (examples/line.TextGrid by default) is said again and again with pauses of 0.25
to 5 s. Statistics are those of the layer's own events and curves, over all seeds. The cost is that of the
layer alone on the phones of all minutes, without sound and with it.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.evaluation.upper_face import RAISED, rises
from phonanim.inputs.alignment import read_alignment
from phonanim.life import Life, blinks, gaze, life_curves
from phonanim.media.voice import analyze_voice
from phonanim.rig.neck import TURNS
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.labels import is_silent
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.speech.prosody import Prosody, read_prosody

Array = NDArray[np.float64]

PAUSES = (0.25, 0.6, 1.5, 5.0)  # seconds
FPS = 60
LINE = Path(__file__).parent.parent / "examples" / "line.TextGrid"
JUMP = 0.5  # degrees; less is a microsaccade
# What is printed beside each figure, and where it comes from.
PUBLISHED = {
    "blinks a minute, talking": "26 (Bentivoglio 1997)",
    "blinks a minute, silent": "17 (Bentivoglio 1997)",
    "gap between blinks, median s": "below the mean: log-normal",
    "gap between blinks, mean s": "2.3 at 26 a minute",
    "phrase ends with a blink, %": "more than elsewhere (Nakano and Kitazawa 2010)",
    "fixation, mean s": "no figure taken over",
    "saccade, median degrees": "small on a face, exponential beyond (Lee et al. 2002)",
    "saccade, 95th percentile degrees": "below 27.5 (Lee et al. 2002)",
    "peak speed of 10 degrees, degrees/s": "300 to 500 (Bahill et al. 1975)",
    "time away, talking, %": "23: 0.93 of 4.06 s (Lee et al. 2002)",
    "time away, silent, %": "5: 0.43 of 8.35 s (Lee et al. 2002)",
    "brow raises a minute": "few of the accents (Flecha-Garcia 2010)",
    "head pitch, sd degrees": "below lively speakers (Busso et al. 2007)",
    "head yaw, sd degrees": "below lively speakers (Busso et al. 2007)",
    "head roll, sd degrees": "below lively speakers (Busso et al. 2007)",
    "head, 99th percentile degrees/s": "no figure taken over",
}


def repeated(path: Path, seconds: float) -> PhoneTrack:
    """The sentence of an alignment again and again."""
    spoken = [one for one in read_alignment(path).intervals if not is_silent(one.label)]
    found: list[Interval] = []
    start, number = 0.5, 0
    while start < seconds:
        moved = start - spoken[0].start
        found += [Interval(one.label, one.start + moved, one.end + moved) for one in spoken]
        start = found[-1].end + PAUSES[number % len(PAUSES)]
        number += 1
    return to_phones(Alignment(tuple(found), start, "phones", str(path)))[0]


def statistics(prosody: Prosody, silent: Prosody, times: Array, seed: int) -> list[float]:
    """The figures of PUBLISHED for one seed."""
    end = float(times[-1])
    look, curves = gaze.look(seed, prosody, times), life_curves(Life(seed), prosody, times)
    shifts = look.onsets, look.sizes
    blinked = blinks.blink_starts(seed, prosody, 0.0, end, shifts)
    resting = blinks.blink_starts(seed, silent, 0.0, end, (np.zeros(0), np.zeros(0)))
    sizes = look.sizes[look.sizes > JUMP]
    away = [np.subtract(*gaze.looks_away(seed, one, 0.0, end)[::-1]).sum() / end for one in (prosody, silent)]
    near = [np.abs(blinked - one).min() < 0.2 for one in prosody.ends]
    turns = np.array([curves[name] for name in TURNS])
    return [
        60 * len(blinked) / end,
        60 * len(resting) / end,
        float(np.median(np.diff(blinked))),
        float(np.diff(blinked).mean()),
        100 * float(np.mean(near)),
        float(np.diff(look.onsets).mean()),
        float(np.median(sizes)),
        float(np.quantile(sizes, 0.95)),
        1.875 * 10 / float(gaze.saccade_seconds(np.array(10.0))),
        100 * away[0],
        100 * away[1],
        60 * rises(curves["browInnerUp"], RAISED) / end,
        *turns.std(axis=1).tolist(),
        float(np.quantile(np.abs(np.diff(turns, axis=1)) * FPS, 0.99)),
    ]


def main() -> None:
    """Print the table and the cost."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("alignment", type=Path, nargs="?", default=LINE)
    options.add_argument("--minutes", type=float, default=10.0)
    options.add_argument("--seeds", type=int, default=5)
    chosen = options.parse_args()
    track = repeated(chosen.alignment, 60 * chosen.minutes)
    times = np.arange(int(track.duration * FPS)) / FPS
    prosody, silent = read_prosody(track), read_prosody(silent_track(track.duration))
    rows = [statistics(prosody, silent, times, seed) for seed in range(chosen.seeds)]
    print("| | phonanim | published |\n|---|---|---|")
    for (name, known), values in zip(PUBLISHED.items(), np.transpose(rows), strict=True):
        print(f"| {name} | {values.mean():.2f} | {known} |")
    samples = np.random.default_rng(0).normal(0, 0.1, round(16000 * track.duration)).astype(np.float32)
    began = time.process_time()
    life_curves(Life(0), read_prosody(track), times)
    read = time.process_time() - began
    began = time.process_time()
    life_curves(Life(0), read_prosody(track, voice=analyze_voice(samples, 16000)), times)
    with_sound = time.process_time() - began
    print(f"\n{len(times)} frames: {len(times) / read:.0f} a second from phones, ", end="")
    print(f"{len(times) / with_sound:.0f} from phones and sound")


if __name__ == "__main__":
    main()
