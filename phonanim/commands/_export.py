"""The options of output formats, which `animate` and `convert` share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands._numbers import Number
from phonanim.commands._renamed import renamed_option
from phonanim.errors import OptionError

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation


def know_names(ctx: click.Context, param: click.Parameter, path: Path | None) -> Path | None:
    """Know the names of a table of one's own as long as the command runs; the path of the table."""
    if path is not None:
        from phonanim.rig.names import added_names

        ctx.with_resource(added_names(path))
    return path


FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
NAMES_HELP = "A table shape,control,weight of the character's own names of shapes."
NAMES = click.option(
    "--names", type=FILE, callback=know_names, expose_value=False, is_eager=True, help=NAMES_HELP
)
RUN_NAMES = click.option("--names", type=FILE, callback=know_names, is_eager=True, help=NAMES_HELP)
SHOWN = 8  # controls that a note lists
SHARED_KEYS = (".glb", ".gltf", ".vrm")

OPTIONS = {
    "character": click.option(
        "--character", type=FILE, help="Your own character (GLB, glTF or VRM), to animate or to show."
    ),
    "keys": renamed_option(
        "--key-tolerance",
        "--keys",
        metavar="ERROR",
        type=Number(0, 1e6),
        help="Reduce the curves to keys, within this error at every frame, such as 0.01.",
    ),
    "node": click.option(
        "--node", help="The mesh that a Unity or Godot animation moves (its path), or Maya's blendShape node."
    ),
    "timecode": click.option(
        "--timecode", help="Timecode of time zero in a .csv; 01:00:00;00 counts drop-frame."
    ),
}

SPELLINGS = {
    "keys": "--key-tolerance",
    "beside": "--compare-with",
}  # where they differ from the option's name


def option_spelling(name: str) -> str:
    """The command-line spelling of a format's option."""
    return SPELLINGS.get(name, f"--{name}")


def export_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Pass the format options that were given to a command, as `exports`."""

    @wraps(function)
    def wrapped(*args: Any, **kwargs: Any) -> Any:
        given = {name: kwargs.pop(name) for name in OPTIONS}
        return function(*args, exports={k: v for k, v in given.items() if v is not None}, **kwargs)

    for add in reversed(OPTIONS.values()):
        wrapped = add(wrapped)
    return wrapped


def save_outputs(
    animation: Animation,
    outputs: Sequence[Path],
    exports: dict[str, object],
    pictured: bool = False,
    takes: Mapping[Path, Animation] | None = None,
) -> None:
    """Write every output with the options that its format supports.

    A sheet is `pictured` with the character; `takes` has the animations of outputs that are on other rigs.

    Raises OptionError for an option that no output's format supports, and the exporters' errors.
    """
    from phonanim.exporters import assign_options, save

    options, idle = assign_options(exports, outputs)
    if idle and not (pictured and idle == ["character"]):
        raise OptionError(
            f"{option_spelling(idle[0])} does nothing for {', '.join(map(str, outputs))}; leave it out"
        )
    for path, given in zip(outputs, options, strict=True):
        save((takes or {}).get(path, animation), path, **given)


def output_notes(animation: Animation, outputs: Sequence[Path], exports: dict[str, object]) -> Iterator[str]:
    """What to know of an output's format; for one reduced to keys their number and largest error."""
    from phonanim.animation.keys import describe_keys, describe_shared_keys, reduce_channels, reduce_curves
    from phonanim.exporters import find_exporter, option_names

    for path in outputs:
        if note := getattr(find_exporter(path), "NOTE", None):
            yield f"{path}: {note}"
    yield from timecode_notes(animation, outputs, exports.get("timecode"))
    yield from turn_notes(animation, outputs, exports.get("character"))
    if isinstance(character := exports.get("character"), Path):
        from phonanim.rig.coverage import coverage_notes

        yield from coverage_notes(character, animation.rig, animation.channels)
        yield from character_notes(animation, outputs, character)
    error = exports.get("keys")
    if not isinstance(error, float):
        return
    for path in outputs:
        if path.suffix.lower() in SHARED_KEYS:
            yield f"{path}: {describe_shared_keys(reduce_curves(animation.values, error), animation)}"
        elif "keys" in option_names(path):
            yield f"{path}: {describe_keys(reduce_channels(animation, error), animation)}"


def timecode_notes(animation: Animation, outputs: Sequence[Path], timecode: object) -> Iterator[str]:
    """Which outputs have a timecode that Unreal's importer skips with all its rows."""
    from phonanim.exporters import option_names

    if ";" in str(timecode or animation.provenance.get("timecode", "")):
        for path in outputs:
            if "timecode" in option_names(path):
                yield f"{path}: Unreal's importer reads no drop-frame timecode; write colons for Unreal"


def turn_notes(animation: Animation, outputs: Sequence[Path], character: object) -> Iterator[str]:
    """Which outputs do not turn the head of a take in which it turns."""
    from phonanim.exporters import find_exporter
    from phonanim.rig.neck import turns_of

    if turns_of(animation.values, animation.channels) is None:
        return
    for path in outputs:
        exporter = find_exporter(path)
        alone = None if character else getattr(exporter, "NO_TURNS_ALONE", None)
        if note := getattr(exporter, "NO_TURNS", alone):
            yield f"{path}: {note}"


def character_notes(animation: Animation, outputs: Sequence[Path], character: Path) -> Iterator[str]:
    """What a character cannot show: controls without a VRM expression, turns of a head without a bone."""
    import numpy as np

    from phonanim.exporters.vrma import match_expressions
    from phonanim.media.glb import read_glb
    from phonanim.rig.neck import TURNS, find_bone, turns_of

    for path in (one for one in outputs if one.suffix.lower() == ".vrma"):
        found = match_expressions(animation.channels, path, character).values()
        moving = [
            name for name in animation.channels if name not in TURNS and np.ptp(animation.channel(name)) > 0
        ]
        if left := [name for name in moving if name not in found]:
            have = "has" if len(left) == 1 else "have"
            shown = ", ".join(left[:SHOWN]) + (f" and {len(left) - SHOWN} more" if len(left) > SHOWN else "")
            yield f"{path}: {len(left)} of {len(moving)} moving controls {have} no expression: {shown}"
    if turns_of(animation.values, animation.channels) is not None and find_bone(read_glb(character)) is None:
        yield f"{character}: has no bone called head, so the head does not turn"
