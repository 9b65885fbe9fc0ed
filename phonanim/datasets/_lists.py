"""Data sets of one speaker without a published layout: arrays, sounds and labels with the same names."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from phonanim.datasets import Recording, intervals, not_found
from phonanim.datasets._files import frames_of, read_list, sound_loader
from phonanim.datasets._splits import EIGHTY_TWENTY, Cuts, draw_splits

LABELS = (".TextGrid", ".lab")


def list_recordings(
    folder: Path,
    title: str,
    motion: str,
    fps: float,
    axes: int,
    names: tuple[str, ...] = (),
    cuts: Cuts = EIGHTY_TWENTY,
    seed: int = 0,
) -> Iterator[Recording]:
    """Recordings `<motion>/<name>.npy`, `wav/<name>.wav` and optional `phones/<name>.TextGrid` or `.lab`.

    The split is that of `train.lst` and `test.lst`, one name per line; without these files it is drawn.
    Raises CorpusError when the folder has no such arrays.
    """
    paths = sorted((folder / motion).glob("*.npy"))
    if not paths:
        raise not_found(folder, title, f"{motion}/<name>.npy")
    splits = _splits(folder, [path.stem for path in paths], cuts, seed)
    for path in paths:
        labels = [folder / "phones" / f"{path.stem}{suffix}" for suffix in LABELS]
        label = next((label for label in labels if label.is_file()), None)
        yield Recording(
            path.stem,
            title,
            splits.get(path.stem, ""),
            partial(frames_of, path, fps, axes, names, "mm" if axes > 1 else ""),
            sound_loader(folder / "wav" / f"{path.stem}.wav"),
            partial(intervals, label) if label else None,
        )


def _splits(folder: Path, names: list[str], cuts: Cuts, seed: int) -> dict[str, str]:
    lists = {"train": folder / "train.lst", "test": folder / "test.lst"}
    if all(path.is_file() for path in lists.values()):
        return {name: split for split, path in lists.items() for name in read_list(path)}
    return draw_splits(dict.fromkeys(names, ""), cuts, np.random.default_rng(seed))
