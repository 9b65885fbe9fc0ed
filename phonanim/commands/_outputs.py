"""Write the files of an animation, and report what was read, made and written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from phonanim.commands import Console
from phonanim.commands._export import save_outputs

if TYPE_CHECKING:
    from phonanim.animation.animation import Animation
    from phonanim.options import Options

OUTPUT = click.Path(dir_okay=False, path_type=Path)


def check_outputs(outputs: Sequence[Path], inputs: Sequence[Path]) -> None:
    """Raise OptionError when two outputs are the same file or an output would overwrite an input."""
    from phonanim.errors import OptionError

    taken = {path.resolve() for path in inputs}
    for path in outputs:
        if path.resolve() in taken:
            raise OptionError(f"{path}: is named twice, as input or output; give every file its own name")
        taken.add(path.resolve())


def write_outputs(
    animation: Animation, outputs: Sequence[Path], sheet: Path | None, exports: dict[str, object]
) -> list[Path]:
    """Check that every format is known, write every output, and return the paths."""
    from phonanim.exporters import find_exporter

    for path in outputs:
        find_exporter(path)
    if sheet:
        from phonanim.viewer.sheet import save_sheet

        save_sheet(animation, sheet, shown_character(exports))
    save_outputs(animation, outputs, exports, pictured=sheet is not None)
    return [*outputs, *filter(None, [sheet])]


def shown_character(exports: dict[str, object]) -> Path | None:
    """The character that pictures show, of the options of formats."""
    character = exports.get("character")
    return character if isinstance(character, Path) else None


def show(animation: Animation, outputs: Sequence[Path], console: Console) -> None:
    """Open the animation in the browser: the page among the outputs, or a temporary one."""
    import tempfile

    from phonanim.commands._view import open_page

    pages = [path for path in outputs if path.suffix.lower() in (".html", ".htm")]
    if not pages:
        folder = Path(tempfile.mkdtemp(prefix="phonanim-view-"))
        pages = [folder / f"{outputs[0].stem}.html"]
        animation.save(pages[0])
    open_page(pages[0], console)


def describe(animation: Animation, alignment: Path, options: Options, written: list[Path]) -> dict[str, Any]:
    """The result as data, for scripts."""
    from phonanim.speech.labels import is_silent

    frames, channels = animation.values.shape
    return {
        "alignment": str(alignment),
        "audio": str(animation.audio) if animation.audio else None,
        "phones": sum(not is_silent(phone.label) for phone in animation.phones),
        "frames": frames,
        "fps": animation.fps,
        "seconds": round((frames - 1) / animation.fps, 6),
        "channels": channels,
        "rig": animation.rig,
        "model": options.model,
        "language": animation.provenance.get("language"),
        "notes": animation.provenance["notes"],
        "outputs": [{"path": str(path), "bytes": path.stat().st_size} for path in written],
    }


def report_lines(facts: dict[str, Any]) -> list[str]:
    """The same as text: what was read, made and written, and which labels were replaced."""
    sound = f" with {facts['audio']}" if facts["audio"] not in (None, facts["alignment"]) else ""
    files = ", ".join(f"{output['path']} ({format_size(output['bytes'])})" for output in facts["outputs"])
    spoken = facts["language"]
    return [
        f"read {facts['alignment']}: {facts['phones']} phones in {facts['seconds']:.2f} s{sound}",
        *([describe_language(spoken)] if spoken else []),
        f"moved {facts['rig']} by {facts['model']}: {facts['frames']} frames at {facts['fps']:g} fps, "
        f"{facts['channels']} channels",
        f"wrote {files}",
        *facts["notes"],
    ]


def describe_language(facts: Mapping[str, Any]) -> str:
    """The language of the provenance in a line."""
    from phonanim.speech.reading import describe_language

    return describe_language(facts)


def format_size(count: int) -> str:
    """A number of bytes as text, in kB or MB."""
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.1f} kB"
