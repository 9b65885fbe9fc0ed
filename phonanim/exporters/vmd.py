"""Motion for MikuMikuDance: morphs by their Japanese names and the bone of the head, 30 frames per second.

Names are Shift-JIS, 15 bytes at most. The axes are left-handed: z is turned around.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.animation.keys import reduce_curve, reduce_curves
from phonanim.core.decode import DAMAGE, DecodeError
from phonanim.core.files import atomic_path, read_bounded
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OutputError
from phonanim.exporters._frames import frames_from_zero
from phonanim.exporters._take import build_take, check_times, sample_curves, take_grid
from phonanim.rig.neck import TURNS, angles, is_turn, quaternions, turns_of

SUMMARY = "MikuMikuDance motion: morphs such as あ and the head, 30 frames per second"
FPS = 30
NAME = 15  # bytes of a name
HEADER, MODEL = b"Vocaloid Motion Data 0002".ljust(30, b"\0"), 20
HEAD = "頭"
TURN_KEYS = 10.0  # degrees of error of the head that are allowed per unit of weight error
MIRRORED = np.array([-1.0, -1.0, 1.0, 1.0])  # of a quaternion, when z is turned around
MAX_BYTES = 1 << 28
UNIT = 1.01  # largest part of a unit quaternion, with its rounding
MORPHS = np.dtype([("name", f"S{NAME}"), ("frame", "<u4"), ("weight", "<f4")])
BONES = np.dtype(
    [
        ("name", f"S{NAME}"),
        ("frame", "<u4"),
        ("place", "<f4", 3),
        ("rotation", "<f4", 4),
        ("curve", "u1", 64),
    ]
)


def write(animation: Animation, path: Path, keys: float | None = None) -> None:
    """Write the channels as morphs: vowels and blinks by MMD's names, others by their own.

    With `keys`, frames are left out if linear interpolation is within that error. Raises OutputError when a
    name has no place in the format, or the destination cannot be written.
    """
    dense = frames_from_zero(animation, FPS)
    parts = [
        _morph(name, dense[:, column], keys, path)
        for column, name in enumerate(animation.channels)
        if not is_turn(name)
    ]
    morphs = np.concatenate(parts) if parts else np.zeros(0, MORPHS)
    turns = turns_of(dense, animation.channels)
    bones = np.zeros(0, BONES) if turns is None else _head(turns, keys)
    pieces = [HEADER, b"phonanim".ljust(MODEL, b"\0")]
    for table in (bones, morphs):
        pieces += [np.uint32(len(table)).tobytes(), table.tobytes()]
    pieces.append(bytes(16))  # no camera, light, shadow or switch of inverse kinematics
    with atomic_path(path) as partial:
        partial.write_bytes(b"".join(pieces))


def read(path: Path) -> Animation:
    """Read the morphs and the head. Raises OutputError for a file without morphs, or of another format."""
    try:
        data = read_bounded(path, MAX_BYTES)
        if not data.startswith(HEADER[:25]):
            raise DecodeError("it does not begin with Vocaloid Motion Data 0002")
        bones, at = _table(data, len(HEADER) + MODEL, BONES)
        morphs, _ = _table(data, at, MORPHS)
        return _animation(_by_name(bones), _by_name(morphs), path)
    except (OSError, *DAMAGE) as error:
        raise OutputError(f"{path}: is not a motion of MikuMikuDance with morphs: {error}") from error


@cache
def _names() -> tuple[tuple[str, str], ...]:
    """Control and morph, in the order of the table."""
    with (LEXICON / "formats" / "mmd.csv").open(encoding="utf-8", newline="") as stream:
        return tuple((row["control"], row["morph"]) for row in csv.DictReader(stream))


def _morph(name: str, curve: NDArray[np.float32], keys: float | None, path: Path) -> NDArray[Any]:
    """The keys of one morph. Raises OutputError when its name does not fit."""
    morph = dict(_names()).get(name, name)
    try:
        written = morph.encode("cp932")
    except UnicodeEncodeError:
        written = b"?" * (NAME + 1)
    if len(written) > NAME:
        raise OutputError(
            f"{path}: {name} cannot be the name of a morph, which is Shift-JIS of {NAME} bytes at most; "
            "choose --rig vrm, which has MMD's five vowels"
        )
    frames, weights = np.arange(len(curve)), np.asarray(curve, np.float64)
    if keys is not None:
        reduced = reduce_curve(curve, keys)
        frames, weights = reduced.frames, reduced.values[:, 0]
    table = np.zeros(len(frames), MORPHS)
    table["name"], table["frame"], table["weight"] = written, frames, weights
    return table


def _head(turns: NDArray[np.float64], keys: float | None) -> NDArray[Any]:
    """The keys of the head, with MMD's straight interpolation."""
    frames, rotations = np.arange(len(turns)), quaternions(turns) * MIRRORED
    if keys is not None:
        reduced = reduce_curves(rotations, np.radians(TURN_KEYS * keys) / 2)
        frames, rotations = reduced.frames, reduced.values
    table = np.zeros(len(frames), BONES)
    table["name"], table["frame"], table["rotation"] = HEAD.encode("cp932"), frames, rotations
    table["curve"] = _straight()
    return table


def _straight() -> list[int]:
    """Control points on the diagonal, 20 and 107 of 127 for four curves; three shifted copies follow."""
    row = [20] * 8 + [107] * 8
    return [value for shift in range(4) for value in row[shift:] + ([1, 0, 0])[:shift]]


def _table(data: bytes, at: int, kind: np.dtype[Any]) -> tuple[NDArray[Any], int]:
    """The rows that follow their count, and the place after them. Raises ValueError when it is truncated."""
    count = int(np.frombuffer(data, "<u4", 1, at)[0])
    if count * kind.itemsize > len(data) - at - 4:
        raise DecodeError(f"it is truncated: {count} keys do not fit in it")
    return np.frombuffer(data, kind, count, at + 4), at + 4 + count * kind.itemsize


def _by_name(table: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """The keys of each name, in the order of frames."""
    found: dict[str, NDArray[Any]] = {}
    for name in dict.fromkeys(table["name"].tolist()):
        text = name.split(b"\0")[0].decode("cp932", "replace")
        rows = table[table["name"] == name]
        found[text] = rows[np.argsort(rows["frame"], kind="stable")]
    return found


def _animation(bones: dict[str, NDArray[Any]], morphs: dict[str, NDArray[Any]], path: Path) -> Animation:
    if not morphs:
        raise DecodeError("it has no morphs")
    controls = {morph: control for control, morph in reversed(_names())}
    clocks = {name: rows["frame"].astype(float) / FPS for name, rows in morphs.items()}
    for name, clock in clocks.items():
        check_times(clock, name)
    first = min(clock[0] for clock in clocks.values())
    grid = take_grid(first, max(clock[-1] for clock in clocks.values()), FPS, len(morphs), path)
    values = sample_curves(grid, [(clocks[name], rows["weight"]) for name, rows in morphs.items()])
    names = [controls.get(name, name) for name in morphs]
    if HEAD in bones:
        values = np.concatenate([values, _turns(bones[HEAD], grid)], axis=1)
        names += TURNS
    about = {"provenance": {"input": path.name}}
    return build_take(values, names, float(FPS), float(first), about, path, "vrm")


def _turns(rows: NDArray[Any], grid: NDArray[np.float64]) -> NDArray[np.float32]:
    """Degrees of the head at instants, (times, 3)."""
    clock = rows["frame"].astype(float) / FPS
    if not (np.abs(rows["rotation"]) <= UNIT).all():
        raise DecodeError(f"a rotation of {HEAD} is not a unit quaternion")
    rotations = sample_curves(grid, [(clock, part) for part in rows["rotation"].astype(float).T])
    lengths = np.linalg.norm(rotations, axis=1, keepdims=True)
    return angles(rotations / np.where(lengths > 0, lengths, 1) * MIRRORED).astype(np.float32)
