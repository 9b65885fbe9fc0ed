"""The pictures of `phonanim evaluate`: maps of errors and of motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from phonanim.evaluation.heat import Heat
    from phonanim.evaluation.motion_map import MotionMap
    from phonanim.evaluation.predictions import Motion


@dataclass(frozen=True)
class Maps:
    """What --heat and --motion-map gather, where they are asked for, and where they are drawn."""

    heat: tuple[Heat, Path] | None
    motion: tuple[MotionMap, Path] | None

    def add(self, predicted: Motion, captured: Motion) -> None:
        """Add a line. Raises EvaluationError for curves against vertices, and for two meshes."""
        from phonanim.evaluation.heat import add_matched

        if self.heat:
            add_matched(self.heat[0], predicted, captured)
        if self.motion:
            self.motion[0].add(predicted, captured)

    def draw(self, unit: str | None) -> None:
        """Draw what was gathered; `unit` is that of vertices."""
        from phonanim.evaluation.heat import draw_heat
        from phonanim.evaluation.motion_map import draw_motion

        if self.heat:
            draw_heat(*self.heat, f", {unit}" if unit else "")
        if self.motion:
            draw_motion(*self.motion, unit or "unit of the files")


def start_maps(heat: Path | None, motion: Path | None) -> Maps:
    """Empty maps. Raises MissingExtraError without Matplotlib."""
    from phonanim.evaluation.heat import Heat, check_drawable
    from phonanim.evaluation.motion_map import MotionMap

    for option, path in (("--heat", heat), ("--motion-map", motion)):
        if path:
            check_drawable(option)
    return Maps((Heat(), heat) if heat else None, (MotionMap(), motion) if motion else None)
