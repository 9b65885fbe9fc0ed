"""Local copies of files on shared storage while a line is made, so that readers and writers get paths."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, lru_cache
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any

from phonanim.dubbing.job import Job
from phonanim.dubbing.line import Line
from phonanim.dubbing.provenance import overlay_place
from phonanim.dubbing.storage import Place, Remote, is_url, parse_place
from phonanim.options import Options

Fetch = Callable[[Place], Path]


class Copies:
    """The copies in one folder; `restore_urls` replaces their paths by URLs in messages."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.origins: dict[Remote, Path] = {}

    def fetch(self, source: Place) -> Path:
        """The copy of a remote file under its own name, or the path itself. Raises OptionError."""
        if isinstance(source, Path):
            return source
        if source not in self.origins:
            folder = self.folder / str(len(self.origins))
            folder.mkdir()
            (folder / source.name).write_bytes(source.read_bytes())
            self.origins[source] = folder / source.name
        return self.origins[source]

    def restore_urls(self, text: str) -> str:
        """The text with URLs instead of the paths of their copies."""
        for source, copy in self.origins.items():
            text = text.replace(str(copy), str(source))
        return text


@contextmanager
def open_copies(job: Job) -> Iterator[Copies]:
    """A temporary folder for copies; None if all files are local."""
    if not (isinstance(job.folder, Remote) or any(isinstance(file, Remote) for file in _files(job.line))):
        yield Copies(Path())
        return
    with tempfile.TemporaryDirectory(prefix="phonanim-") as folder:
        yield Copies(Path(folder))


def stage_inputs(job: Job, near: Copies) -> Job:
    """The job with local paths only, and a local folder for its outputs. Raises OptionError."""
    line = job.line
    local = replace(
        line,
        alignment=near.fetch(line.alignment) if line.alignment else None,
        audio=near.fetch(line.audio) if line.audio else None,
        edits=near.fetch(line.edits) if line.edits else None,
        corrections=near.fetch(line.corrections) if line.corrections else None,
        options=_options(line.options),
        exports={name: _export(value) for name, value in line.exports.items()},
    )
    folder = near.folder / "outputs" if isinstance(job.folder, Remote) else job.folder
    return replace(job, line=local, folder=folder)


def upload_outputs(names: list[str], folder: Path, target: Place) -> None:
    """Copy outputs to their target, if it is on shared storage. Raises OutputError."""
    if isinstance(target, Remote):
        for name in names:
            (target / name).write_bytes((folder / name).read_bytes())


def forget_copies() -> None:
    """Forget the copies of shared files, so that they are downloaded again."""
    _kept.cache_clear()
    if _shelf.cache_info().currsize:
        _remove(str(_shelf().folder))
        _shelf.cache_clear()


def _files(line: Line) -> list[Any]:
    return [line.alignment, line.audio, line.edits, line.corrections]


def _options(options: Options) -> Options:
    lexicon = str(_kept(parse_place(options.lexicon))) if options.lexicon else None
    overlays = (
        replace(one, source=str(_kept(overlay_place(one)))) if is_url(one.source) else one
        for one in options.overlays
    )
    return replace(options, lexicon=lexicon, overlays=tuple(overlays))


def _export(value: Any) -> Any:
    return _kept(value) if isinstance(value, Place) else value


@lru_cache(maxsize=1024)
def _kept(source: Place) -> Path:
    """The copy of a file that many lines use; each worker downloads it once per run."""
    return _shelf().fetch(source)


@cache
def _shelf() -> Copies:
    folder = tempfile.mkdtemp(prefix="phonanim-")
    # Workers end without running atexit handlers, but multiprocessing runs its own finalizers.
    Finalize(None, _remove, (folder,), exitpriority=0)
    return Copies(Path(folder))


def _remove(folder: str) -> None:
    import shutil

    shutil.rmtree(folder, ignore_errors=True)
