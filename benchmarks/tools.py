"""Other tools against ours through one head: the same alignments, the same ARKit shapes, the same measures.

    phonanim corpus build RECORDINGS -o work/corpus
    (benchmarks/openfacefx_tracks.py in its own environment writes work/openfacefx_tracks)
    python benchmarks/tools.py work/corpus RECORDINGS --openfacefx work/openfacefx_tracks -o work/tools.json

The 50 test clips. Every tool gets the TextGrid and gives curves of ARKit shapes, which move the shipped head;
they are read at the instants that the camera saw. The lips of the head are then compared with the lips that
were captured. Two rows frame the others: the captured motion itself, solved on the head frame by frame (what
the head can show), and the head at rest.

`rhubarb` are nine drawn mouths, one at a time, after the phones of the alignment, not after Rhubarb's own
listening. The ARKit pose of each mouth is solved from the mean captured face of its sounds in the training
clips, so it is the best pose that this speaker has for it; `blended` lets a mouth pass into the next.
The JSON holds {tool: {clip: {measure: value}}}; the table pools the frames of all clips.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from legibility_mouths import pooled as pooled_reading
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.evaluation.legibility import Reading, load_reader, read_visemes, see_lips
from phonanim.evaluation.surfaces import landmark_lips
from phonanim.exporters import track_json
from phonanim.face.masks import head_masks
from phonanim.face.model import FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.metrics import (
    correlation,
    derivative_error,
    distances,
    jerk,
    lag,
    lip_vertex_error,
    log_spectral_distance,
    phone_middles,
    speech_mask,
)
from phonanim.options import Options
from phonanim.pipeline import animate, load_model
from phonanim.rig import Rig, load_rig
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmark_rig import LandmarkRig, make_landmark_rig, to_face_axes
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.motion import closed_face, read_motion
from phonanim.rig.solve import solve
from phonanim.rig.visemes import spoken_shapes
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
LIPS = {"aperture": lip_aperture, "width": lip_width, "protrusion": lip_protrusion}
CONTACTS = {"pbm": ("p", "b", "m"), "fv": ("f", "v")}
DRAWN_FPS = 100.0  # steps fall within 5 ms of where the alignment has them
BLEND = 0.1  # seconds over which one drawn mouth becomes the next


@dataclass(frozen=True)
class Clip:
    """One test clip: exposure instants (frames,) s, captured (frames, landmarks, 3) mm, contact frames."""

    name: str
    track: PhoneTrack
    times: Array
    captured: Array
    speech: NDArray[np.bool_]
    contacts: dict[str, NDArray[np.int64]]


@dataclass(frozen=True)
class Stage:
    """The head that every tool moves: as landmarks, and as the vertices of its lips, both mm."""

    face: FaceModel
    rig: Rig
    landmark_rig: LandmarkRig
    head: Head
    lips: NDArray[np.int64]

    def lip_vertices(self, controls: Array) -> Array:
        """(frames, controls) -> (frames, lip vertices, 3) mm."""
        moved = np.tensordot(controls, self.head.deltas[:, self.lips], axes=1)
        return np.asarray(self.head.vertices[self.lips] + moved)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("corpus", type=Path)
    options.add_argument("recordings", type=Path, help="folder with textgrid/CLIP.TextGrid")
    options.add_argument("--openfacefx", type=Path, help="folder of tracks from openfacefx_tracks.py")
    options.add_argument("--model", default="default")
    options.add_argument("-o", "--output", type=Path, help="JSON file of measures by tool and clip")
    chosen = options.parse_args()
    corpus = load_corpus(chosen.corpus)
    stage, clips = set_up(chosen.model), gather(corpus)
    solved = solve_captured(corpus, stage)
    tools = {"captured motion": solved, "head at rest": [np.zeros_like(found) for found in solved]}
    tools[f"phonanim {chosen.model}"] = ours(clips, chosen.recordings, Options(model=chosen.model), stage)
    learned = Options(model=chosen.model, retarget="direct")
    tools["phonanim, learned face"] = ours(clips, chosen.recordings, learned, stage)
    if chosen.openfacefx:
        tools["openfacefx 0.24"] = openfacefx(clips, chosen.openfacefx, stage)
    drawn = mouths(corpus, stage)
    for name, blend in (("rhubarb, stepped", 0.0), ("rhubarb, blended", BLEND)):
        tools[name] = rhubarb(clips, chosen.recordings, drawn, blend)
    if chosen.output:
        rows = {name: score_clips(clips, found, solved, stage) for name, found in tools.items()}
        chosen.output.write_text(json.dumps(rows, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    show({name: pooled(clips, found, solved, stage) for name, found in tools.items()})


def set_up(model: str) -> Stage:
    """The shipped head with the reference face of a model, moved by the rig's controls alone."""
    face, rig = load_model(model).face, load_rig("arkit")
    spots, head = shipped_landmarks(), load_head()
    controls = tuple(control for control in rig.controls if control in head.targets)  # less the head's turns
    head = replace(head, targets=controls, deltas=head.deltas[[head.targets.index(c) for c in controls]])
    return Stage(
        face,
        rig,
        make_landmark_rig(head, spots, face).take(controls),
        to_face_axes(head, spots, face),
        head_masks()["lips"],
    )


def gather(corpus: Corpus) -> list[Clip]:
    """The test clips; a contact is the frame nearest to the middle of its sound."""
    return [
        Clip(
            corpus.clips[clip],
            corpus.tracks[clip],
            (times := corpus.times(clip)),
            corpus.landmarks[corpus.rows([clip])].astype(np.float64),
            speech_mask(corpus.tracks[clip], times),
            {name: nearest(times, phone_middles(corpus.tracks[clip], p)) for name, p in CONTACTS.items()},
        )
        for clip in corpus.clips_of("test")
    ]


def nearest(times: Array, instants: Array) -> NDArray[np.int64]:
    """Frames nearest to instants, (frames,) and (n,) seconds -> (n,)."""
    return np.abs(times[:, None] - instants).argmin(axis=0)


def solve_captured(corpus: Corpus, stage: Stage) -> list[Array]:
    """The captured motion of the test clips on the head, (frames, controls) each."""
    clips = corpus.clips_of("test")
    lengths = corpus.frames[clips]
    modes = stage.face.project(corpus.landmarks[corpus.rows(clips)])
    return np.split(solved_faces(stage.face.instance(modes), stage, lengths), np.cumsum(lengths)[:-1])


def solved_faces(shapes: Array, stage: Stage, lengths: NDArray[np.int64]) -> Array:
    """Controls of the head for faces, (frames, landmarks, 3) mm -> (frames, controls)."""
    closed = closed_face(stage.face, read_motion().modes(stage.face))
    controls = solve(shapes, stage.face, stage.landmark_rig, stage.rig, closed, lengths=lengths)
    return controls[:, [stage.rig.controls.index(name) for name in stage.head.targets]]


def ours(clips: list[Clip], recordings: Path, options: Options, stage: Stage) -> list[Array]:
    """What `phonanim animate --rig arkit` writes, with its defaults or through the learned face alone."""
    found = [animate(textgrid(recordings, clip), options) for clip in clips]
    return [on_head(animation, clip.times, stage) for animation, clip in zip(found, clips, strict=True)]


def openfacefx(clips: list[Clip], folder: Path, stage: Stage) -> list[Array]:
    """What OpenFaceFX wrote with its defaults."""
    found = [track_json.read(folder / f"{clip.name}.track.json") for clip in clips]
    return [on_head(animation, clip.times, stage) for animation, clip in zip(found, clips, strict=True)]


def on_head(animation: Animation, times: Array, stage: Stage) -> Array:
    """An animation's curves as controls of the head at instants, (times,) seconds -> (times, controls)."""
    weights = stage.head.weights(animation.values, animation.channels)
    return np.column_stack([np.interp(times, animation.times, curve) for curve in weights.T])


def mouths(corpus: Corpus, stage: Stage) -> Array:
    """ARKit poses of Rhubarb's mouths, (9, controls): mean captured faces in the middle of their sounds."""
    visemes = load_rig("rhubarb").visemes
    assert visemes is not None
    faces: list[list[Array]] = [[] for _ in load_rig("rhubarb").controls]
    for clip in corpus.clips_of("train"):
        bounds, shapes = spoken_shapes(corpus.tracks[clip], visemes)
        seen = nearest(corpus.times(clip), (bounds[:-1] + bounds[1:]) / 2)
        captured = corpus.landmarks[corpus.rows([clip])]
        for shape, frame in zip(shapes, seen, strict=True):
            faces[shape].append(captured[frame])
    means = np.array([np.mean(found, axis=0) for found in faces])
    return solved_faces(means.astype(np.float64), stage, np.ones(len(means), np.int64))


def rhubarb(clips: list[Clip], recordings: Path, drawn: Array, blend: float) -> list[Array]:
    """Drawn mouths one after the other as poses of the head; `blend` seconds from one to the next."""
    found = []
    for clip in clips:
        steps = animate(textgrid(recordings, clip), Options(rig="rhubarb", fps=DRAWN_FPS))
        shown = blended(steps.values, round(blend * DRAWN_FPS))
        frames = np.minimum((clip.times * DRAWN_FPS).astype(int), len(shown) - 1)
        found.append(shown[frames] @ drawn)
    return found


def blended(values: NDArray[np.float32], frames: int) -> Array:
    """The mean over a window of frames about each, (n, channels) -> (n, channels)."""
    if frames < 2:
        return values.astype(np.float64)
    padded = np.pad(values.astype(np.float64), ((frames // 2, (frames - 1) // 2), (0, 0)), "edge")
    return np.lib.stride_tricks.sliding_window_view(padded, frames, axis=0).mean(axis=-1)


def textgrid(recordings: Path, clip: Clip) -> Path:
    return recordings / "textgrid" / f"{clip.name}.TextGrid"


def score_clips(
    clips: list[Clip], found: list[Array], solved: list[Array], stage: Stage
) -> dict[str, dict[str, float | None]]:
    """Every measure of every clip, null where a clip has none (no f or v, a head that stays still)."""
    rests = offsets(clips, found, stage)
    rows = [
        score([clip], [mine], [best], stage, rests)
        for clip, mine, best in zip(clips, found, solved, strict=True)
    ]
    return {
        clip.name: {key: value if np.isfinite(value) else None for key, value in row.items()}
        for clip, row in zip(clips, rows, strict=True)
    }


def pooled(clips: list[Clip], found: list[Array], solved: list[Array], stage: Stage) -> dict[str, float]:
    """The same over the frames of all clips."""
    return score(clips, found, solved, stage, offsets(clips, found, stage))


def offsets(clips: list[Clip], found: list[Array], stage: Stage) -> Array:
    """How the head differs from the speaker as a person: its mean less his, (landmarks, 3) mm."""
    head = stage.landmark_rig.pose(np.concatenate(found)).mean(axis=0)
    return np.asarray(head - np.concatenate([clip.captured for clip in clips]).mean(axis=0))


def score(
    clips: list[Clip], found: list[Array], solved: list[Array], stage: Stage, rests: Array
) -> dict[str, float]:
    """Measures of some clips together; `rests` is taken off the head before landmarks are compared."""
    head = stage.landmark_rig.pose(np.concatenate(found))
    captured = np.concatenate([clip.captured for clip in clips])
    speech = np.concatenate([clip.speech for clip in clips])
    result = {}
    for name, measured in LIPS.items():
        mine, wanted = measured(head, stage.face), measured(captured, stage.face)
        result[f"{name}_r"] = correlation(mine, wanted)
        result[f"{name}_r_speech"] = correlation(mine[speech], wanted[speech])
        result[f"{name}_sd_ratio_speech"] = float(mine[speech].std() / wanted[speech].std())
    error = distances(head - rests, captured)[:, stage.face.moving].mean(axis=1)
    result |= {"vertex_error_mm": float(error.mean()), "vertex_error_speech_mm": float(error[speech].mean())}
    pairs = list(zip(found, solved, strict=True))
    lips = [lip_vertex_error(stage.lip_vertices(a), stage.lip_vertices(b), slice(None)) for a, b in pairs]
    return result | {"lve_mm": float(np.concatenate(lips).mean())} | dynamics(clips, found, stage)


def dynamics(clips: list[Clip], found: list[Array], stage: Stage) -> dict[str, float]:
    """Closures, visemes read from the lips, delay and liveliness of the lip opening: means over clips."""
    heads = [stage.landmark_rig.pose(mine) for mine in found]
    openings = [lip_aperture(head, stage.face) for head in heads]
    captured = [lip_aperture(clip.captured, stage.face) for clip in clips]
    result = {
        f"{name}_gap_mm": mean(
            opening[clip.contacts[name]] for opening, clip in zip(openings, clips, strict=True)
        )
        for name in CONTACTS
    }
    readings = [visemes_read(head, clip, stage) for head, clip in zip(heads, clips, strict=True)]
    result["visemes_right"] = pooled_reading(readings).share()
    fps = 1 / float(np.diff(clips[0].times).mean())
    pairs = list(zip(openings, captured, strict=True))
    delays = np.array([lag(a, b, fps) for a, b in pairs])
    result["lag_ms"], result["aperture_r_without_lag"] = 1000 * mean([delays[:, 0]]), mean([delays[:, 1]])
    result["speed_error_mm_s"] = mean([derivative_error(a, b, fps)] for a, b in pairs)
    result["spectral_distance_db"] = mean([log_spectral_distance(a, b, fps)] for a, b in pairs)
    result["jerk_ratio"] = mean([jerk(a, fps) / jerk(b, fps)] for a, b in pairs)
    return result


def visemes_read(head: Array, clip: Clip, stage: Stage) -> Reading:
    """What the reader of `phonanim evaluate` sees on the lips of a head, (frames, landmarks, 3) mm."""
    seen = see_lips(landmark_lips(head, stage.face.indices), clip.times, clip.track)
    return read_visemes(seen, load_reader())


def mean(groups: Iterable[NDArray[np.generic] | list[float]]) -> float:
    """Mean of all values; NaN where there are none."""
    values = np.concatenate([np.asarray(group, float) for group in groups])
    return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")


def show(rows: dict[str, dict[str, float]]) -> None:
    """A Markdown table, one column per tool."""
    print("|", " | ".join(["", *rows]), "|")
    print("|---|" + "---:|" * len(rows))
    for key in next(iter(rows.values())):
        cells = [f"{row[key]:.3f}" if np.isfinite(row[key]) else "" for row in rows.values()]
        print("|", " | ".join([key, *cells]), "|")


if __name__ == "__main__":
    main()
