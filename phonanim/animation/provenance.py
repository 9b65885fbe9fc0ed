"""Where a take comes from: its input, its model, its options, and the language that was read."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from phonanim.animation.overlay import hash_overlays
from phonanim.core.catalog import find_model
from phonanim.core.files import content_hash
from phonanim.core.version import __version__
from phonanim.inputs.speech_input import SpeechInput
from phonanim.options import Options


@lru_cache(maxsize=8)
def model_hash(name: str) -> str:
    """A hash of all files in a model's folder."""
    return content_hash(find_model(name))


def take_provenance(
    path: Path, options: Options, notes: tuple[str, ...], line: SpeechInput
) -> dict[str, Any]:
    """What made a take, as JSON values; `path` is the alignment or the recording of the `line`."""
    return {
        "tool": f"phonanim {__version__}",
        "input": path.name,
        "input_sha256": content_hash(path),
        "model_sha256": model_hash(options.model),
        "options": options.plain(),
        "overlays_sha256": hash_overlays(options.overlays),
        **({"features_sha256": content_hash(Path(options.features))} if options.features else {}),
        "notes": list(notes),
        **_known(line),
    }


def _known(line: SpeechInput) -> dict[str, Any]:
    """The language that the labels were read as, and the hash of a recording that moved the face."""
    moved = line.sound is not None or line.voice is not None
    recorded = {"audio_sha256": content_hash(line.audio)} if moved and line.audio else {}
    return ({"language": line.language.facts()} if line.language else {}) | recorded
