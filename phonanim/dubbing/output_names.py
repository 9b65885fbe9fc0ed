"""Make output names that are valid on every file system, from the ids of lines."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from pathlib import PurePosixPath

from phonanim.dubbing.listing import folded_name
from phonanim.errors import OptionError

FORBIDDEN = re.compile(r'[<>:"|?*\x00-\x1f\x7f]')  # by NTFS, exFAT or SMB
DEVICE = r"con|prn|aux|nul|com[\d¹²³]|lpt[\d¹²³]|conin\$|conout\$"
RESERVED = re.compile(rf"({DEVICE})\s*(\..*)?", re.IGNORECASE)  # on Windows
PLAIN = re.compile(r"[A-Za-z0-9_-]{1,100}")  # as most parts are, which need no change
LONGEST_PATH = 1000  # bytes, of the 4096 that a path has on Linux
LONGEST = 180  # bytes of a file name: 255 less room for a suffix and the name of an unfinished file


def safe_name(id: str) -> PurePosixPath:
    """The output path of a line, relative and without suffix; slashes in the id make folders.

    A part that had to be changed ends in six hex digits of its hash, so that different ids get different
    names. Raises OptionError for an id that is empty, too long, or leads out of the output folder.
    """
    parts = id.replace("\\", "/").split("/")
    if not id.strip():
        raise OptionError("the id is empty; give every line an id")
    if ".." in parts or not parts[0] or re.match(r"[A-Za-z]:", parts[0]):
        raise OptionError(f"the id {id!r} is outside the output folder; use a relative path")
    kept = [_safe_part(part) for part in parts if part not in ("", ".")]
    if not kept:
        raise OptionError(f"the id {id!r} is not a file name; give every line an id")
    if sum(len(part.encode()) + 1 for part in kept) > LONGEST_PATH:
        raise OptionError(f"the id {id[:40]!r}... is too long for a path; give the line a shorter one")
    return PurePosixPath(*kept)


def collision_key(name: PurePosixPath) -> str:
    """A key that is equal for paths that some file system treats as one."""
    return folded_name(str(name))


def _safe_part(part: str) -> str:
    if PLAIN.fullmatch(part) and not RESERVED.fullmatch(part):
        return part
    safe = FORBIDDEN.sub("_", unicodedata.normalize("NFC", part)).rstrip(". ").lstrip(" ")
    if not safe or RESERVED.fullmatch(safe) or safe.startswith("."):
        safe = "_" + safe
    cut = safe.encode()[:LONGEST].decode(errors="ignore")
    if cut == part:
        return part
    return f"{cut}-{hashlib.sha256(part.encode()).hexdigest()[:6]}"
