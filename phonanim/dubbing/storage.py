"""Shared storage: files by URL (s3://, gs://, http://, ...) through fsspec, next to files by path."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, TypeAlias
from urllib.parse import urlsplit
from urllib.request import url2pathname

from phonanim.core.files import content_hash, write_text
from phonanim.errors import MissingExtraError, OptionError, OutputError, PhonanimError

SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+(://|::)")  # at least two characters, because C: is a drive
HERE = ("file", "local")  # schemes of local files, which do not need fsspec


@dataclass(frozen=True, slots=True)
class Remote:
    """A file or a folder on shared storage: `url` opens the storage, `path` is the path in it.

    It has the parts of `pathlib.Path` that lines need. Errors of the storage are raised as OptionError, or as
    OutputError when writing, with the URL.
    """

    url: str
    path: str

    def __str__(self) -> str:
        return str(_storage(self.url).unstrip_protocol(self.path))

    def __truediv__(self, other: str | PurePosixPath) -> Remote:
        path = PurePosixPath(other)
        place = self
        for part in path.parts:
            place = place.parent if part == ".." else replace(place, path=f"{place.path.rstrip('/')}/{part}")
        return place

    @property
    def name(self) -> str:
        """The part after the last slash."""
        return self.path.rstrip("/").rpartition("/")[2]

    @property
    def stem(self) -> str:
        """The name without its suffix."""
        return PurePosixPath(self.name).stem

    @property
    def suffix(self) -> str:
        """The suffix with its dot."""
        return PurePosixPath(self.name).suffix

    @property
    def parent(self) -> Remote:
        """The folder above."""
        return replace(self, path=self.path.rstrip("/").rpartition("/")[0])

    def with_suffix(self, suffix: str) -> Remote:
        """The same with another suffix."""
        return self.parent / (self.stem + suffix)

    def relative_to(self, folder: Remote) -> PurePosixPath:
        """The path below a folder."""
        return PurePosixPath(self.path).relative_to(folder.path)

    def absolute(self) -> Remote:
        """The place itself, because URLs are absolute."""
        return self

    def is_file(self) -> bool:
        """Whether the file exists. A folder that can be listed is listed once."""
        with storage_errors(self):
            storage = _storage(self.url)
            there = _listed(storage, self.parent.path)
            return self.path in there if there else bool(storage.isfile(self.path))

    def is_dir(self) -> bool:
        """Whether the folder exists and is not empty."""
        with storage_errors(self):
            return bool(_storage(self.url).isdir(self.path))

    def files(self) -> list[Remote]:
        """Every file in the folder and below, sorted; empty when there is no folder."""
        with storage_errors(self):
            return [replace(self, path=path) for path in sorted(_storage(self.url).find(self.path))]

    def glob(self) -> list[Remote]:
        """Every file that matches the path as a pattern, sorted."""
        with storage_errors(self):
            return [replace(self, path=path) for path in sorted(_storage(self.url).glob(self.path))]

    def read_bytes(self) -> bytes:
        """The content."""
        with storage_errors(self):
            content: bytes = _storage(self.url).cat_file(self.path)
            return content

    def write_bytes(self, content: bytes) -> None:
        """Write a whole object, which replaces an existing one."""
        with storage_errors(self, "written"):
            storage = _storage(self.url)
            try:
                storage.pipe_file(self.path, content)
            except FileNotFoundError:  # from storage with real folders; object stores have none
                _make_folder(storage, self.parent.path)
                storage.pipe_file(self.path, content)

    def unlink(self) -> None:
        """Remove the file."""
        with storage_errors(self, "removed"):
            _storage(self.url).rm_file(self.path)


Place: TypeAlias = Path | Remote


def parse_place(name: str, root: Place | None = None) -> Place:
    """Parse a place from a user: a URL, or a path, relative to `root` if it is given.

    Raises OptionError for a URL that cannot be opened, MissingExtraError when a package is missing.
    """
    if not SCHEME.match(name):
        path = Path(name)
        return path if root is None or path.is_absolute() else root / name
    parts = urlsplit(name)
    if parts.scheme in HERE and "::" not in name:
        return Path(url2pathname(parts.path))
    return Remote(name, _opened(name)[1])


def is_url(name: str) -> bool:
    """Whether a name is a URL."""
    return bool(SCHEME.match(name))


def place_hash(file: Place) -> str:
    """SHA-256 of a local or remote file, as 64 hex digits."""
    return hashlib.sha256(file.read_bytes()).hexdigest() if isinstance(file, Remote) else content_hash(file)


def write(file: Place, text: str) -> None:
    """Write UTF-8 text atomically. Raises OutputError."""
    if isinstance(file, Remote):
        file.write_bytes(text.encode("utf-8"))
    else:
        write_text(file, text)


@contextmanager
def storage_errors(remote: Remote, verb: str = "read") -> Iterator[None]:
    """Raise any error of a storage as OptionError (OutputError when not reading), in one line.

    The packages behind fsspec have no common base class of errors, so every exception is caught.
    """
    try:
        yield
    except PhonanimError:
        raise
    except FileNotFoundError as error:
        kind = OptionError if verb == "read" else OutputError
        raise kind(f"{remote}: does not exist; correct the URL") from error
    except Exception as error:
        kind = OptionError if verb == "read" else OutputError
        raise kind(f"{remote}: cannot be {verb}: {_line(error)}") from error


def forget_listings() -> None:
    """Clear the cached listings of the storage."""
    _listed.cache_clear()


def _opened(url: str) -> tuple[Any, str]:
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise MissingExtraError(f"{url}: a URL needs pip install 'phonanim[batch]'") from error
    try:
        storage, path = url_to_fs(url, use_listings_cache=False)
        return storage, str(path)
    except ImportError as error:
        raise MissingExtraError(f"{url}: needs another package: {_line(error)}") from error
    except Exception as error:
        raise OptionError(f"{url}: cannot be opened: {_line(error)}") from error


@cache
def _storage(url: str) -> Any:
    return _opened(url)[0]


@lru_cache(maxsize=64)
def _listed(storage: Any, folder: str) -> frozenset[str]:
    """The files in a folder; empty if the storage cannot list, such as some web servers."""
    try:
        entries = storage.ls(folder, detail=True)
        return frozenset(entry["name"] for entry in entries if entry["type"] == "file")
    except (OSError, NotImplementedError):
        return frozenset()


def _make_folder(storage: Any, folder: str) -> None:
    """Create a folder, but never the top one: on an object store, a typing error would create a bucket."""
    top = "/".join(folder.split("/")[: 2 if folder.startswith("/") else 1])
    if storage.exists(top):
        storage.makedirs(folder, exist_ok=True)


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
