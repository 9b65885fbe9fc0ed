"""Make a folder of recordings as `phonanim corpus track` makes it from films, without a film.

    python make_recordings.py recordings

The words of examples/line.TextGrid are shuffled into twelve sentences; the shipped head speaks them, and its
landmarks, turned a little and with noise, are those of the film. So a model that learns from it learns from
phonanim itself: it shows that every step works, and nothing about quality.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import phonanim
from phonanim.rig import load_rig
from phonanim.rig.head import TONGUE, load_head
from phonanim.rig.landmarks import read_landmarks
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

LINE = Path(__file__).resolve().parent / "line.TextGrid"
CLIPS, TEST, FPS = 12, 2, 25
PUPILS = 46.0  # pixels between the pupils
NOISE = 0.3  # pixels, of a tracker
TURN = 0.05  # radians
SCALE = 0.05  # pixels of one step of what is stored
PAUSE = 0.3  # seconds before and after


def shuffle_line(rng: np.random.Generator) -> tuple[list[Interval], list[Interval], float]:
    """The words and phones of the line in another order, and the seconds in all."""
    alignment = phonanim.read_alignment(LINE)
    words, phones, time = [], [Interval("sil", 0.0, PAUSE)], PAUSE
    spoken = [word for word in alignment.words if word.label.strip()]
    for index in rng.permutation(len(spoken)):
        word, shift = spoken[index], time - spoken[index].start
        inside = [one for one in alignment.intervals if word.start <= (one.start + one.end) / 2 < word.end]
        phones += [move(one, shift) for one in inside]
        words.append(move(word, shift))
        time = words[-1].end
    return words, [*phones, Interval("sil", time, time + PAUSE)], time + PAUSE


def move(interval: Interval, seconds: float) -> Interval:
    """The same later, to the millisecond."""
    return Interval(interval.label, round(interval.start + seconds, 3), round(interval.end + seconds, 3))


def film_head(alignment: Path, rng: np.random.Generator) -> np.ndarray:
    """Landmarks of the head that speaks, (frames, landmarks, 3) pixels: x right, y down, z away."""
    animation = phonanim.animate(alignment, rig="arkit", fps=FPS, life=0)
    head = load_head().without(TONGUE)
    weights = head.weights(animation.values, animation.channels)
    spots = read_landmarks(load_rig("arkit").landmarks)
    points = np.stack([spots.of(head.shape(row)) for row in weights])
    points = (points - points[0].mean(axis=0)) * PUPILS / np.linalg.norm(points[0, 468] - points[0, 473])
    angle = rng.normal(0, TURN)
    across = np.cos(angle) * points[..., 0] + np.sin(angle) * points[..., 2]
    ahead = np.cos(angle) * points[..., 2] - np.sin(angle) * points[..., 0]
    turned = np.stack([180 + across, 144 - points[..., 1], -ahead], axis=-1)
    return np.asarray(turned + rng.normal(0, NOISE, turned.shape))


def main() -> None:
    """Write the folder."""
    folder, rng = Path(sys.argv[1]), np.random.default_rng(1)
    (folder / "textgrid").mkdir(parents=True)
    names = [f"sentence{number + 1:02d}" for number in range(CLIPS)]
    films = []
    for name in names:
        words, phones, seconds = shuffle_line(rng)
        path = folder / "textgrid" / f"{name}.TextGrid"
        write_textgrid(path, {"words": words, "phones": phones}, seconds)
        films.append(film_head(path, rng))
    steps = np.round(np.concatenate(films) / SCALE).astype(np.int32)
    np.savez(
        folder / "landmarks.npz",
        clips=np.array(names),
        frames=np.array([len(film) for film in films], np.int32),
        delta=np.diff(steps, axis=0, prepend=0).astype(np.int16),
        indices=np.arange(films[0].shape[1]).astype(np.int16),
        scale=np.float32(SCALE),
        fps=np.float32(FPS),
    )
    splits = ["train"] * (CLIPS - TEST) + ["test"] * TEST
    rows = [f"{name},{len(film)},{split}" for name, film, split in zip(names, films, splits, strict=True)]
    (folder / "clips.csv").write_text("\n".join(["clip,frames,split", *rows]) + "\n", "utf-8")
    print(f"wrote {folder}: {CLIPS} clips, {len(steps)} frames")


if __name__ == "__main__":
    main()
