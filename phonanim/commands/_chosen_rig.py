"""The rig of an animation where none is named: that of the character, or of the format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from phonanim.commands import Console

if TYPE_CHECKING:
    from phonanim.options import Options


def with_own_rig(options: Options, character: Any, console: Console) -> Options:
    """The options with the rig whose names a character has, unless one was chosen. Raises RigError."""
    from phonanim.rig.coverage import choose_rig

    if click.get_current_context().get_parameter_source("rig") is not ParameterSource.DEFAULT:
        return options
    rig, share = choose_rig(character)
    if rig == options.rig:
        return options
    console.print(
        f"{character}: has shapes for {share} of the rig {rig}, so it is used; --rig chooses another"
    )
    return replace(options, rig=rig)


def with_rig_of_format(options: Options, outputs: Sequence[Path], console: Console) -> Options:
    """The options with the one rig that every output's format needs, unless one was chosen."""
    from phonanim.exporters import needed_rig
    from phonanim.pipeline import load_cached_rig

    if click.get_current_context().get_parameter_source("rig") is not ParameterSource.DEFAULT:
        return options
    controls = load_cached_rig(options.rig).controls
    needed = {needed_rig(path, controls) for path in outputs}
    if len(needed) != 1 or needed == {""}:
        return options
    rig = needed.pop()
    console.print(f"{outputs[0]}: its format is of the rig {rig}, so it is used")
    return replace(options, rig=rig)
