"""The phone tier is found by name, else by its labels; a wrong choice is told what there is."""

from __future__ import annotations

from pathlib import Path

import pytest
from textgrid_text import BEAM, WORDS, Tiers, long_text, save

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment

NAMES = [
    "phones",
    "phone",
    "phons",
    "phonemes",
    "segments",
    "MAU",
    "Phones ",
    "SPEAKER 1 - phones",
    '"phone"',
]


def read(folder: Path, tiers: Tiers, tier: str | None = None):
    return read_alignment(save(folder, long_text(tiers)), tier)


@pytest.mark.parametrize("name", NAMES)
def test_usual_names_are_found(tmp_path: Path, name: str) -> None:
    alignment = read(tmp_path, [("words", WORDS), (name, BEAM), ("notes", [(0, 1, "B")])])
    assert alignment.tier == name


def test_the_better_name_wins(tmp_path: Path) -> None:
    assert read(tmp_path, [("segments", WORDS), ("MAU", BEAM)]).tier == "MAU"


def test_without_a_name_the_labels_tell(tmp_path: Path) -> None:
    assert read(tmp_path, [("transcript", WORDS), ("mine", BEAM)]).tier == "mine"


def test_an_empty_namesake_does_not_count(tmp_path: Path) -> None:
    assert len(read(tmp_path, [("phones", [(0, 1, "")]), ("phones", BEAM)]).intervals) == len(BEAM)


def test_words_are_those_of_the_same_speaker(tmp_path: Path) -> None:
    other = [(0.0, 1.0, "other")]
    tiers = [("B - words", other), ("A - words", WORDS), ("A - phones", BEAM)]
    assert [word.label for word in read(tmp_path, tiers).words if word.label] == ["beam"]


@pytest.mark.parametrize(
    ("wanted", "tier"), [("mine", "mine"), ("MINE", "mine"), ("1", "mine"), ("2", "phones")]
)
def test_a_tier_is_chosen_by_name_or_number(tmp_path: Path, wanted: str, tier: str) -> None:
    assert read(tmp_path, [("mine", BEAM), ("phones", BEAM)], wanted).tier == tier


def test_a_name_goes_before_a_number(tmp_path: Path) -> None:
    assert read(tmp_path, [("2", BEAM), ("phones", BEAM)], "2").tier == "2"


NAMED = ["Ann - phones", "Ann_phones", "Ann phone", "Ann:phones"]


@pytest.mark.parametrize("name", NAMES[:1] + NAMED)
@pytest.mark.parametrize("speaker", ["Ann", "ann ", None])
def test_a_tier_is_chosen_by_its_speaker(tmp_path: Path, name: str, speaker: str | None) -> None:
    others = [("Bob - phones", [(0, 1, "AA")])] if name in NAMED else []
    path = save(tmp_path, long_text([*others, (name, BEAM)]))
    if others and speaker is None:
        with pytest.raises(AlignmentError, match=r'--speaker \("Bob", "Ann"\)'):
            read_alignment(path)
    elif not others and speaker:
        with pytest.raises(
            AlignmentError, match=r'a.TextGrid: has no speaker "ann ?"; speakers: none is named'
        ):
            read_alignment(path, speaker=speaker.lower())
    else:
        assert read_alignment(path, speaker=speaker).tier == name


FAULTS = [
    ([("notes", WORDS)], None, r'has no phone tier among 1 "notes"; name it with --tier'),
    ([("words", WORDS)], "sounds", r'has no interval tier "sounds"; there are 1 "words"'),
    ([("a", BEAM), ("a", BEAM)], "a", r'has 2 tiers "a"; choose by number: 1 "a", 2 "a"'),
    (
        [("X - phones", BEAM), ("Y - phones", BEAM)],
        None,
        r'has several phone tiers, 1 "X - phones", 2 "Y - phones"; '
        r'choose one with --speaker \("X", "Y"\) or --tier',
    ),
    ([("pauses", [(0, 1, "sil")])], None, r'has no phone tier among 1 "pauses"'),
]


@pytest.mark.parametrize(("tiers", "wanted", "message"), FAULTS)
def test_what_cannot_be_chosen(tmp_path: Path, tiers: Tiers, wanted: str | None, message: str) -> None:
    with pytest.raises(AlignmentError, match=rf"a.TextGrid: {message}"):
        read(tmp_path, tiers, wanted)
