"""The shapes that channels move, by the names that programs and conventions give them.

The tables in the folder `names` are those of phonanim: a shape, a control, and the share of the control's
value that the shape takes. Nothing here needs Blender.
"""

import csv
import re
from collections.abc import Iterable
from pathlib import Path

from .takes import TakeError

SIDES = {"l": "left", "r": "right"}
COPIED = re.compile(r"([._]\d{3}|_div\d)+$")  # what Blender adds to a copy, and DAZ to a level of detail
SEPARATOR = re.compile(r"[._:|\s]+")
SHORTEST_ENDING = 5  # letters of a name that is known behind any prefix
FOLDER = Path(__file__).parent / "names"

Table = dict[str, dict[str, float]]  # shares of controls by the plain name of a shape


def plain_name(name: str) -> str:
    """A name without what programs add: `head.jawOpen`, `JawOpen`, `jaw_open` and `jawOpen.001` are one."""
    bare = re.sub(r"(?<=[a-z])\.(?=[LR]$)", "_", COPIED.sub("", name) or name)
    last = bare.rsplit(".", 1)[-1]
    side = re.fullmatch(r"(.+[a-z])_?([LR])|(.+)_([lr])", last)
    if side:
        stem, letter = (side[1], side[2]) if side[1] else (side[3], side[4])
        last = stem + SIDES[letter.lower()]
    return re.sub(r"[\s_-]", "", last).lower()


def read_names(paths: Iterable[Path]) -> Table:
    """Tables `shape,control,weight`, with that line at their head. Raises TakeError."""
    found: Table = {}
    for path in paths:
        try:
            with path.open(encoding="utf-8-sig", newline="") as stream:
                reader = csv.DictReader(stream)
                if not {"shape", "control"} <= set(reader.fieldnames or ()):
                    raise ValueError("its first line is another")
                for row in reader:
                    shares = found.setdefault(plain_name(row["shape"]), {})
                    shares[plain_name(row["control"])] = float(row.get("weight") or 1)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise TakeError(f"{path}: is not a table shape,control,weight: {error!r}") from error
    return found


def match_shapes(channels: list[str], shapes: list[str], own: Table) -> dict[str, dict[str, float]]:
    """The channels that move each shape, and the share of each.

    A channel moves what the user's `own` table gives it, else the shape of its name, after what programs add,
    else what a convention gives it.
    """
    forms: dict[str, str] = {}
    for find in (lambda shape: (plain_name(shape),), _endings):
        for shape in shapes:
            for form in find(shape):
                forms.setdefault(form, shape)
    tables = read_names(sorted(FOLDER.glob("*.csv")))
    found: dict[str, dict[str, float]] = {}
    for channel in channels:
        named = channel if channel in shapes else forms.get(plain_name(channel))
        given = _shares(channel, forms, own) or ({named: 1.0} if named else _shares(channel, forms, tables))
        for shape, share in given.items():
            found.setdefault(shape, {})[channel] = share
    return found


def _shares(channel: str, forms: dict[str, str], table: Table) -> dict[str, float]:
    """The shapes to which a table gives a share of a channel."""
    plain = plain_name(channel)
    return {shape: table[form][plain] for form, shape in forms.items() if plain in table.get(form, {})}


def _endings(name: str) -> list[str]:
    """The plain names behind each separator of a name, the longest first."""
    name = COPIED.sub("", name)
    found = [plain_name(name[gap.end() :]) for gap in SEPARATOR.finditer(name)]
    return [ending for ending in found if len(ending) >= SHORTEST_ENDING]
