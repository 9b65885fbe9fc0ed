"""A line to animate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

from phonanim.dubbing.storage import Place
from phonanim.options import Options


@dataclass(frozen=True, slots=True)
class Line:
    """One line to animate: absolute places, and `output`, relative to the output folder, without suffix.

    If `text` is given, `alignment` is the recording, which is first aligned with the text. `edits` are an
    animator's changes and `corrections` those of a review, which are applied again; `exports` are options of
    output formats, such as `character`.
    """

    id: str
    place: str
    alignment: Place
    audio: Place | None
    options: Options
    output: PurePosixPath
    text: str | None = None
    edits: Place | None = None
    corrections: Place | None = None
    exports: Mapping[str, Any] = field(default_factory=dict)
