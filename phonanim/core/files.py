"""Files: atomic writing, bounded reading and content hashes."""

from __future__ import annotations

import errno
import hashlib
import logging
import os
import re
import secrets
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import OutputError

PIECE = 1 << 20  # bytes that are read at once of a file that grows
LARGE = 1 << 26  # bytes of arrays that are held in memory
PARTIAL = ".partial"  # every unfinished file is named ".<process><random>.partial<suffix>"
PARTIAL_NAME = re.compile(r"\.([0-9a-f]{6,})[0-9a-f]{6}\.partial(\.[^/]*)?")
DEVICES = (("/", "dev"), ("/", "proc"))  # the links in these folders are the system's
LOG = logging.getLogger("phonanim")


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """A temporary path next to `path`; it replaces `path` when the block ends without an error.

    A link is replaced, not followed. The suffix is kept, because some writers choose the format by it. When
    the block fails, the old file stays. Raises OutputError when the destination cannot be written.
    """
    target = _writable(path)
    name = f".{os.getpid():06x}{secrets.token_hex(3)}{PARTIAL}{target.suffix}"
    partial = target.with_name(name)
    try:
        yield partial
        if target.is_symlink():
            LOG.warning("%s: was a link; it is a plain file now, and the file behind it is unchanged", path)
        partial.replace(target)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        partial.unlink(missing_ok=True)


def make_folder_within(place: Path, folder: Path) -> Path:
    """Make a folder within another, and return it; nothing is made where a link on the way leads elsewhere.

    Raises OutputError.
    """
    try:
        if place != folder and not place.resolve().is_relative_to(folder.resolve()):
            raise OutputError(f"{place}: a link points outside the output folder; remove the link")
        place.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError) as error:  # RuntimeError: links that lead to themselves
        raise OutputError(
            f"{place}: cannot be created ({getattr(error, 'strerror', '') or error}); name another folder"
        ) from error
    return place


def is_leftover(path: Path) -> bool:
    """Whether a plain file is an unfinished one of ours, of a process that has ended."""
    match = PARTIAL_NAME.fullmatch(path.name)
    if not match or path.is_symlink() or not path.is_file():
        return False
    if os.name != "posix":  # where the question would end the process
        return True
    try:
        os.kill(int(match[1], 16), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:  # it runs, and is another user's
        return False
    return False


def read_bounded(path: Path, most: int) -> bytes:
    """The content of a plain file of at most `most` bytes.

    The limit is checked while reading, because a file may grow and some files report no size. Raises
    ValueError for more bytes and for a pipe or a device, which may never end; raises OSError.
    """
    with open_plain(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        pieces = [stream.read(min(size, most) + 1)]  # as much as is asked for is set aside
        left = most - len(pieces[0])
        while left >= 0 and (more := stream.read(PIECE)):
            pieces.append(more)
            left -= len(more)
    if left < 0:
        raise ValueError(f"it has more than {most >> 20} MB")
    return b"".join(pieces)


def open_plain(path: Path) -> BinaryIO:
    """Open a plain file to read. Raises ValueError for a pipe or a device, without a wait; raises OSError."""
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    kind = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(kind):
        os.close(descriptor)
        if stat.S_ISDIR(kind):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        raise ValueError("it is a pipe or a device; save its content to a plain file")
    return os.fdopen(descriptor, "rb")


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with Unix line ends, atomically. Raises OutputError."""
    write_pieces(path, [text])


def write_pieces(path: Path, pieces: Iterable[str]) -> None:
    """Write text piece by piece, so that it is never in memory as a whole, as `write_text` does."""
    with atomic_path(path) as partial, partial.open("wb") as file:
        try:
            for piece in pieces:
                file.write(piece.encode("utf-8"))
        except UnicodeEncodeError as error:
            raise OutputError(
                f"{path}: would hold a name that is not UTF-8; rename the file that has it"
            ) from error


def concatenate_pieces(pieces: Iterable[NDArray[Any]]) -> NDArray[Any]:
    """Join arrays (at least one) along their first axis; above LARGE bytes the result is in an unnamed file.

    The file is removed with the array. Raises OutputError when there is no room for it.
    """
    size = 0
    try:
        with tempfile.SpooledTemporaryFile(LARGE) as file:
            for piece in pieces:
                size += file.write(piece.tobytes())
            shape = (-1, *piece.shape[1:])
            if size > LARGE:
                return np.memmap(file, piece.dtype, "r+").reshape(shape)
            file.seek(0)
            return np.frombuffer(bytearray(file.read()), piece.dtype).reshape(shape)
    except OSError as error:
        place = f"{tempfile.gettempdir()}: has no room for {size / 1e6:.0f} MB or more ({error.strerror})"
        raise OutputError(f"{place}; set TMPDIR to a larger folder") from error


def content_hash(path: Path) -> str:
    """SHA-256 of a file, or of every file in a folder with its relative path, as 64 hex digits."""
    if not path.is_dir():
        return _file_hash(path)
    lines = [
        f"{part.relative_to(path).as_posix()} {_file_hash(part)}\n"
        for part in sorted(path.rglob("*"))
        if part.is_file()
    ]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _file_hash(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def _writable(path: Path) -> Path:
    """The place of `path` in its real folder, once it is certain that a plain file can be written there."""
    target = Path(os.path.realpath(path.parent)) / path.name
    if target.is_dir():
        raise OutputError(f"{path}: is a folder; name a file in it")
    system = target.is_symlink() and target.parts[:2] in DEVICES
    if system or (target.exists() and not target.is_file()):
        raise OutputError(f"{path}: is not a plain file; name another")
    if not target.parent.is_dir():
        raise OutputError(f"{path}: the folder {target.parent} does not exist; create it first")
    return target
