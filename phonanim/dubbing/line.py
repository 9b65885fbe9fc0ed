"""A line to animate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

from phonanim.dubbing.storage import Place
from phonanim.options import Options
from phonanim.rig.names import NameTable


@dataclass(frozen=True, slots=True)
class Line:
    """One line to animate: absolute places, and `output`, relative to the output folder, without suffix.

    If `text` is given, `alignment` is the recording, which is first aligned with the text; without a
    recording it is None, and the text is spoken by `voice`, or by the voice of the language. `edits` are an
    animator's changes and `corrections` those of a review, which are applied again; `exports` are options of
    output formats, such as `character`; `names` is a table of the names of its shapes.
    """

    id: str
    place: str
    alignment: Place | None
    audio: Place | None
    options: Options
    output: PurePosixPath
    text: str | None = None
    edits: Place | None = None
    corrections: Place | None = None
    exports: Mapping[str, Any] = field(default_factory=dict)
    voice: str = ""
    names: NameTable | None = None

    @property
    def source(self) -> str:
        """What the line is made from, for messages: a file, or the row with its text."""
        return self.place if self.alignment is None else str(self.alignment)

    @property
    def is_spoken(self) -> bool:
        """Whether its speech is made from text."""
        return self.alignment is None
