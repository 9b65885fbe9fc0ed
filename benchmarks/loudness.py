"""Loudness of speech against size of mouths: SLCC (Chae-Yeon et al. 2025), with and without loudness.

    phonanim corpus build RECORDINGS -o work/corpus
    python benchmarks/loudness.py work/corpus --takes RECORDINGS/facegood

SLCC is the correlation over clips of the intensity of speech and of the lips. Speech: the level of voiced
frames within phones, dB. Lips: the mean speed of the inner lips' gap in speech, mm/s (its change from one
frame to the next, times the frame rate). "followed" is each clip about its own mean, "across" about the mean
of all clips. The takes of a rig have sound but no phones, so only what was captured is shown of them, in
pieces of 3 s.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.animation.motion import predict_controls
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.face.model import lip_aperture
from phonanim.media.audio import read_sound
from phonanim.media.voice import FRAMES, Voice, analyze_voice
from phonanim.metrics import correlation, speech_mask
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.regressors import Model
from phonanim.rig import Rig
from phonanim.speech.loudness import Loudness, measure_loudness

Array = NDArray[np.float64]
PIECE = 3.0  # seconds of a take
JAW = "mouth_stretch_c"


def clip_rows(corpus: Corpus, model_name: str) -> None:
    """A table of the test clips."""
    model, rig = load_model(model_name), load_cached_rig("arkit")
    clips = np.asarray(corpus.clips_of("test"))
    sounds = [read_sound(corpus.audio[clip]) for clip in clips]
    voices = [analyze_voice(sound.samples, sound.rate) for sound in sounds]
    spoken = [measure_loudness(voice, corpus.tracks[clip]) for voice, clip in zip(voices, clips, strict=True)]
    levels = np.array([one.mean for one in spoken])
    known = np.isfinite(levels)  # not where the alignment leaves no speech that stands out
    usual = float(levels[known].mean())
    ways: dict[str, list[float]] = {"captured": [], "constant": [], "followed": [], "across": []}
    gaps: dict[str, list[Array]] = {way: [] for way in ways}
    for clip, voice, own in zip(clips, voices, spoken, strict=True):
        track, times = corpus.tracks[clip], corpus.times(clip)
        said = speech_mask(track, times)
        curves = {"captured": lip_aperture(corpus.landmarks[corpus.rows([clip])].astype(float), model.face)}
        across = measure_loudness(voice, track, usual)
        for way, loudness in (("constant", None), ("followed", own), ("across", across)):
            curves[way] = moved(corpus, clip, model, rig, loudness)
        for way, gap in curves.items():
            ways[way].append(speed(gap, said, corpus.fps))
            gaps[way].append((gap - gap[~said].mean() if (~said).any() else gap)[said])
    within = np.mean([one.decibels.std() for one in spoken])
    spread = f"sd {levels[known].std():.2f} dB over clips, {within:.2f} within"
    print(f"{len(clips)} clips, {known.sum()} with a level, of {usual:.1f} dB of full scale, {spread}")
    print("\n| mouth | SLCC | mm/s, mean | r of lip gap in speech |\n|---|---:|---:|---:|")
    wanted = np.concatenate(gaps["captured"])
    for way, speeds in ways.items():
        r = correlation(np.concatenate(gaps[way]), wanted)
        slcc = correlation(levels[known], np.array(speeds)[known])
        print(f"| {way} | {slcc:.3f} | {np.mean(speeds):.1f} | {r:.4f} |")


def moved(corpus: Corpus, clip: int, model: Model, rig: Rig, loudness: Loudness | None) -> Array:
    """The lip gap of articulation at a clip's frames, (frames,) mm."""
    times, options = corpus.times(clip), Options(fps=corpus.fps)
    motion = predict_controls(
        corpus.tracks[clip], model, rig, options, len(times), float(times[0]), loudness=loudness
    )
    return motion.articulation.channel("lip_gap")


def speed(gap: Array, said: NDArray[np.bool_], fps: float) -> float:
    """Mean speed of the lips in speech, mm/s."""
    return float(np.abs(np.diff(gap))[said[1:] & said[:-1]].mean() * fps)


def take_rows(folder: Path) -> None:
    """What was captured in takes of a rig, in pieces of PIECE seconds that somebody speaks in."""
    stored = np.load(folder / "curves.npz", allow_pickle=False)
    fps, jaw = float(stored["fps"]), stored["names"].tolist().index(JAW)
    print(f"\n| take | pieces | SLCC of {JAW} | change of its speed, % per dB |\n|---|---:|---:|---:|")
    for name in sorted(set(stored.files) - {"fps", "names"}):
        sound = read_sound(folder / f"{name}.flac")
        voice = analyze_voice(sound.samples, sound.rate)
        levels, speeds = pieces(voice, stored[name][:, jaw].astype(np.float64), fps)
        slope = 100 * np.polyfit(levels, speeds, 1)[0] / speeds.mean()
        print(f"| {name} | {len(levels)} | {correlation(levels, speeds):.2f} | {slope:.1f} |")


def pieces(voice: Voice, curve: Array, fps: float) -> tuple[Array, Array]:
    """Level, dB, and mean speed of a curve in each piece of a take that holds a second of voice."""
    spoken = voice.active() & np.isfinite(voice.pitch)
    size, levels, speeds = round(PIECE * FRAMES), [], []
    for begin in range(0, len(spoken) - size, size):
        rows = np.flatnonzero(spoken[begin : begin + size]) + begin
        frames = np.unique((rows / FRAMES * fps).astype(np.int64))
        frames = frames[frames < len(curve) - 1]
        if len(rows) >= FRAMES and len(frames):
            levels.append(voice.level[rows].mean())
            speeds.append(np.abs(curve[frames + 1] - curve[frames]).mean() * fps)
    return np.array(levels), np.array(speeds)


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--takes", type=click.Path(exists=True, path_type=Path), help="Takes of a rig with sound.")
@click.option("--model", default="default", show_default=True)
def main(corpus: Path, takes: Path | None, model: str) -> None:
    """The tables."""
    clip_rows(load_corpus(corpus), model)
    if takes:
        take_rows(takes)


if __name__ == "__main__":
    main()
