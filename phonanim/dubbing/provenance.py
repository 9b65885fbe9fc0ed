"""The origin of outputs, and whether they are still current."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from phonanim.aligners.espeak import speaker_version
from phonanim.animation.overlay import find_overlay
from phonanim.animation.provenance import model_hash
from phonanim.core.files import content_hash
from phonanim.core.lexicon import LEXICON, find_tables
from phonanim.core.plugins import plugin_packages
from phonanim.core.same import Same
from phonanim.core.version import __version__
from phonanim.dubbing.format_rigs import rigs_of_formats
from phonanim.dubbing.line import Line
from phonanim.dubbing.outcome import Outcome
from phonanim.dubbing.stamps import INPUTS, OUTPUTS, Stamp, stamp_file
from phonanim.dubbing.storage import Place, Remote, is_url, parse_place, place_hash
from phonanim.errors import OptionError, PhonanimError, RigError
from phonanim.options import Options, Overlay
from phonanim.rig.read import FILES, find_rig, read_document


def origin_of(line: Line, formats: tuple[str, ...], known: Outcome | None = None) -> dict[str, Any]:
    """Everything that the outputs depend on: contents, options, model, rig, version, names.

    It is the same for a file and its copy under the same name, and has the values that are read back from
    the ledger. Inputs are not read where `known` is given, the outcome that has their stamps.
    """
    origin = {
        **{
            name: _known_entry(line, name, known) if known else file_entry(getattr(line, name))
            for name in INPUTS
            if name != "corrections" or line.corrections
        },
        "text": line.text,
        "exports": {name: _export(value) for name, value in sorted(line.exports.items())},
        "options": options_entry(Same(line.options)),
        "model": model_hash(line.options.model),
        "rig": rig_hash(line.options.rig),
        "version": __version__,
        "outputs": [f"{line.output}.{suffix}" for suffix in formats],
    }
    origin |= find_extensions() | _other_rigs(line, formats) | speaker_of(line)
    return origin | ({"names": [line.names.name, line.names.digest]} if line.names else {})


def _other_rigs(line: Line, formats: tuple[str, ...]) -> dict[str, Any]:
    """The hashes of rigs that formats need besides that of the line, where there are any."""
    others = sorted(set(rigs_of_formats(line, formats).values()) - {line.options.rig})
    return {"rigs": {name: rig_hash(name) for name in others}} if others else {}


def speaker_of(line: Line) -> dict[str, Any]:
    """The voice of a line that is given as text, and the version of what speaks, where there is none else."""
    named = {"voice": line.voice} if line.voice else {}
    return named | ({"speaker": speaker_version()} if line.is_spoken else {})


@cache
def find_extensions() -> dict[str, Any]:
    """Other things that may affect any line: packages with plugins, languages on PHONANIM_PATH."""
    tables = find_tables("languages").values()
    found = {
        "plugins": list(plugin_packages()),
        "languages": [shared_file_entry(path.absolute()) for path in tables if LEXICON not in path.parents],
    }
    return {name: values for name, values in found.items() if values}


def is_current(known: Outcome, origin: Mapping[str, Any], folder: Place) -> bool:
    """Whether the outputs in the ledger have this origin and exist unchanged."""
    if not known.done or known.origin != origin:
        return False
    return all(output_hash(name, folder) == digest for name, digest in known.outputs.items())


def is_unchanged(known: Outcome | None, line: Line, formats: tuple[str, ...], folder: Place) -> bool:
    """Whether the outputs are current, by the stamps of all files, so that none but shared ones are read."""
    if known is None or not known.done or not keeps_stamps(known, line, folder):
        return False
    try:
        return bool(known.origin == origin_of(line, formats, known))
    except (PhonanimError, OSError):  # told by the worker that makes the line
        return False


def keeps_stamps(known: Outcome, line: Line, folder: Place) -> bool:
    """Whether every file of a line has the size and time that the ledger has."""
    inputs = {name: place for name in INPUTS if (place := getattr(line, name)) is not None}
    stamps = known.stamps.get(OUTPUTS, {})
    return all(_is_stamped(place, known.stamps.get(name)) for name, place in inputs.items()) and all(
        _is_stamped(folder / name, stamps.get(name)) for name in known.outputs
    )


def output_hash(name: str, folder: Place, known: Outcome | None = None) -> str:
    """The content hash of an output; empty when it does not exist. It is not read if `known` has its
    stamp.
    """
    path = folder / name
    if known is not None and _is_stamped(path, known.stamps.get(OUTPUTS, {}).get(name)):
        return known.outputs[name]
    try:
        return place_hash(path) if isinstance(path, Remote) or path.is_file() else ""
    except OptionError:  # avoids a second request for the same file
        return ""


def input_entry(line: Line, name: str, known: Outcome | None = None) -> list[str] | None:
    """`file_entry` of a file of a line, by its name in the origin; not read if `known` has its stamp."""
    path: Place | None = getattr(line, name)
    if known is not None and path is not None and _is_stamped(path, known.stamps.get(name)):
        return _known_entry(line, name, known)
    return file_entry(path)


def _known_entry(line: Line, name: str, known: Outcome) -> list[str] | None:
    """The same from an outcome that has the stamp of the file, unless it is of a file of another name."""
    path: Place | None = getattr(line, name)
    entry = known.origin.get(name)
    if path is not None and isinstance(entry, list) and entry[:1] == [path.name]:
        return entry
    return file_entry(path)


def _is_stamped(path: Place, stamp: Stamp | None) -> bool:
    return stamp is not None and stamp_file(path) == stamp


def file_entry(path: Place | None) -> list[str] | None:
    """The name and the content hash of a file of one line."""
    return [path.name, place_hash(path)] if path else None


@lru_cache(maxsize=1024)
def shared_file_entry(path: Place) -> list[str]:
    """The same for a file that many lines use, such as a character."""
    return [path.name, place_hash(path)]


@cache
def rig_hash(name: str) -> str:
    """A hash of a rig: its TOML, the files that it names, and its base rig."""
    hashes: list[str] = []
    seen: list[Path] = []
    while name:
        path = find_rig(name)
        if path in seen:
            raise RigError(f"{path}: goes through itself; name another rig")
        seen.append(path)
        document = read_document(path)
        named = [document[key] for key in (*FILES, "table") if isinstance(document.get(key), str)]
        files = [path, *(path.parent / file for file in named)]
        hashes += [content_hash(file) for file in files if file.is_file()]
        name = str(document.get("through", ""))
    return hashlib.sha256(" ".join(hashes).encode()).hexdigest()


def overlay_place(overlay: Overlay) -> Place:
    """The place of the file of an overlay. Raises OptionError when it does not exist."""
    return parse_place(overlay.source) if is_url(overlay.source) else find_overlay(overlay.source)


@lru_cache(maxsize=256)
def options_entry(same: Same[Options]) -> dict[str, Any]:
    """The options, with names and hashes of files instead of paths; lines share them."""
    options = same.value
    lexicon = shared_file_entry(parse_place(options.lexicon).absolute()) if options.lexicon else None
    overlays = [
        [*shared_file_entry(overlay_place(overlay).absolute()), overlay.gain, _as_list(overlay.span)]
        for overlay in options.overlays
    ]
    found = {"rig": options.rig, "model": options.model}  # so that an audit can find them
    return {**options.plain(), **found, "lexicon": lexicon, "overlays": overlays}


def _as_list(span: tuple[float, float] | None) -> list[float] | None:
    return None if span is None else list(span)


def _export(value: Any) -> Any:
    if isinstance(value, Place):
        return shared_file_entry(value.absolute())
    return list(value) if isinstance(value, tuple) else value
