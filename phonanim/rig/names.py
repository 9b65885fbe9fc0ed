"""The names of shapes: those that programs and conventions give to what the rigs' controls move.

The tables are lexicon/rigs/names/*.csv, one per convention: a shape, a control of a shipped rig, and the
share of the control's value that the shape takes. A shape may have several rows, and so may a control.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from phonanim.core.decode import DecodeError
from phonanim.core.files import content_hash
from phonanim.core.lexicon import LEXICON
from phonanim.core.tables import read_records
from phonanim.errors import RigError

SIDES = {"l": "left", "r": "right"}
COPIED = re.compile(r"([._]\d{3}|_div\d){1,8}$")  # what Blender adds to a copy, and DAZ to a level of detail
SEPARATOR = re.compile(r"[._:|\s]+")
SHORTEST_ENDING = 5  # letters of a name that is known behind any prefix
FEWEST_SOUNDS = 4  # shapes with short known names behind one prefix, such as `mouth_aa`, that make it known
BEFORE_SOUND = re.compile(r"[._:|\s-]+|(?<=[a-z])(?=[A-Z]{1,2}[a-z]?$)")

Shares = tuple[tuple[str, float], ...]
"""Plain names of controls, and the share of each that a shape takes."""

_added: ContextVar[Mapping[str, Shares]] = ContextVar("added_names")


@lru_cache(maxsize=4096)
def plain_name(name: str) -> str:
    """The plain form of a name, without what programs add: `head.jawOpen`, `JawOpen` and `jaw_open` match.

    A side at the end is written in full, so that `eyeBlink_L` and `eyeBlink.L` are `eyeBlinkLeft`;
    `jawOpen_001` is `jawOpen`.
    """
    bare = re.sub(r"(?<=[a-z])\.(?=[LR]$)", "_", COPIED.sub("", name) or name)
    last = bare.rsplit(".", 1)[-1]
    side = re.fullmatch(r"(.+[a-z])_?([LR])|(.+)_([lr])", last)
    if side:
        stem, letter = (side[1], side[2]) if side[1] else (side[3], side[4])
        last = stem + SIDES[letter.lower()]
    return re.sub(r"[\s_-]", "", last).lower()


@dataclass(frozen=True)
class NameTable:
    """A table of names as workers elsewhere get it: its file's name and hash, and the controls of shapes."""

    name: str
    digest: str
    shares: Mapping[str, Shares]


def read_name_table(path: Path) -> NameTable:
    """Read a table to be sent to workers. Raises RigError."""
    return NameTable(path.name, content_hash(path), read_names([path]))


def added_names(path: Path) -> AbstractContextManager[None]:
    """Know the names of one more table, which win over all others, within a `with` block. Raises RigError."""
    return _adding(read_names([path]))


def known_names(table: NameTable | None) -> AbstractContextManager[None]:
    """As `added_names` of a table that was read, or nothing without one."""
    return nullcontext() if table is None else _adding(table.shares)


@contextmanager
def _adding(shares: Mapping[str, Shares]) -> Iterator[None]:
    token = _added.set(shares)
    try:
        yield
    finally:
        _added.reset(token)


def read_names(paths: Iterable[Path]) -> dict[str, Shares]:
    """The controls of each shape by its plain name, from tables `shape,control[,weight]`. Raises RigError."""
    found: dict[str, dict[str, float]] = {}
    for path in paths:
        for number, row in _rows(path):
            shape, control = row.get("shape"), row.get("control")
            try:
                weight = float(row.get("weight") or 1)
            except ValueError:
                weight = math.nan
            if not shape or not control or not abs(weight) <= 1:
                raise RigError(
                    f"{path}:{number}: is not a shape, a control and a weight from -1 to 1; correct the row"
                )
            found.setdefault(plain_name(shape), {})[plain_name(control)] = weight
    return {shape: tuple(shares.items()) for shape, shares in found.items()}


def match_shapes(
    shapes: tuple[str, ...], channels: tuple[str, ...], present: frozenset[str], source: str
) -> list[tuple[int, int, float]]:
    """(channel, shape, share) for every shape that some channel moves by its name.

    A channel moves the shape of its own name, after the prefixes and endings that programs add; without one
    in the whole character, whose shapes are `present`, it moves those that a table of names gives it. Raises
    RigError when a name fits two shapes of `source`.
    """
    forms, everywhere = _forms(shapes), _forms(tuple(sorted(present)))
    own, known = _shares(forms, _added.get({})), _shares(forms, _tables())
    found: list[tuple[int, int, float]] = []
    for column, channel in enumerate(channels):
        plain = plain_name(channel)
        given = own.get(plain, {})
        if not given:
            given = dict.fromkeys(_named(forms, channel, plain, shapes, source), 1.0)
        if not given and not any(plain in names for names in everywhere):
            given = known.get(plain, {})
        found += [(column, row, share) for row, share in sorted(given.items())]
    return found


def known_controls(shape: str) -> tuple[str, ...]:
    """The plain names that a shape answers to: its own, and the controls that it is the whole of."""
    plain = plain_name(shape)
    endings = (plain, *_endings(shape))
    tables = (_added.get({}), _tables())
    rows = next((table[name] for table in tables for name in endings if name in table), ())
    return (*dict.fromkeys((plain, *endings, *(control for control, share in rows if share > 0))),)


def _named(
    forms: list[dict[str, list[int]]], channel: str, plain: str, shapes: tuple[str, ...], source: str
) -> list[int]:
    """The shape with a channel's exact name, else with its plain name, else behind a prefix."""
    for names in forms:
        alike = names.get(plain, [])
        found = [row for row in alike if shapes[row] == channel] or alike
        if len(found) > 1:
            pair = " and ".join(repr(shapes[row]) for row in found[:2])
            raise RigError(f"{source}: the channel {channel} fits two morph targets, {pair}; rename one")
        if found:
            return found
    return []


def _shares(forms: list[dict[str, list[int]]], table: Mapping[str, Shares]) -> dict[str, dict[int, float]]:
    """For each control the shapes to which a table gives a share of it.

    What a shape gives way to, such as `mouthOpen` to `mouthClose`, counts where no other shape shows it.
    """
    found: dict[str, dict[int, float]] = {}
    taken: set[int] = set()
    for names in forms if table else ():
        rows = [(row, name) for name, alike in names.items() if name in table for row in alike]
        for row, name in rows:
            for control, share in table[name] if row not in taken else ():
                found.setdefault(control, {})[row] = share
        taken |= {row for row, _ in rows}
    for control, shares in found.items():
        if max(shares.values()) > 0:
            found[control] = {row: share for row, share in shares.items() if share > 0}
    return found


@cache
def _forms(shapes: tuple[str, ...]) -> list[dict[str, list[int]]]:
    """Rows by plain name, without the prefix that all names share, and without any prefix."""
    named = [name for name in shapes if name]
    prefix, end = _shared_prefix(named), len(_shared_prefix([name[::-1] for name in named]))
    sounds = _sound_prefixes(named)
    forms: list[dict[str, list[int]]] = [{}, {}, {}]
    for row, name in enumerate(shapes):
        if not name:
            continue
        own, bare = plain_name(name), plain_name(name[len(prefix) : len(name) - end])
        forms[0].setdefault(own, []).append(row)
        if bare != own:
            forms[1].setdefault(bare, []).append(row)
        sound = tuple(plain_name(name[len(one) :]) for one in sounds if name.startswith(one))
        for ending in dict.fromkeys((*_endings(name), *sound)):
            if ending not in (own, bare):
                forms[2].setdefault(ending, []).append(row)
    return forms


def _endings(name: str) -> tuple[str, ...]:
    """The plain names behind each separator of a name, the longest first."""
    name = COPIED.sub("", name)
    found = (plain_name(name[gap.end() :]) for gap in SEPARATOR.finditer(name))
    return tuple(ending for ending in found if len(ending) >= SHORTEST_ENDING)


def _sound_prefixes(names: list[str]) -> list[str]:
    """Prefixes behind which several short names of sounds stand, the longest first."""
    found: dict[str, set[str]] = {}
    for name in names:
        for gap in BEFORE_SOUND.finditer(name):
            found.setdefault(name[: gap.end()], set()).add(plain_name(name[gap.end() :]))
    short = {name for name in _tables() if len(name) < SHORTEST_ENDING}
    known = [one for one, behind in found.items() if len(behind & short) >= FEWEST_SOUNDS]
    return sorted(known, key=len, reverse=True)


def _shared_prefix(names: list[str]) -> str:
    """What all of two names or more begin with, up to a separator."""
    if len(names) < 2:
        return ""
    first, last = min(names), max(names)
    same = next((i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), 0)
    gaps = [gap.end() for gap in SEPARATOR.finditer(first[:same])]
    return first[: gaps[-1]] if gaps else ""


@cache
def _tables() -> dict[str, Shares]:
    return read_names(sorted((LEXICON / "rigs" / "names").glob("*.csv")))


def _rows(path: Path) -> list[tuple[int, dict[str, str]]]:
    try:
        return read_records(path, ("shape", "control"))
    except (OSError, DecodeError) as error:
        raise RigError(
            f"{path}: cannot be read as a table of names: {error}; save it as CSV, UTF-8"
        ) from error
