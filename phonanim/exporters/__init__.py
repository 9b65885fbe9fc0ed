"""Output files: one module per suffix, named after it with `_` for the dots within (`metahuman_csv`).

Each module is an `Exporter`. A name that begins with `_` is a helper.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.core.plugins import Registry
from phonanim.errors import OutputError

EXPORTERS = Registry("phonanim.exporters", needs=("SUMMARY", "write"))


class Exporter(Protocol):
    """What a module of this folder, or a plugin of the group `phonanim.exporters`, offers.

    The parameters of `write` after the first two are the options of the format. A format that can be read
    back also has `read(path) -> Animation`. A format of one rig's controls alone has that rig's name as `RIG`
    and `fits(channels) -> bool`, whether it can hold any of these channels.
    """

    SUMMARY: str  # one line of description

    def write(self, animation: Animation, path: Path) -> None:
        """Write a file atomically. Raises OutputError when that fails."""


def suffixes() -> tuple[str, ...]:
    """Every suffix that can be written, sorted."""
    return tuple(sorted(map(_suffix, EXPORTERS.names())))


def readable_suffixes() -> tuple[str, ...]:
    """The suffixes of formats that can be read back."""
    return tuple(suffix for suffix in suffixes() if hasattr(_exporter(suffix), "read"))


def find_exporter(path: Path) -> Exporter:
    """The exporter for the longest suffix that a name ends with; a built-in one comes first.

    Raises OutputError when no suffix matches, PluginError when a plugin cannot be used.
    """
    name = path.name.lower()
    for names in (EXPORTERS.built_in, EXPORTERS.plugins):
        known = [suffix for suffix in map(_suffix, names()) if name.endswith(suffix) and name != suffix]
        if known:
            return _exporter(max(known, key=len))
    raise OutputError(f"{path}: no format has this suffix; end the name with one of {' '.join(suffixes())}")


def option_names(path: Path) -> tuple[str, ...]:
    """The names of the options of a path's format, such as `keys` or `character`."""
    return _option_names(find_exporter(path).write)


@cache
def _option_names(write: Callable[..., None]) -> tuple[str, ...]:
    return tuple(signature(write).parameters)[2:]


def needed_rig(path: Path, channels: Sequence[str], has_character: bool = False) -> str:
    """The rig that a path's format needs in place of one with these channels; empty where they will do.

    With a character of the user's own, a format that takes one needs no other rig.
    """
    exporter = find_exporter(path)
    rig: str = getattr(exporter, "RIG", "")
    if not rig or (has_character and "character" in option_names(path)):
        return ""
    fits: Callable[[Sequence[str]], bool] = getattr(exporter, "fits", lambda names: True)
    return "" if fits(channels) else rig


def assign_options(
    options: Mapping[str, Any], paths: Sequence[Path]
) -> tuple[list[dict[str, Any]], list[str]]:
    """For each path the options that its format has, and the names of options that no format has."""
    known = [option_names(path) for path in paths]
    given = [{name: value for name, value in options.items() if name in names} for names in known]
    return given, [name for name in options if not any(name in names for names in known)]


def formats() -> dict[str, str]:
    """The description of each suffix, one line each."""
    return {suffix: _exporter(suffix).SUMMARY for suffix in suffixes()}


def save(animation: Animation, path: str | Path, **options: object) -> None:
    """Write an animation in the format of the path's suffix.

    Args:
        animation: The curves to write.
        path: The file; its suffix chooses the format. docs/output.md lists the formats and their options.
        options: Options of the format, such as `timecode` of .csv.

    Raises:
        OutputError: The format or an option is unknown, the file cannot be written, or the animation has
            no frames or values that are not finite.

    Examples:
        >>> import phonanim
        >>> animation = phonanim.animate("line.TextGrid")
        >>> phonanim.save(animation, "line.csv", timecode="01:00:00:00")
    """
    path = Path(path)
    exporter = find_exporter(path)
    _check(animation, path)
    unknown = sorted(set(options) - set(option_names(path)))
    if unknown:
        taken = ", ".join(option_names(path)) or "none"
        raise OutputError(f"{path}: this format has no option {unknown[0]}; those it has: {taken}")
    write: Callable[..., None] = exporter.write
    write(animation, path, **options)


def load(path: Path) -> Animation:
    """Read an animation from a file.

    Raises OutputError when its format cannot be read back or it has values that are not finite.
    """
    exporter = find_exporter(path)
    read: Callable[[Path], Animation] | None = getattr(exporter, "read", None)
    if read is None:
        known = " ".join(readable_suffixes())
        raise OutputError(f"{path}: this format can only be written; readable formats: {known}")
    animation = read(path)
    _check_finite(animation, path)
    return animation


def _suffix(name: str) -> str:
    return "." + name.replace("_", ".")


def _exporter(suffix: str) -> Exporter:
    return cast("Exporter", EXPORTERS.find(suffix[1:].replace(".", "_")))


def _check(animation: Animation, path: Path) -> None:
    values = np.asarray(animation.values)
    if values.size == 0:
        raise OutputError(f"{path}: the animation has no frames or no channels, so there is nothing to write")
    _check_finite(animation, path)


def _check_finite(animation: Animation, path: Path) -> None:
    values = np.asarray(animation.values)
    if not np.isfinite(values).all():
        frame, channel = np.argwhere(~np.isfinite(values))[0]
        name, time = animation.channels[channel], animation.times[frame]
        raise OutputError(f"{path}: {name} is not a finite number at {time:.3f} s; correct the curve first")
