"""Write rig files: TOML that an artist can read and edit."""

from __future__ import annotations

import json
import os
from pathlib import Path

from phonanim.core.files import write_text
from phonanim.rig.measures import write_measures
from phonanim.rig.rig import MEAN, POSES, Array, Rig
from phonanim.rig.tables import write_hinges

MODEST = 0.005  # of a control: a pose omits controls that move less


def write_rig(path: Path, rig: Rig) -> None:
    """Write a rig's TOML, and the tables of its maps beside it; each file atomically."""
    direct, mouth = path.with_suffix(".direct.csv"), path.with_suffix(".mouth.csv")
    if rig.direct is not None:
        write_hinges(direct, rig.direct, rig.controls)
    if rig.mouth is not None:
        write_measures(mouth, rig.mouth)
    write_text(
        path, rig_text(rig, path.parent, direct.name if rig.direct else "", mouth.name if rig.mouth else "")
    )


def rig_text(rig: Rig, folder: Path, direct: str = "", mouth: str = "") -> str:
    """The TOML of a rig in `folder`, with a description of each pose.

    `direct` and `mouth` name the tables of its maps.
    """
    head = {
        "name": rig.name,
        "title": rig.title,
        "source": rig.source,
        "face": rig.face,
        "head": _beside(rig.head, folder),
        "landmarks": _beside(rig.landmarks, folder),
        "mouth": mouth,
        "accents": _beside(rig.accents, folder),
        "tongue": _beside(rig.tongue, folder),
        "direct": direct,
    }
    lines = [f"{key} = {_quoted(text)}" for key, text in head.items() if text]
    lines += ["articulated = true"] * rig.articulated
    if rig.speech and rig.speech != rig.controls:
        lines += ["speech = [", *(f"  {_quoted(name)}," for name in rig.speech), "]"]
    lines += ["", "[controls]  # name = [minimum, rest, maximum]"]
    for name, *limits in zip(rig.controls, rig.minimum, rig.rest, rig.maximum, strict=True):
        lines.append(f"{toml_key(name)} = [{', '.join(map(_number, limits))}]")
    if rig.at_most:
        lines += ["", "[at_most]  # the first control never above the second"]
        lines += [f"{toml_key(rig.controls[a])} = {_quoted(rig.controls[b])}" for a, b in rig.at_most]
    if rig.posed:
        lines += _pose_lines(rig, MEAN, "the reference face at its mean", rig.mean)
        for (pose, looks), values in zip(POSES.items(), rig.poses, strict=True):
            lines += _pose_lines(rig, pose, looks, values)
    return "\n".join(lines) + "\n"


def _beside(path: Path | None, folder: Path) -> str:
    """A path relative to a folder."""
    return "" if path is None else Path(os.path.relpath(path, folder)).as_posix()


def _pose_lines(rig: Rig, pose: str, looks: str, values: Array) -> list[str]:
    moved = [
        f"{toml_key(name)} = {_number(value)}"
        for name, value, rest in zip(rig.controls, values, rig.rest, strict=True)
        if abs(value - rest) >= MODEST
    ]
    return ["", f"[poses.{pose}]  # {looks}", *moved]


def _quoted(text: str) -> str:
    """A TOML basic string: JSON's escapes are TOML's."""
    return json.dumps(text, ensure_ascii=False)


def toml_key(name: str) -> str:
    """A control's name as a TOML key, quoted where necessary."""
    bare = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if bare else _quoted(name)


def _number(value: float) -> str:
    """Three digits, always with a point."""
    return repr(round(float(value), 3))
