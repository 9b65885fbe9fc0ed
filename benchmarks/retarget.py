"""How well the shipped head repeats the reference face: by poses, direct map, articulation and solver.

    phonanim corpus build RECORDINGS -o work/corpus
    python benchmarks/retarget.py work/corpus [--model default] [--json]

The 50 test clips, which no rig was fitted to: their captured motion projected on the modes and, with
--model, the model's prediction. Aperture, width and protrusion of the lips on the head are correlated
with those of the face that goes in ("face") and with the captured ones ("capture"), over all frames and
over speech alone.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.blend import blend_articulation
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.face import contacts
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.metrics import correlation, jerk, phone_middles, speech_mask
from phonanim.pipeline import load_model
from phonanim.rig import Rig, load_rig
from phonanim.rig.head import load_head
from phonanim.rig.landmark_rig import LandmarkRig, make_landmark_rig
from phonanim.rig.landmarks import read_landmarks
from phonanim.rig.motion import closed_face, read_motion
from phonanim.rig.retarget import retarget
from phonanim.rig.solve import solve
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

LIPS = {"aperture": lip_aperture, "width": lip_width, "protrusion": lip_protrusion}
BILABIALS = ("p", "b", "m")
SOLVED = ("arkit", "vrm", "oculus15")  # rigs whose articulation is timed


@dataclass(frozen=True)
class Clips:
    """The test clips end to end: modes by source, captured shapes, which frames are speech, closures."""

    face: FaceModel
    modes: dict[str, Array]
    captured: Array
    speech: NDArray[np.bool_]
    closures: NDArray[np.int64]
    lengths: NDArray[np.int64]
    tracks: list[PhoneTrack]
    fps: float


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("corpus", type=Path)
    options.add_argument("--model", help="also the motion that this model predicts")
    options.add_argument("--rig", default="arkit")
    options.add_argument("--json", action="store_true")
    options.add_argument("--timed", type=int, default=1_000_000, help="frames of retargeting that are timed")
    chosen = options.parse_args()
    rig = load_rig(chosen.rig)
    clips = gather(load_corpus(chosen.corpus), chosen.model)
    spots = read_landmarks(rig.landmarks)
    landmark_rig = make_landmark_rig(load_head(rig.head), spots, clips.face).take(rig.controls)
    rows = [
        {"motion": source, "map": name, **measure(clips, source, landmark_rig, controls(clips.modes[source]))}
        for source in clips.modes
        for name, controls in maps(clips, landmark_rig, rig).items()
    ]
    speeds = speeds_of(clips, rig, chosen.timed)
    if chosen.json:
        print(json.dumps({"rows": rows, "frames_per_second": speeds}, indent=1))
    else:
        show(rows, speeds)


def gather(corpus: Corpus, model_name: str | None) -> Clips:
    """The test clips of a corpus, and what a model predicts for them."""
    train = corpus.rows(corpus.clips_of("train"))
    model = load_model(model_name) if model_name else None
    face = model.face if model else fit_face(corpus.landmarks[train], corpus.indices)
    chosen = corpus.clips_of("test")
    captured = corpus.landmarks[corpus.rows(chosen)].astype(np.float64)
    modes = {"captured": face.project(captured)}
    if model:
        predicted = [
            contacts.enforce_lip_contacts(
                model.predict(corpus.tracks[clip], corpus.fps, int(corpus.frames[clip]), 0.5 / corpus.fps),
                corpus.tracks[clip],
                face,
                corpus.times(clip),
            )
            for clip in chosen
        ]
        modes["predicted"] = np.concatenate(predicted).astype(np.float64)
    speech = np.concatenate([speech_mask(corpus.tracks[clip], corpus.times(clip)) for clip in chosen])
    lengths, tracks = corpus.frames[chosen], [corpus.tracks[clip] for clip in chosen]
    starts = np.cumsum(lengths) - lengths
    closures = [
        start + np.minimum(phone_middles(corpus.tracks[clip], BILABIALS) * corpus.fps, length - 1).astype(int)
        for clip, start, length in zip(chosen, starts, lengths, strict=True)
    ]
    return Clips(face, modes, captured, speech, np.concatenate(closures), lengths, tracks, corpus.fps)


def maps(clips: Clips, landmark_rig: LandmarkRig, rig: Rig) -> dict[str, Callable[[Array], Array]]:
    """The ways from modes to controls; accents need to know the phones."""
    face = clips.face
    closed = closed_face(face, read_motion().modes(face))
    return {
        "poses": lambda modes: retarget(modes, face, rig, "poses").astype(np.float64),
        "direct": lambda modes: retarget(modes, face, rig, "direct").astype(np.float64),
        "direct, accents": lambda modes: with_accents(clips, rig, modes),
        "articulation": lambda modes: articulated(clips, rig, modes),
        "solve": lambda modes: solve(
            face.instance(modes), face, landmark_rig, rig, closed, lengths=clips.lengths
        ),
    }


def with_accents(clips: Clips, rig: Rig, modes: Array) -> Array:
    """What `animate` makes of the modes of all clips, (frames, m) -> (frames, controls)."""
    pieces = np.split(modes, np.cumsum(clips.lengths)[:-1])
    found = [
        retarget(piece, clips.face, rig, "direct", track, (np.arange(len(piece)) + 0.5) / clips.fps)
        for piece, track in zip(pieces, clips.tracks, strict=True)
    ]
    return np.concatenate(found).astype(np.float64)


def articulated(clips: Clips, rig: Rig, modes: Array) -> Array:
    """What `animate` makes of the modes by default: the face and targets of the phones, solved on the rig."""
    pieces = np.split(modes, np.cumsum(clips.lengths)[:-1])
    solvers = [solver(clips, rig, *pair) for pair in zip(pieces, clips.tracks, strict=True)]
    return np.concatenate([solve_line() for solve_line in solvers]).astype(np.float64)


def solver(clips: Clips, rig: Rig, modes: Array, track: PhoneTrack) -> Callable[[], Array]:
    """What solves the mouth of a line on a rig."""
    face, times = clips.face, (np.arange(len(modes)) + 0.5) / clips.fps
    mouth = blend_articulation(face.instance(modes), face, contacts.closed_shape(face), track, times)
    return partial(retarget, modes, face, rig, "articulation", track, times, articulation=mouth)


def joined(clips: Clips) -> PhoneTrack:
    """The phones of all clips as one line."""
    ends = np.cumsum(clips.lengths) / clips.fps
    bounds = [
        begin + track.bounds[1:] * (end - begin) / track.duration
        for track, begin, end in zip(clips.tracks, [0.0, *ends[:-1]], ends, strict=True)
    ]
    labels = tuple(label for track in clips.tracks for label in track.labels)
    codes = np.concatenate([track.codes for track in clips.tracks])
    return PhoneTrack(codes, np.concatenate([[0.0], *bounds]), labels)


def measure(clips: Clips, source: str, landmark_rig: LandmarkRig, controls: Array) -> dict[str, Any]:
    """Correlations, gaps at closures and roughness of one way on one motion."""
    head, shapes = landmark_rig.pose(controls), clips.face.instance(clips.modes[source])
    result: dict[str, Any] = {}
    for name, measured in LIPS.items():
        on_head, on_face = measured(head, clips.face), measured(shapes, clips.face)
        captured = measured(clips.captured, clips.face)
        result[f"{name} r face"] = correlation(on_head, on_face)
        result[f"{name} r capture"] = correlation(on_head, captured)
        result[f"{name} r capture, speech"] = correlation(on_head[clips.speech], captured[clips.speech])
    opening = lip_aperture(head, clips.face)
    result["gap at p b m, mm"] = float(opening[clips.closures].mean())
    result["gap at p b m on the face, mm"] = float(lip_aperture(shapes, clips.face)[clips.closures].mean())
    result["deepest overlap, mm"] = float(max(0.0, -opening.min()))
    result["jerk / face's"] = jerk(opening, clips.fps) / jerk(lip_aperture(shapes, clips.face), clips.fps)
    result["controls in use"] = float((controls > 0.02).sum(axis=1).mean())
    return result


def speeds_of(clips: Clips, rig: Rig, frames: int) -> dict[str, float]:
    """Frames for a second of a processor: by modes, and by articulation of all clips as one line."""
    face, modes, track = clips.face, clips.modes["captured"], joined(clips)
    noise = np.random.default_rng(0).normal(size=(frames, len(face.std))).astype(np.float32)
    ways = {how: partial(retarget, noise, face, rig, how) for how in ("poses", "direct")}
    found = {how: frames / least(run) for how, run in ways.items()}
    for name in SOLVED:
        found[f"articulation, {name}"] = len(modes) / least(solver(clips, load_rig(name), modes, track))
    return found


def least(run: Callable[[], Array]) -> float:
    """Seconds of a processor that it takes, the best of three tries."""
    taken = []
    for _ in range(3):
        start = time.process_time()
        run()
        taken.append(time.process_time() - start)
    return min(taken)


def show(rows: list[dict[str, Any]], speeds: dict[str, float]) -> None:
    """A Markdown table, one column per way."""
    print("|", " | ".join(["", *(f"{row['motion']}, {row['map']}" for row in rows)]), "|")
    print("|" + "---|" * (1 + len(rows)))
    for key in [key for key in rows[0] if key not in ("motion", "map")]:
        print("|", " | ".join([key, *(f"{row[key]:.3f}" for row in rows)]), "|")
    print("\nframes for a second of a processor:")
    print("; ".join(f"{how} {fps:,.0f}" for how, fps in speeds.items()))


if __name__ == "__main__":
    main()
