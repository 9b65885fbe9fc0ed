"""An animation as plain values, which `.json` stores whole and `.npz` beside its arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.errors import OutputError
from phonanim.speech.alignment import pack_intervals, unpack_intervals

FORMAT = "phonanim animation 1"
DIGITS = 6  # a millionth of full weight; finer than float32 at 1 is not seen by any rig


def document(animation: Animation) -> dict[str, Any]:
    """The animation as plain values."""
    curves = np.round(np.asarray(animation.values, np.float64), DIGITS).T.tolist()
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
        "curves": dict(zip(animation.channels, curves, strict=True)),
    }


def from_document(tree: Any, path: Path) -> Animation:
    """The inverse of `document`; the audio is looked for beside `path`."""
    try:
        if tree["format"] != FORMAT:
            raise ValueError(f"its format is {tree['format']!r}, not {FORMAT!r}")
        curves = [np.asarray(curve, np.float32) for curve in tree["curves"].values()]
        return Animation(
            values=np.stack(curves, axis=1) if curves else np.zeros((tree["frames"], 0), np.float32),
            channels=tuple(tree["curves"]),
            fps=float(tree["fps"]),
            rig=str(tree["rig"]),
            start=float(tree["start"]),
            phones=unpack_intervals(tree["phones"]),
            words=unpack_intervals(tree["words"]),
            audio=path.parent / tree["audio"] if tree["audio"] else None,
            provenance=dict(tree["provenance"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise OutputError(f"{path}: is no animation written by phonanim: {error}") from error
