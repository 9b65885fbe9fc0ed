"""Score one motion against another: files or animations in, all measures out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.errors import PhonanimError
from phonanim.evaluation.predictions import Motion, Vertices, read_motion, read_template
from phonanim.evaluation.scoring import Scores, score
from phonanim.evaluation.surfaces import Settings
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Alignment
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

Template = str | Path | NDArray[np.float64]


def evaluate(
    predicted: str | Path | Motion,
    reference: str | Path | Motion,
    *,
    alignment: str | Path | Alignment | PhoneTrack | None = None,
    language: str = "auto",
    masks: Mapping[str, NDArray[np.int64]] | None = None,
    lips: tuple[int, ...] = (),
    template: Template | None = None,
    reference_template: Template | None = None,
    unit: str | None = None,
    fps: float | None = None,
    reference_fps: float | None = None,
) -> Scores:
    """Compare predicted motion with a reference; `phonanim evaluate` prints the result.

    Both sides are animations, or files of curves (.csv, .npz, .json, .glb, .usda) or of vertices (.npy). The
    result has `measures` by name, such as `mve_mm`, and `notes`. docs/measures.md defines each measure.

    Args:
        predicted: The output of a tool.
        reference: The motion to compare with, such as a capture.
        alignment: The alignment of the speech, for measures of single phones.
        language: The labels of the alignment.
        masks: Vertex numbers of a region, by the name of the region.
        lips: Four vertices of the mesh: upper lip, lower lip, right and left corner.
        template: The mesh at rest, (vertices, 3), or its file.
        reference_template: The same of the reference, if it is another face.
        unit: Of vertices: "m", "cm" or "mm"; by default it is detected by the size of the mesh.
        fps: Frames per second of a .npy of predictions; 30 when it is None.
        reference_fps: Frames per second of a .npy of references; `fps` when it is None.

    Raises:
        EvaluationError: The two sides share no instants, no controls and no mesh, or a file cannot be read.

    Examples:
        >>> import phonanim
        >>> line = phonanim.animate("line.TextGrid", rig="arkit", fps=30)
        >>> less = phonanim.animate("line.TextGrid", rig="arkit", fps=30, intensity=0.5)
        >>> scores = phonanim.evaluate(less, line, alignment="line.TextGrid")
        >>> scores.measures["mve_mm"] > 0
        True
    """
    rest = _mesh(template)
    other = rest if reference_template is None else _mesh(reference_template)
    settings = Settings(
        masks=masks or {},
        lips=lips,
        template=rest,
        reference_template=None if reference_template is None else other,
        unit=unit,
        track=_phones(alignment, language),
    )
    ours = _motion(predicted, fps, rest)
    theirs = _motion(reference, reference_fps or fps, other)
    try:
        return score(ours, theirs, settings)
    except PhonanimError as error:
        names = [str(side) for side in (predicted, reference) if isinstance(side, str | Path)]
        if len(names) < 2:
            raise
        raise type(error)(f"{names[0]} against {names[1]}: {error}") from error


def _motion(side: str | Path | Motion, fps: float | None, template: NDArray[np.float64] | None) -> Motion:
    return side if isinstance(side, Animation | Vertices) else read_motion(Path(side), fps, template)


def _mesh(template: Template | None) -> NDArray[np.float64] | None:
    return read_template(Path(template)) if isinstance(template, str | Path) else template


def _phones(given: Any, language: str) -> PhoneTrack | None:
    if given is None or isinstance(given, PhoneTrack):
        return given
    alignment = given if isinstance(given, Alignment) else read_alignment(Path(given))
    return to_phones(alignment, language)[0]
