"""The inventory and its classes are the supplement's, and damaged tables are refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from phonanim.core.lexicon import LEXICON
from phonanim.speech.inventory import INVENTORY, load_inventory

SUPPLEMENT = """
sil dh ih s z uh p r aa b l m th ae d g ow k n er iy y w eh ch v t sh f ah sp hh aw oy uw ey ao zh ay jh ng
"""


def test_phones_are_those_of_the_supplement_in_its_order() -> None:
    assert INVENTORY.phones == tuple(SUPPLEMENT.split())
    assert [INVENTORY.code(name) for name in SUPPLEMENT.split()] == list(range(41))
    assert INVENTORY.codes(["sil", "ng"]).tolist() == [0, 40]


def test_attributes_have_the_published_shape_and_members() -> None:
    assert INVENTORY.attributes.shape == (41, 60)
    phones = np.array(INVENTORY.phones)
    assert set(phones[INVENTORY.attribute("Bilabial")]) == {"p", "b", "m"}
    assert set(phones[INVENTORY.attribute("Vowel-Mid")]) == {"eh", "er", "ao"}
    assert set(phones[INVENTORY.attribute("silences")]) == {"sil", "sp"}
    assert not INVENTORY.attribute("Diphthong-centring").any()
    assert INVENTORY.attributes.sum() == 273


def test_articulation_agrees_with_the_attribute_classes() -> None:
    pairs = [("Vowel", "kind", "vowel"), ("Bilabial", "place", "bilabial"), ("Nasal", "manner", "nasal")]
    pairs += [("Labiodental", "place", "labiodental"), ("Dental", "place", "dental")]
    pairs += [("Plosive", "manner", "plosive"), ("Affricative", "manner", "affricate")]
    for name, column, value in pairs:
        assert (INVENTORY.attribute(name) == INVENTORY.where(**{column: value})).all(), name


def test_only_diphthongs_end_elsewhere() -> None:
    moves = INVENTORY.numbers("height") != INVENTORY.numbers("end_height")
    moves &= ~np.isnan(INVENTORY.numbers("height"))
    assert (moves == INVENTORY.attribute("Diphthong-Closing")).all()


def test_vowels_have_a_height_and_everything_a_rounding() -> None:
    assert np.isfinite(INVENTORY.numbers("height")[INVENTORY.where(kind="vowel")]).all()
    assert np.isfinite(INVENTORY.numbers("rounding")).all()


def test_unknown_names_raise() -> None:
    with pytest.raises(KeyError, match="xx"):
        INVENTORY.code("xx")
    with pytest.raises(ValueError):
        INVENTORY.attribute("Tasty")


@pytest.mark.parametrize(
    ("table", "old", "new", "message"),
    [
        ("phones.csv", "\nng,", "\nm,", "phones.csv: expected 41 different symbols, sil first"),
        ("attributes.csv", "silences,", "Front,", "attributes.csv: expected 60 different classes"),
        (
            "phones.csv",
            "bilabial,nasal,1,,,0,,,0,closed",
            "bilabial,nasal,1,,,0,,,0,shut",
            "m has .* lips shut",
        ),
    ],
)
def test_damaged_tables_are_refused(tmp_path: Path, table: str, old: str, new: str, message: str) -> None:
    for name in ("phones.csv", "attributes.csv"):
        shutil.copy(LEXICON / name, tmp_path)
    text = (tmp_path / table).read_text("utf-8")
    assert old in text
    (tmp_path / table).write_text(text.replace(old, new), "utf-8")
    with pytest.raises(ValueError, match=message):
        load_inventory(tmp_path)
