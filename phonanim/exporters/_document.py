"""An animation as plain values, stored whole in `.json` and next to the arrays in `.npz`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.decode import DAMAGE, DecodeError, decode_list, decode_table
from phonanim.errors import OutputError
from phonanim.exporters._take import build_take, check_size
from phonanim.speech.alignment import pack_intervals

FORMAT = "phonanim animation 1"
DIGITS = 6  # a millionth of full weight; no rig shows smaller differences


def document(animation: Animation) -> dict[str, Any]:
    """The animation as plain values."""
    return {**facts(animation), "curves": dict(curves(animation))}


def curves(animation: Animation) -> Iterator[tuple[str, list[float]]]:
    """The name and the rounded values of each channel, one after the other."""
    for column, name in enumerate(animation.channels):
        values = np.asarray(animation.values[:, column], np.float64)
        yield name, np.round(values, DIGITS).tolist()


def facts(animation: Animation) -> dict[str, Any]:
    """Everything but the curves as plain values."""
    return {
        "format": FORMAT,
        "rig": animation.rig,
        "fps": animation.fps,
        "start": animation.start,
        "frames": len(animation.values),
        "audio": animation.audio.name if animation.audio else None,
        "phones": pack_intervals(animation.phones),
        "words": pack_intervals(animation.words),
        "provenance": animation.provenance,
    }


def from_document(tree: Any, path: Path) -> Animation:
    """The inverse of `document`; the audio file is searched next to `path`. Raises OutputError."""
    try:
        found = decode_table(tree["curves"], "curves")
        return from_values(tree, _columns(found, path), list(found), path)
    except DAMAGE as error:
        raise not_ours(path, error) from error


def from_values(tree: Any, values: NDArray[Any], channels: list[str], path: Path) -> Animation:
    """The animation of (frames, channels) values and the rest of the document. Raises DecodeError."""
    if tree["format"] != FORMAT:
        raise DecodeError(f"its format is {tree['format']!r}, not {FORMAT!r}")
    return build_take(values, channels, tree["fps"], tree["start"], tree, path)


def not_ours(path: Path, error: BaseException) -> OutputError:
    """The error of a file that cannot be read back."""
    reason = f"it lacks {error}" if isinstance(error, KeyError) else " ".join(str(error).split())
    return OutputError(f"{path}: is not an animation written by phonanim: {reason}")


def _columns(curves: dict[str, Any], path: Path) -> NDArray[np.float32]:
    """Lists of equal length as columns, (frames, channels)."""
    lengths = {len(decode_list(curve, name)) for name, curve in curves.items()}
    if len(lengths) != 1:
        raise DecodeError(f"its {len(curves)} curves have {len(lengths)} lengths")
    frames = lengths.pop()
    check_size(frames, len(curves), path)
    values = np.empty((frames, len(curves)), np.float32)
    for column, (name, curve) in enumerate(curves.items()):
        numbers = np.asarray(curve, np.float64)
        if numbers.shape != (frames,):
            raise DecodeError(f"{name} is not a list of numbers")
        with np.errstate(over="ignore"):  # beyond float32 is infinite, which is refused later
            values[:, column] = numbers
    return values
