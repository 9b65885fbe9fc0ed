"""What audio-driven models are trained on: all clips at the model's steps, in memory or in files.

Targets of a mesh are gigabytes, so clips are read one by one, and large arrays lie in files without a name.
"""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from tempfile import TemporaryFile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.regressors import Examples
from phonanim.regressors._audio_input import AudioInput
from phonanim.regressors._steps import features_at_steps, step_times

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
LARGE = 1 << 28  # bytes of an array of all steps that stays in memory
BLOCK = 1 << 25  # bytes of such an array that are handled at a time
COLUMNS = 1024  # of targets that are interpolated at a time
STILL = 1e-6  # standard deviation below which a feature counts as constant


@dataclass(frozen=True)
class Steps:
    """Clips end to end on the model's grid: `values` (steps, layers, dims), `targets` (steps, modes).

    `codes` and `segments` (steps,) are the phones and their running numbers, `lengths` (clips,) in steps,
    `styles` (clips,) numbers from 0, all 0 for a model of one style.
    """

    values: NDArray[np.float16]
    targets: Floats
    codes: NDArray[np.int64]
    segments: NDArray[np.int64]
    lengths: NDArray[np.int64]
    weights: Floats
    styles: NDArray[np.int64]

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """First step of each clip."""
        return np.cumsum(self.lengths) - self.lengths


def gather_steps(kind: type[AudioInput], config: Any, examples: Examples, layers: int = 0) -> Steps:
    """Inputs and targets of a kind of model from examples, at the model's steps.

    `layers` is how many of the encoder's last layers are kept; 0 keeps all. Clips are read one by one, and
    large arrays lie in unnamed files, so that the memory used is that of a clip.
    """
    assert all(sound is not None for sound in examples.sounds)
    grids = [step_times(sound.duration, config.rate) for sound in examples.sounds]
    lengths = np.array([len(grid) for grid in grids])
    values: NDArray[np.float16] | None = None
    targets: Floats | None = None
    codes, segments, first = [], [], 0
    for track, times, target, sound, grid in zip(
        examples.tracks, examples.times, examples.targets, examples.sounds, grids, strict=True
    ):
        features = features_at_steps(kind.input_features(config, sound, track), grid, config.rate)[
            :, -layers:
        ]
        if values is None or targets is None:
            values = new_rows((int(lengths.sum()), *features.shape[1:]), np.float16)
            targets = new_rows((int(lengths.sum()), target.shape[1]), np.float32)
        rows = slice(first, first + len(grid))
        values[rows] = features
        for column in range(0, target.shape[1], COLUMNS):
            some = slice(column, column + COLUMNS)
            targets[rows, some] = interpolate_columns(grid, times, target[:, some])
        release(values)
        release(targets)
        codes.append(track.sample(grid))
        segments.append(track.segment_at(grid))
        first += len(grid)
    assert values is not None
    assert targets is not None
    return Steps(
        values,
        targets,
        np.concatenate(codes).astype(np.int64),
        np.concatenate(segments),
        lengths,
        np.asarray(examples.weights, np.float32),
        np.array(examples.styles if examples.styles and config.styles > 1 else [0] * len(examples), np.int64),
    )


def interpolate_columns(at: Array, times: Array, values: NDArray[np.floating]) -> Array:
    """What np.interp gives for each column, (steps,) and (frames,) seconds, (frames, n) -> (steps, n)."""
    left = np.clip(np.searchsorted(times, at, side="right") - 1, 0, max(len(times) - 2, 0))
    right = np.minimum(left + 1, len(times) - 1)
    low, high = values[left].astype(np.float64), values[right].astype(np.float64)
    apart = np.where(right > left, times[right] - times[left], 1.0)
    found = (high - low) / apart[:, None] * (at - times[left])[:, None] + low
    found[at <= times[0]], found[at >= times[-1]] = values[0], values[-1]
    return np.asarray(found)


def new_rows(shape: tuple[int, ...], kind: Any) -> NDArray[Any]:
    """An array to fill: in memory, or where it is larger than LARGE in a file without a name."""
    size = int(np.prod(shape)) * np.dtype(kind).itemsize
    if size <= LARGE:
        return np.empty(shape, kind)
    with TemporaryFile() as file:  # the memory map keeps it open, and the disk frees it after that
        return np.memmap(file, kind, "w+", shape=shape)


@dataclass(frozen=True)
class Scaling:
    """Features to mean 0 and deviation 1 for each dim of each layer, targets as configured."""

    centre: Floats
    scale: Floats
    low: Floats
    span: Floats

    @classmethod
    def of(cls, config: Any, steps: Steps) -> Scaling:
        """Compute the scaling of the training clips."""
        centre = steps.values.mean(axis=0, dtype=np.float64)
        square = np.zeros_like(centre)
        for begin in range(0, len(steps.values), 8192):
            square += ((steps.values[begin : begin + 8192] - centre) ** 2).sum(axis=0)
        # A constant feature has no information; scaled by its tiny deviation, any change would dominate.
        deviation = np.sqrt(square / len(steps.values))
        scale = (deviation > STILL) / (deviation + 1e-3)
        targets = steps.targets
        if config.normalize == "minmax":
            low, high = column_range(targets)
            span = high - low + 1e-6
        else:
            low, span = column_means(targets), np.full(targets.shape[1], overall_deviation(targets))
        return cls(*(np.asarray(part, np.float32) for part in (centre, scale, low, span)))


def column_means(targets: Floats) -> Floats:
    """Mean of each column, (steps, modes) -> (modes,); of one on disk without all of it in memory."""
    total: Floats | None = None
    for rows in blocks_of(targets):
        # As one sum over all rows, row by row in single precision.
        total = (rows if total is None else np.concatenate([total[None], rows])).sum(axis=0)
    assert total is not None
    return np.asarray(total / np.float32(len(targets)), np.float32)


def column_range(targets: Floats) -> tuple[Floats, Floats]:
    """Least and greatest of each column, (steps, modes) -> (modes,) each."""
    low, high = targets[0].copy(), targets[0].copy()
    for rows in blocks_of(targets):
        low, high = np.minimum(low, rows.min(axis=0)), np.maximum(high, rows.max(axis=0))
    return low, high


def overall_deviation(targets: Floats) -> float:
    """Standard deviation of all numbers of an array, without a copy of one on disk."""
    if not isinstance(targets, np.memmap):
        return float(targets.std())
    mean, total = np.mean(column_means(targets), dtype=np.float64), 0.0
    for rows in blocks_of(targets):
        total += float(((rows - mean) ** 2).sum(dtype=np.float64))
    return float(np.sqrt(total / targets.size))


def column_deviations(targets: Floats) -> NDArray[Any]:
    """Standard deviation of each column, (steps, modes) -> (modes,), without a copy of one on disk."""
    if not isinstance(targets, np.memmap):
        return np.asarray(targets.std(axis=0))
    mean = column_means(targets).astype(np.float64)
    square = np.zeros_like(mean)
    for rows in blocks_of(targets):
        square += ((rows - mean) ** 2).sum(axis=0)
    return np.asarray(np.sqrt(square / len(targets)))


def blocks_of(array: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Rows of an array in blocks of at most BLOCK bytes; of one on disk no more stays in memory."""
    count = max(1, BLOCK // max(1, array[:1].nbytes))
    for begin in range(0, len(array), count):
        yield array[begin : begin + count]
        release(array)


def release(array: NDArray[Any]) -> None:
    """Let go of the memory of an array on disk; the file keeps it."""
    if isinstance(array, np.memmap) and hasattr(mmap, "MADV_DONTNEED"):
        array._mmap.madvise(mmap.MADV_DONTNEED)  # type: ignore[attr-defined]
