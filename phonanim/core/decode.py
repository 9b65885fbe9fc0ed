"""Decode untrusted files within limits: size, depth, finite numbers. Nothing is used before it is checked.

Every function raises DecodeError, a ValueError whose message does not name the file.
"""

from __future__ import annotations

import io
import json
import math
import re
import sys
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import open_plain, read_bounded
from phonanim.core.text import printable

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_JSON = 1 << 30
"""Bytes of a JSON file: two hours of 60 curves at 60 fps have about 200 MB."""

MAX_TOML = 1 << 20
"""Bytes of a TOML file: the rig of an artist has about 20 kB."""

MAX_TEXT = 1 << 22
"""Bytes of a text that is spoken: a novel has about a million."""

MAX_DEPTH = 64
"""Levels of tables and lists: our own files have ten."""

MAX_UNPACKED, MAX_RATIO = 1 << 28, 32
"""Bytes that an archive of any size may unpack to, and how many times its own size a larger one may."""

MAX_RATE = 1000.0
"""Largest frame rate."""

MAX_TIME = 1e6
"""Largest distance of a time from zero, in seconds: eleven days."""

SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
DAMAGE = (KeyError, IndexError, TypeError, AttributeError, ValueError, ArithmeticError, RecursionError)
"""The exceptions that parsed data of the wrong structure raise."""

HEADER_DAMAGE = (*DAMAGE, EOFError, MemoryError, SyntaxError, tokenize.TokenError)
"""The exceptions that NumPy raises for the header of an array, which is an expression of Python."""


class DecodeError(ValueError):
    """Data that cannot be decoded, or that no program writes on purpose."""


def read_json(path: Path, most: int = MAX_JSON) -> Any:
    """The content of a JSON file. Raises DecodeError, OSError."""
    return parse_json(read_utf8(path, most))


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file. Raises DecodeError, OSError."""
    text = read_utf8(path, MAX_TOML).removeprefix("\ufeff")
    try:
        tree = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DecodeError(f"it is not TOML: {fault_reason(error)}") from error
    check_depth(tree)
    return tree


def read_utf8(path: Path, most: int = MAX_JSON) -> str:
    """The content of a text file. Raises DecodeError, OSError."""
    try:
        return read_bounded(path, most).decode("utf-8")
    except UnicodeDecodeError as error:
        raise DecodeError(f"it is not UTF-8 text (byte {error.start})") from error
    except ValueError as error:
        raise DecodeError(str(error)) from error


def parse_json(text: str | bytes, numbers_only: bool = True) -> Any:
    """JSON of limited depth and with valid Unicode texts. Raises DecodeError.

    NaN and Infinity are refused with `numbers_only`. Recognizers write them for an unknown confidence.
    """
    try:
        tree = _tree(text, _refuse_constant if numbers_only else None)
    except (ValueError, RecursionError) as error:
        raise DecodeError(f"it is not JSON: {fault_reason(error)}") from error
    check_nesting(tree, text.decode("utf-8", "replace") if isinstance(text, bytes) else text)
    return tree


def check_nesting(tree: Any, written: str) -> None:
    """Raise DecodeError for parsed JSON that is nested too deep, or has half a character in a text."""
    if written.count("[") + written.count("{") > MAX_DEPTH:  # else it cannot be deeper
        check_depth(tree)
    if SURROGATE.search(written):
        try:
            json.dumps(tree, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise DecodeError(f"it holds half a character, \\u{ord(error.object[error.start]):x}") from error


def check_depth(tree: Any) -> None:
    """Raise DecodeError when tables and lists are nested deeper than MAX_DEPTH."""
    level: list[Iterable[Any]] = [[tree]]
    for _ in range(MAX_DEPTH + 1):
        level = [
            child.values() if isinstance(child, dict) else child
            for children in level
            for child in children
            if isinstance(child, (dict, list))
        ]
        if not level:
            return
    raise DecodeError(f"it is nested deeper than {MAX_DEPTH} levels")


def read_tensors(path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of a safetensors file, by name. Raises DecodeError, OSError."""
    from safetensors import SafetensorError
    from safetensors.numpy import load_file

    try:
        open_plain(path).close()
        tensors: dict[str, NDArray[Any]] = load_file(path)
    except (ValueError, SafetensorError) as error:
        raise DecodeError(f"it has no tensors: {fault_reason(error)}") from error
    return tensors


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of a NumPy archive (.npz). Raises DecodeError, OSError."""
    size = path.stat().st_size
    room = max(MAX_UNPACKED, MAX_RATIO * size)
    try:
        data = read_bounded(path, MAX_JSON)
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > room:
                raise DecodeError(f"it unpacks to more than {room >> 20} MB")
            return {
                entry.filename.removesuffix(".npy"): parse_array(_unpacked(archive, entry))
                for entry in archive.infolist()
            }
    except DecodeError:
        raise
    except (*DAMAGE, zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise DecodeError(f"it is not an archive of arrays: {fault_reason(error)}") from error


def _unpacked(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
    """A file of an archive, never more of it than its entry says. Raises DecodeError.

    `ZipFile.read` unpacks all that is there before it looks at the size, and bzip2 and LZMA cannot be
    unpacked in pieces of a given size. NumPy writes neither.
    """
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise DecodeError("it is packed in another way than numpy.savez packs; save it with NumPy")
    with archive.open(entry) as stream:
        return stream.read(entry.file_size)


def array_names(path: Path) -> set[str]:
    """The names of the arrays in a NumPy archive, which are not read. Raises DecodeError, OSError."""
    try:
        with open_plain(path) as stream, zipfile.ZipFile(stream) as archive:
            return {name.removesuffix(".npy") for name in archive.namelist()}
    except (*DAMAGE, zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise DecodeError(f"it is not an archive of arrays: {fault_reason(error)}") from error


def read_array(path: Path) -> NDArray[Any]:
    """The array of a NumPy file (.npy), read-only. Raises DecodeError, OSError."""
    try:
        return parse_array(read_bounded(path, MAX_JSON))
    except DecodeError:
        raise
    except ValueError as error:
        raise DecodeError(str(error)) from error


def map_array(path: Path) -> NDArray[Any]:
    """The array of a NumPy file (.npy), read-only, whose values are read when they are used.

    Raises DecodeError, OSError.
    """
    try:
        open_plain(path).close()
        return np.lib.format.open_memmap(path, "r")
    except HEADER_DAMAGE as error:
        raise DecodeError(f"it has no array of numbers: {fault_reason(error)}") from error


def parse_array(data: bytes) -> NDArray[Any]:
    """The array in the bytes of a NumPy file, without a copy; objects are refused. Raises DecodeError."""
    stream = io.BytesIO(data)
    try:
        version = np.lib.format.read_magic(stream)
        read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
        shape, columns, kind = read[version](stream)
        if kind.hasobject:
            raise DecodeError("its array has objects; store numbers")
        count = math.prod(shape)
        if min(shape, default=0) < 0 or count * kind.itemsize > len(data) - stream.tell():
            raise DecodeError(f"its array of {shape} values is truncated")
        values = np.frombuffer(data, kind, count, stream.tell())
        return values.reshape(shape, order="F" if columns else "C")
    except DecodeError:
        raise
    except HEADER_DAMAGE as error:
        raise DecodeError(f"it has no array of numbers: {fault_reason(error)}") from error


def decode_number(value: Any, name: str, low: float = -MAX_TIME, high: float = MAX_TIME) -> float:
    """A finite number from `low` to `high`. Raises DecodeError, which names it."""
    plain = type(value) in (int, float) or isinstance(value, (np.integer, np.floating))
    if not plain or not low <= value <= high:  # false for NaN, too
        raise DecodeError(f"{name} is {_quote(value)}; it is a number from {low:g} to {high:g}")
    return float(value)


def decode_whole(value: Any, name: str, low: int, high: int) -> int:
    """A whole number from `low` to `high`. Raises DecodeError, which names it."""
    if type(value) is not int or not low <= value <= high:
        raise DecodeError(f"{name} is {_quote(value)}; it is a whole number from {low} to {high}")
    return value


def decode_rate(value: Any, name: str = "fps") -> float:
    """Frames per second, above 0 and at most MAX_RATE. Raises DecodeError."""
    return decode_number(value, name, 1e-3, MAX_RATE)


def decode_table(value: Any, name: str) -> dict[str, Any]:
    """A table. Raises DecodeError, which names it."""
    if not isinstance(value, dict):
        raise DecodeError(f"{name} is {_quote(value)}; it is a table")
    return value


def decode_list(value: Any, name: str) -> list[Any]:
    """A list. Raises DecodeError, which names it."""
    if not isinstance(value, list):
        raise DecodeError(f"{name} is {_quote(value)}; it is a list")
    return value


def decode_text(value: Any, name: str) -> str:
    """A text. Raises DecodeError, which names it."""
    if not isinstance(value, str):
        raise DecodeError(f"{name} is {_quote(value)}; it is a text")
    return value


def decode_file_name(value: Any, name: str) -> str:
    """The plain name of a file, without folder, drive or address. Raises DecodeError."""
    if not isinstance(value, str) or re.search(r"[/\\:\0]", value) or value in ("", ".", ".."):
        raise DecodeError(f"{name} is {_quote(value)}; it is the plain name of a file beside this one")
    return value


def decode_part(value: Any, name: str) -> str:
    """A text that is one part of a path, as names of clips are, whose files are named after them.

    Raises DecodeError.
    """
    if not isinstance(value, str) or "\0" in value or value in ("", "..") or Path(value).name != value:
        raise DecodeError(f"{name} is {_quote(value)}; it is a name without a folder")
    return value


def decode_path_below(value: Any, name: str) -> str:
    """The path of a file in the folder of this one or below it, with "/". Raises DecodeError."""
    parts = value.split("/") if isinstance(value, str) else []
    if not parts or re.search(r"[\\:\0]", value) or not {"", ".", ".."}.isdisjoint(parts):
        raise DecodeError(f"{name} is {_quote(value)}; it is the path of a file below this folder")
    return str(value)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"it has {name}, which is not a number")


_FINITE = json.JSONDecoder(parse_constant=_refuse_constant)


def _tree(text: str | bytes, constant: Callable[[str], float] | None) -> Any:
    if constant is _refuse_constant and isinstance(text, str) and text.startswith("{"):
        return _FINITE.decode(text)  # without a new decoder, because ledgers have a text for each line
    return json.loads(text, parse_constant=constant)


def _quote(value: Any) -> str:
    text = repr(value) if isinstance(value, (str, int, float, bool, type(None))) else type(value).__name__
    return printable(text if len(text) <= 60 else f"{text[:59]}…")


def fault_reason(error: BaseException) -> str:
    """What an error says, in one line of limited length."""
    if isinstance(error, RecursionError):
        return f"it is nested deeper than {MAX_DEPTH} levels"
    return printable(" ".join(str(error).split())[:200]) or type(error).__name__
