"""The appearance model and the search on the test clips: what it keeps, how far it is from the tracker.

    python benchmarks/appearance.py RECORDINGS/grid_s1 work/corpus [MOUTH ...]
    python benchmarks/appearance.py RECORDINGS/grid_s1 work/corpus --tune     (on training clips)

The corpus has its appearance already (`phonanim corpus appearance`); mouths are folders of
`phonanim mouth train`, scored in joint parameters, landmarks and pixels.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.corpus.pictures import Captured, MouthFilms, load_captured, open_mouth_films, pixel_mse
from phonanim.face.aam import Fitter, Options, build_fitter, track_face
from phonanim.face.model import FaceModel, lip_aperture, lip_width
from phonanim.metrics import correlation
from phonanim.training.mouth import load_mouth

Array = NDArray[np.float64]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("recordings", type=Path)
    options.add_argument("corpus", type=Path)
    options.add_argument("mouths", type=Path, nargs="*", metavar="MOUTH")
    options.add_argument("--tune", action="store_true")
    chosen = options.parse_args()
    if chosen.tune:
        tune(chosen.recordings, chosen.corpus)
    else:
        score_all(chosen.recordings, chosen.corpus, chosen.mouths)


def score_all(recordings: Path, folder: Path, mouths: list[Path]) -> None:
    """What the model keeps, what mouths make of the test clips, and the search on them."""
    corpus, captured = load_corpus(folder), load_captured(folder)
    describe(captured)
    own = captured.joint[captured.rows].astype(float)
    score("the model itself", own, corpus, captured)
    score("the mean", np.zeros_like(own), corpus, captured)
    for mouth in mouths:
        score(mouth.name, spoken(mouth, corpus), corpus, captured)
    films, fitter = open_mouth_films(recordings, corpus), build_fitter(captured.model)
    light(films, captured)
    clips = [int(clip) for clip in corpus.clips_of("test")]
    started = time.perf_counter()
    found = {clip: follow(fitter, films, clip) for clip in clips}
    seconds = time.perf_counter() - started
    n_frames = int(corpus.frames[clips].sum())
    print(f"search: {n_frames} frames, {n_frames / seconds:.0f} per second with decoding")
    report(captured.model.face, films, found)


def describe(captured: Captured) -> None:
    model = captured.model
    parts = {"shape": model.face, "outer": model.outer, "inner": model.inner, "joint": model}
    print("modes:", ", ".join(f"{name} {len(part.std)}" for name, part in parts.items()))
    print(f"pixels: {len(model.mesh.pixels)}, of them inside the mouth {len(model.inner.place)}")


def light(films: MouthFilms, captured: Captured) -> None:
    """How much of the pixels' variance over training clips is the light of each clip."""
    model = captured.model
    cuts = [films.cut(int(c), model.face, model.rows, model.mesh, 4) for c in spread(films, 60)]
    lit = np.concatenate([textures for _, textures in cuts])
    plain = np.concatenate([model.without_light(textures, modes) for modes, textures in cuts])
    for name, region in (("outer", model.outer), ("inner", model.inner)):
        share = 1 - plain[:, region.place].var(axis=0).sum() / lit[:, region.place].var(axis=0).sum()
        print(f"light: {share:.0%} of the variance of the {name} region")


def tune(recordings: Path, folder: Path) -> None:
    """The search on six training clips under other options."""
    corpus, captured = load_corpus(folder), load_captured(folder)
    films = open_mouth_films(recordings, corpus)
    for outer, inner, noise in ((5, 5, 40), (0, 5, 40), (20, 10, 40), (5, 5, 10), (5, 5, 80)):
        fitter = build_fitter(captured.model, Options(outer, inner, noise, likeness=0.5))
        print(f"{outer} outer modes and {inner} inner projected out, noise {noise}")
        report(captured.model.face, films, {c: follow(fitter, films, c) for c in spread(films, 6)})


def spread(films: MouthFilms, count: int) -> list[int]:
    """Training clips, evenly spread."""
    clips = films.corpus.clips_of("train")
    return [int(clip) for clip in clips[:: len(clips) // count][:count]]


def score(name: str, joint: Array, corpus: Corpus, captured: Captured) -> None:
    """Joint modes of the test clips: mean squared errors in the three spaces of Taylor 2017, figure 10."""
    model = captured.model
    seen = corpus.landmarks[captured.rows].astype(float)
    apart = (model.face.instance(model.instance(joint)[0]) - seen)[:, model.face.moving]
    parameters = ((joint - captured.joint[captured.rows]) ** 2).mean()
    error = pixel_mse(model, joint, captured.grey)
    pixels = ", ".join(f"{p} {getattr(error, p).mean():.2f}" for p in ("whole", "inner", "outer"))
    print(f"{name}: parameters {parameters:.0f}, landmarks {(apart**2).mean():.3f} mm², pixels {pixels}")


def spoken(folder: Path, corpus: Corpus) -> Array:
    """What a mouth makes of the test clips, (frames, j)."""
    mouth = load_mouth(folder)
    clips = corpus.clips_of("test")
    return np.concatenate([mouth.predict(corpus.tracks[c], corpus.times(c)) for c in clips]).astype(float)


def follow(fitter: Fitter, films: MouthFilms, clip: int) -> tuple[Array, Array, Array]:
    """Landmarks (frames, landmarks, 3) px, shapes (frames, landmarks, 3) mm and likeness of one clip."""
    poses = list(track_face(fitter, films.film(clip)))
    face, blank = fitter.model.face, np.full((len(fitter.model.face.mean), 3), np.nan)
    points = np.stack([fitter.landmarks(pose) if pose else blank for pose in poses])
    shapes = [face.instance(p.shape[None, : len(face.std)] * face.std)[0] if p else blank for p in poses]
    return points, np.stack(shapes), np.array([pose.likeness if pose else 0.0 for pose in poses])


def report(face: FaceModel, films: MouthFilms, found: dict[int, tuple[Array, Array, Array]]) -> None:
    rows = films.corpus.rows(found)
    points, shapes, likeness = (np.concatenate([f[k] for f in found.values()]) for k in range(3))
    captured, tracked = films.corpus.landmarks[rows].astype(float), films.landmarks[rows][:, face.moving]
    seen = likeness > 0
    mean, scale = mean_shape(face, tracked)
    least, middle = likeness[seen].min(), np.median(likeness)
    print(f"rejected: {(~seen).sum()}; likeness least {least:.3f}, median {middle:.3f}")
    for name, places in (("search", points[:, face.moving, :2]), ("mean shape", mean)):
        apart = np.linalg.norm(places - tracked, axis=2).mean(axis=1)[seen]
        worst = np.percentile(apart, 95)
        print(f"{name}: {apart.mean():.3f} px, 95 % below {worst:.2f}; {(apart / scale[seen]).mean():.3f} mm")
    for name, guess in (("search", shapes), ("mean shape", np.broadcast_to(face.mean, shapes.shape))):
        apart = np.linalg.norm((guess - captured)[:, face.moving], axis=2)[seen]
        print(f"{name}, shape alone in 3-D: {apart.mean():.3f} mm")
    for name, measure in (("aperture", lip_aperture), ("width", lip_width)):
        print(f"{name} r {correlation(measure(shapes[seen], face), measure(captured[seen], face)):.3f}")


def mean_shape(face: FaceModel, tracked: NDArray[np.floating]) -> tuple[Array, Array]:
    """The mean shape laid onto tracked points (frames, n, 2) by similarities, and pixels per mm (frames,)."""
    flat = (face.mean[face.moving, :2] * np.array([1.0, -1.0])) @ np.array([1, 1j])
    seen = tracked @ np.array([1, 1j])
    flat, middle = flat - flat.mean(), seen.mean(axis=1, keepdims=True)
    turn = (seen - middle) @ flat.conj() / (np.abs(flat) ** 2).sum()
    placed = turn[:, None] * flat + middle
    return np.stack([placed.real, placed.imag], axis=2), np.abs(turn)


if __name__ == "__main__":
    main()
