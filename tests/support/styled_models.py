"""Small models that have learned the styles of made-up speakers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from motions import made_up_motion

from phonanim.__main__ import run
from phonanim.corpus.motion import load_motion_corpus, save_motion_corpus


def spoken_by(speakers: Sequence[str], folder: Path, kind: str = "controls") -> Path:
    """A corpus whose clips are by these speakers in turn; -> its folder."""
    corpus = load_motion_corpus(made_up_motion(kind, folder) / "corpus")
    clips = tuple(
        replace(clip, subject=speakers[number % len(speakers)]) for number, clip in enumerate(corpus.clips)
    )
    save_motion_corpus(replace(corpus, clips=clips), folder / "corpus")
    return folder / "corpus"


def trained_on(corpus: Path, recipe: str, name: str = "model") -> int:
    """Train a recipe beside the corpus, into a folder of this name; -> the exit code."""
    path = corpus.with_name(f"{name}.toml")
    path.write_text(f'corpus = "{corpus.name}"\n{recipe}\n', "utf-8")
    return run(["train", str(path), "-o", str(corpus.with_name(name))])
