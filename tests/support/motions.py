"""A small made-up corpus of controls, sensors or vertices, with phones and words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from speech import made_up_corpus

from phonanim.corpus.motion import MotionClip, MotionCorpus, save_motion_corpus
from phonanim.targets import Source

KINDS = ("controls", "sensors", "vertices")
NAMES = {"controls": ("jawDown", "mouthWide", "noseStill"), "sensors": ("UL", "LL", "LI"), "vertices": ()}
UNITS = {"controls": "", "sensors": "mm", "vertices": "m"}


def made_up_motion(kind: str, folder: Path) -> Path:
    """A mouth that opens by a number of each phone, with noise, as motion of a kind."""
    rng, spoken = np.random.default_rng(4), made_up_corpus(np.random.default_rng(3))
    size, clips = {"controls": (3,), "sensors": (3, 3), "vertices": (5, 3)}[kind], []
    shape = rng.normal(0, 1, (2, *size))
    if kind == "controls":
        shape[:, 2] = 0
    opening, rest = rng.normal(0, 1, (2, 256)), rng.normal(0, 1, size)
    for number, name in enumerate(spoken.clips):
        track, count = spoken.tracks[number], int(spoken.frames[number])
        codes = track.sample(np.arange(count) / 25)
        values = rest + np.tensordot(opening[:, codes].T, shape, 1)
        values = values + rng.normal(0, 0.1, values.shape) * (np.abs(shape).sum(axis=0) > 0)
        path = folder / "motion" / f"{name}.npy"
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, values.astype(np.float32))
        split = "train" if number in spoken.clips_of("train") else "test"
        clips.append(
            MotionClip(name, "anna", split, count, path, None, track, spoken.words[number], aligned=True)
        )
    templates = {"anna": rest} if kind != "controls" else {}
    source = Source("made_up", NAMES[kind], UNITS[kind], templates)
    save_motion_corpus(
        MotionCorpus(kind, 25.0, source, tuple(clips), {"source": "made up"}), folder / "corpus"
    )
    return folder
