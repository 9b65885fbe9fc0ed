"""The model's inventory: 41 phone symbols, their articulation and their 60 attribute classes."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.lexicon import LEXICON

N_PHONES = 41
N_ATTRIBUTES = 60
SILENCE = "sil"
CLASSES = ("vowel", "consonant", "silence")
LIPS = ("neutral", "open", "spread", "rounded", "protruded", "teeth", "closed")


@dataclass(frozen=True, slots=True)
class Phone:
    """One symbol of the inventory: a row of lexicon/phones.csv.

    `kind` is one of CLASSES, `lips` (the visible lip shape) one of LIPS. `height` (0 open, 1 close) and
    `backness` (0 front, 1 back) describe the tongue in vowels and glides and are NaN elsewhere; `rounding`
    is 0 to 1 for every phone. The `end_` values differ from the others in diphthongs only.
    """

    name: str
    ipa: str
    example: str
    kind: str
    place: str
    manner: str
    voiced: bool
    height: float
    backness: float
    rounding: float
    end_height: float
    end_backness: float
    end_rounding: float
    lips: str


@dataclass(frozen=True)
class Inventory:
    """The symbols in code order, and the attribute classes of each.

    `attributes` is (41, 60) bool, columns in the order of `attribute_names`. The symbols are those of
    Taylor 2017, supplement section 1; the classes are those of its Table 1. Table 1 also names sounds that
    are not among the 41 symbols (en ax dx oh ia ua ea pau h). lexicon/attributes.csv keeps them as published;
    they have no effect here, so `Diphthong-centring` is empty. One class would become useless in this way:
    "silences: /pau/, /h/" are the pause and the boundary mark of other symbol sets. So the column `added`
    puts our own silences, sil and sp, into it.
    """

    sounds: tuple[Phone, ...]
    attribute_names: tuple[str, ...]
    attributes: NDArray[np.bool_]

    @cached_property
    def phones(self) -> tuple[str, ...]:
        """The 41 names; the code of a phone is its index here."""
        return tuple(sound.name for sound in self.sounds)

    @cached_property
    def _codes(self) -> dict[str, int]:
        return {name: code for code, name in enumerate(self.phones)}

    def code(self, name: str) -> int:
        """The code of a symbol. Raises KeyError when it is not in the inventory."""
        return self._codes[name]

    def mask(self, *names: str) -> NDArray[np.bool_]:
        """Which symbols are among these, (41,). Raises KeyError as `code` does."""
        found = np.zeros(len(self.sounds), bool)
        found[self.codes(names)] = True
        return found

    def codes(self, names: Iterable[str]) -> NDArray[np.uint8]:
        """The codes of symbols, (names,). Raises KeyError as `code` does."""
        return np.array([self._codes[name] for name in names], dtype=np.uint8)

    def numbers(self, column: str) -> NDArray[np.float64]:
        """A numeric column of the phones (height, rounding, voiced, ...), (41,), NaN for empty cells."""
        return np.array([getattr(sound, column) for sound in self.sounds], dtype=np.float64)

    def where(self, **columns: str | bool) -> NDArray[np.bool_]:
        """A mask of the phones with these values, (41,): `where(place="bilabial")`, `where(kind="vowel")`."""
        return np.array([all(getattr(s, k) == v for k, v in columns.items()) for s in self.sounds])

    def attribute(self, name: str) -> NDArray[np.bool_]:
        """A mask of the phones in a class of Table 1, (41,). Raises ValueError for an unknown class."""
        return self.attributes[:, self.attribute_names.index(name)]


def load_inventory(folder: Path) -> Inventory:
    """The inventory of `folder`/phones.csv and attributes.csv. Raises ValueError if they are inconsistent."""
    sounds = tuple(_phone(row) for row in _rows(folder / "phones.csv"))
    classes = _rows(folder / "attributes.csv")
    names = tuple(row["attribute"] for row in classes)
    members = [set(f"{row['members']} {row['added']}".split()) for row in classes]
    attributes = np.array([[sound.name in group for group in members] for sound in sounds], dtype=bool)
    inventory = Inventory(sounds, names, attributes)
    _check(inventory)
    return inventory


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _phone(row: dict[str, str]) -> Phone:
    def number(column: str) -> float:
        return float(row[column] or "nan")

    return Phone(
        name=row["phone"],
        ipa=row["ipa"],
        example=row["example"],
        kind=row["class"],
        place=row["place"],
        manner=row["manner"],
        voiced=row["voiced"] == "1",
        height=number("height"),
        backness=number("backness"),
        rounding=number("rounding"),
        end_height=number("end_height"),
        end_backness=number("end_backness"),
        end_rounding=number("end_rounding"),
        lips=row["lips"],
    )


def _check(inventory: Inventory) -> None:
    if len(set(inventory.phones)) != N_PHONES or inventory.phones[0] != SILENCE:
        raise ValueError(f"phones.csv: expected {N_PHONES} different symbols, {SILENCE} first")
    if len(set(inventory.attribute_names)) != N_ATTRIBUTES:
        raise ValueError(f"attributes.csv: expected {N_ATTRIBUTES} different classes")
    for sound in inventory.sounds:
        if sound.kind not in CLASSES or sound.lips not in LIPS:
            raise ValueError(f"phones.csv: {sound.name} has class {sound.kind} and lips {sound.lips}")


INVENTORY = load_inventory(LEXICON)
"""The inventory that every model and language of the package uses."""
