"""What outputs were made from, and whether that is still so."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from phonanim import __version__
from phonanim.animate import model_hash
from phonanim.dubbing.ledger import Outcome
from phonanim.dubbing.lines import Line
from phonanim.files import content_hash
from phonanim.overlay import hashes
from phonanim.rig.read import find_rig, read_document

RIG_FILES = ("direct", "table", "head", "landmarks", "accents")  # the keys of a rig that name files beside it


def origin_of(line: Line, formats: tuple[str, ...]) -> dict[str, Any]:
    """Everything that the outputs depend on: contents, options, model, rig, version, names."""
    return {
        "alignment": [line.alignment.name, content_hash(line.alignment)],
        "text": line.text,
        "audio": [line.audio.name, content_hash(line.audio)] if line.audio else None,
        "options": line.options.plain(),
        "overlays": hashes(line.options.overlays),
        "lexicon": content_hash(Path(line.options.lexicon)) if line.options.lexicon else None,
        "model": model_hash(line.options.model),
        "rig": rig_hash(line.options.rig),
        "version": __version__,
        "outputs": [f"{line.output}.{suffix}" for suffix in formats],
    }


def is_current(known: Outcome, origin: Mapping[str, Any], folder: Path) -> bool:
    """Whether the outputs in the ledger were made from the same things and are there unchanged."""
    if not known.done or known.origin != origin:
        return False
    files = {folder / name: digest for name, digest in known.outputs.items()}
    return all(path.is_file() and content_hash(path) == digest for path, digest in files.items())


@cache
def rig_hash(name: str) -> str:
    """A hash of a rig: its TOML, the files that it names, and the rig that it goes through."""
    path = find_rig(name)
    document = read_document(path)
    files = [path, *(path.parent / document[key] for key in RIG_FILES if key in document)]
    hashes = [content_hash(file) for file in files]
    if "through" in document:
        hashes.append(rig_hash(document["through"]))
    return hashlib.sha256(" ".join(hashes).encode()).hexdigest()
