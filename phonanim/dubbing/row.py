"""Convert a row of a table to a line: absolute paths, and cells that override the options of the run."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from phonanim.animation.option_parsing import (
    parse_closures,
    parse_gain,
    parse_gains,
    parse_overlay,
    parse_smoothing,
)
from phonanim.animation.overlay import is_pose
from phonanim.animation.rates import parse_rate
from phonanim.articulation.styles import DIALS, ChosenStyle, Styles, choose_style, parse_dial, read_styles
from phonanim.core.catalog import CARD
from phonanim.dubbing.characters import Characters
from phonanim.dubbing.line import Line
from phonanim.dubbing.listing import first_listed
from phonanim.dubbing.output_names import safe_name
from phonanim.dubbing.pairing import spellings, without_suffix
from phonanim.dubbing.storage import Place, parse_place
from phonanim.dubbing.table import Row
from phonanim.errors import OptionError, RigError
from phonanim.inputs.level import parse_level
from phonanim.life.parsing import parse_emotions, parse_life, parse_look_at, parse_seed
from phonanim.media.audio import RECORDINGS, SUFFIXES
from phonanim.options import DEFAULTS, Options, Overlay
from phonanim.pipeline import model_with_settings
from phonanim.rig.names import NameTable
from phonanim.rig.read import find_rig
from phonanim.speech.clock import parse_offset, parse_unit

TEXTS = ("rig", "model", "language", "fallback", "tier", "speaker", "unknown", "unit")
CHARACTERS = (".glb", ".gltf", ".vrm")
EDITS = ".edits.json"
CORRECTIONS = ".corrections.json"
PITCHES = ("builtin", "praat")
UNKNOWN = ("error", "nearest", "silence")
SOUNDS = (*SUFFIXES, *map(str.upper, SUFFIXES))
# Columns with numbers, the option of each, and its parser.
PARSED: dict[str, tuple[str, Callable[[str], Any]]] = {
    "fps": ("fps", parse_rate),
    "offset": ("offset", parse_offset),
    "smooth": ("smooth", parse_smoothing),
    "loudness": ("loudness", lambda cell: parse_gain("loudness", cell)),
    "pitch": ("pitch", lambda cell: _pitch(cell)),
    "gain": ("gains", lambda cell: parse_gains(cell.split(";"))),
    "life": ("life", lambda cell: parse_life(cell.replace(";", ","))),
    "closure": ("closures", lambda cell: parse_closures(cell.split(";"))),
    "life_seed": ("life_seed", parse_seed),
    "look_at": ("look_at", lambda cell: parse_look_at(cell.replace(";", ","))),
}

OVERRIDES = {*TEXTS, *DIALS, *PARSED, "style", "character", "lexicon", "level", "emotion", "overlay"}
"""Columns with options."""


@dataclass(frozen=True, slots=True)
class Common:
    """Settings of all lines of a run, unless a row overrides them.

    `exports` are options of output formats; `edits` is a folder with an animator's changes to each line,
    `<output>.edits.json`; `corrections` one with `<output>.corrections.json`, usually the output folder,
    where a review leaves them, or else in the folder of edits;
    `styled` is the style of the run with the dials that it has set; `characters` are the names that a cell of
    `character` may have; `names` is a table of the names of shapes. `known` are the options of the rows so
    far, by their cells, and `remarks` what they leave to say, once each.
    """

    options: Options = DEFAULTS
    styles: Styles = field(default_factory=read_styles)
    exports: Mapping[str, Any] = field(default_factory=dict)
    edits: Place | None = None
    corrections: Place | None = None
    styled: ChosenStyle = field(default_factory=ChosenStyle)
    characters: Characters = field(default_factory=Characters)
    names: NameTable | None = None
    known: dict[tuple[object, ...], Options] = field(default_factory=dict, repr=False, compare=False)
    remarks: dict[str, None] = field(default_factory=dict, repr=False, compare=False)


def parse_row(id: str, row: Row, root: Place, common: Common, speaks: bool = True) -> Line:
    """The line of a row, whose paths are relative to `root`; `speaks` is whether text alone is spoken.

    Raises OptionError for invalid cells, RigError and ModelError for a rig and a style that are not there.
    """
    cells = _with_recording(common.characters.fill(row.cells))
    spoken = "alignment" not in cells
    if spoken and "audio" not in cells and not (speaks and "text" in cells):
        raise OptionError("the row names no alignment; fill its cell, or those of audio and text")
    output = safe_name(cells.get("output", id))
    source = cells.get("audio" if spoken else "alignment")
    alignment = None if source is None else _found(source, root)
    return Line(
        id=id,
        place=row.place,
        alignment=alignment,
        audio=_found(cells["audio"], root) if "audio" in cells else alignment and _beside(alignment),
        options=_options(cells, root, common),
        output=output,
        text=cells.get("text") if spoken else None,
        edits=_found(cells["edits"], root)
        if "edits" in cells
        else _sidecar(common.edits, f"{output}{EDITS}"),
        corrections=_sidecar(common.corrections, f"{output}{CORRECTIONS}")
        or _sidecar(common.edits, f"{output}{CORRECTIONS}"),
        exports={**common.exports, **_exports(cells, root)},
        voice=cells.get("voice", ""),
        names=common.names,
    )


def _with_recording(cells: dict[str, str]) -> dict[str, str]:
    """The cells; a voice that names a recording is one."""
    if not cells.get("voice", "").lower().endswith(RECORDINGS):
        return cells
    if "audio" in cells:
        raise OptionError(f"audio = {cells['audio']!r} and voice = {cells['voice']!r} both name a recording")
    return {**{name: cell for name, cell in cells.items() if name != "voice"}, "audio": cells["voice"]}


def _options(cells: Mapping[str, str], root: Place, common: Common) -> Options:
    """The options of the run with those of a row; rows with the same cells share them."""
    cells = {name: cell for name, cell in cells.items() if name in OVERRIDES}
    if not cells:
        return common.options
    key = (str(root), *sorted(cells.items()))
    if key not in common.known:
        common.known[key] = replace(common.options, **_overrides(cells, root, common))
    return common.known[key]


def is_character(cell: str) -> bool:
    """Whether a cell names a file to animate; otherwise it names a rig."""
    return cell.lower().endswith(CHARACTERS)


def resolve_files(root: Place, names: Mapping[str, Any]) -> dict[str, Any]:
    """The absolute paths of a rig and of a model that are below `root`; others are names."""
    if not isinstance(root, Path):
        return {}
    marks = {"rig": "", "model": CARD}
    paths = {name: root / names[name] for name in marks if name in names}
    return {name: str(path.absolute()) for name, path in paths.items() if (path / marks[name]).is_file()}


def _found(name: str, root: Place) -> Place:
    for spelling in spellings(name):
        if (path := parse_place(spelling, root).absolute()).is_file():
            return path
    raise OptionError(f"{parse_place(name, root).absolute()}: does not exist; correct the path")


def _local(name: str, root: Place) -> Path:
    path = _found(name, root)
    if not isinstance(path, Path):
        raise OptionError(f"level = {name!r}: is not on this machine; give it in dB of full scale")
    return path


def _beside(alignment: Place) -> Place | None:
    """The recording of the same stem, if there is one."""
    if isinstance(alignment, Path):
        return first_listed(without_suffix(str(alignment)), SOUNDS)
    candidates = (alignment.with_suffix(suffix) for suffix in SOUNDS)
    return next((path for path in candidates if path.is_file()), None)


def _sidecar(folder: Place | None, name: str) -> Place | None:
    if isinstance(folder, Path):
        return first_listed(f"{folder.absolute()}{os.sep}{name}", ("",))
    return folder / name if folder is not None and (folder / name).is_file() else None


def _exports(cells: Mapping[str, str], root: Place) -> dict[str, Any]:
    chosen: dict[str, Any] = {}
    if is_character(cells.get("character", "")):
        chosen["character"] = _found(cells["character"], root)
    if "timecode" in cells:
        chosen["timecode"] = cells["timecode"]
    return chosen


def _overrides(cells: Mapping[str, str], root: Place, common: Common) -> dict[str, Any]:
    """The options that the cells override; if several set the same option, the style has least priority."""
    chosen: dict[str, Any] = {}
    chosen |= {name: cells[name] for name in TEXTS if name in cells} | _rig(cells, common)
    chosen |= resolve_files(root, chosen)
    chosen |= _style(cells, chosen.get("model", common.options.model), common)
    if "rig" in chosen:
        _check_rig(chosen["rig"])
    if chosen.get("unknown", "error") not in UNKNOWN:
        raise OptionError(f"unknown = {chosen['unknown']!r}; choose error, nearest or silence")
    if "unit" in chosen:
        parse_unit(chosen["unit"])
    chosen |= {name: parse_dial(name, cells[name]) for name in DIALS if name in cells}
    chosen |= {field: parse(cells[name]) for name, (field, parse) in PARSED.items() if name in cells}
    if "lexicon" in cells:
        chosen["lexicon"] = str(_found(cells["lexicon"], root))
    if "level" in cells:
        chosen["level"] = parse_level(cells["level"], lambda cell: _local(cell, root))
    if "emotion" in cells:
        chosen["emotions"] = parse_emotions(_emotion(text, root) for text in cells["emotion"].split(";"))
    if "overlay" in cells:
        chosen["overlays"] = tuple(_overlay(text, root) for text in cells["overlay"].split(";"))
    return chosen


def _style(cells: Mapping[str, str], model: str, common: Common) -> dict[str, Any]:
    """The options of the style in a cell, or of the run's where it is learned and the row has another model.

    Raises OptionError for an unknown style, ModelError for one that the model does not have.
    """
    styled = common.styled
    other_model = styled.number is not None and model != common.options.model
    if "style" not in cells and not other_model:
        return {}
    found = choose_style(cells.get("style", styled.name), model, common.styles)
    if found.number is not None:
        model_with_settings(Options(model=model, model_style=found.number))
    if found.note:
        common.remarks.setdefault(f"style {found.name}: {found.note}")
    unstyled = {dial: getattr(DEFAULTS, dial) for dial in styled.dials}
    return {**unstyled, **found.dials, "model_style": found.number}


def _rig(cells: Mapping[str, str], common: Common) -> dict[str, str]:
    """The rig in a `character` cell."""
    name = cells.get("character", "")
    if not name or is_character(name):
        return {}
    if "rig" in cells:
        raise OptionError(f"character = {name!r} and rig = {cells['rig']!r} both name a rig; give one")
    if Path(name).suffix != ".toml":
        try:
            _check_rig(name)
        except RigError as error:
            mend = common.characters.suggest(name)
            raise OptionError(f"there is no character or rig {name!r}; {mend}") from error
    return {"rig": name}


@lru_cache(maxsize=64)
def _check_rig(name: str) -> None:
    """Raise RigError for a rig that is not there."""
    find_rig(name)


def _pitch(cell: str) -> str:
    if cell not in PITCHES:
        raise OptionError(f"pitch = {cell!r}; choose builtin or praat")
    return cell


def _emotion(text: str, root: Place) -> str:
    """An emotion; the path of its file of spans, if it names one, is relative to the table."""
    return str(_found(text.strip(), root)) if text.strip().lower().endswith(".csv") else text


def _overlay(text: str, root: Place) -> Overlay:
    """An overlay whose file is relative to the table, unless it is a pose of the package."""
    overlay = parse_overlay(text)
    if is_pose(overlay.source):
        return overlay
    return replace(overlay, source=str(_found(overlay.source, root)))
