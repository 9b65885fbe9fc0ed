"""Damage in the timing of synthesizers, recognizers and animation programs, and what is special in each."""

from __future__ import annotations

import json
import sys

import pytest
from timing_samples import EVERY, USTX

from phonanim.errors import AlignmentError, MissingExtraError
from phonanim.readers import find_reader, load_reader
from phonanim.speech.alignment_file import AlignmentFile


def source(text: str | bytes) -> AlignmentFile:
    return AlignmentFile("x", "x", text if isinstance(text, bytes) else text.encode())


DAMAGED = [
    (
        "azure_speech",
        0,
        '"Duration": 900000',
        '"Duration": null',
        r"has a damaged word \(.*\); save the result",
    ),
    (
        "azure_visemes",
        0,
        '"visemeId": 21',
        '"visemeId": 99',
        r"has a damaged viseme \(.*\); record the events",
    ),
    ("polly", 0, '"time": 300', '"time": "x"', r"has a damaged mark \(.*\); synthesize it again"),
    ("kokoro", 0, '"start_time": 0.2', '"start_time": "x"', r"has a damaged token \(.*\); synthesize"),
    (
        "headtts",
        0,
        '"vtimes": [200, ',
        '"vtimes": [',
        r"has damaged times \(.*3 visemes, 2 vtimes.*\); synthesize",
    ),
    (
        "voicevox",
        0,
        '"vowel_length": 0.4',
        '"vowel_length": null',
        r"has a damaged mora \(.*\); query it again",
    ),
    ("piper", 0, '"end": 0.5', '"end": null', r"has a damaged phoneme \(.*\); synthesize it again"),
    ("piper", 2, "[2000, ", '["x", ', r"has a damaged phoneme"),
    ("mbrola", 0, "b\t100", "b\toops", r'row 2 "b\s+oops" is damaged; correct it'),
    ("timed_table", 0, "0.600\tm", "oops\tm", r"row 4 .* is damaged; correct it"),
    ("bournemouth", 0, '"end_ms": 216.0', '"end_ms": null', r"has a damaged phoneme \(.*\); align again"),
    ("julius", 0, "-- phoneme alignment --", "-- state alignment --", ""),
    ("pocketsphinx", 0, '"d": 0.1', '"d": "x"', r"has a damaged word \(.*\); recognize again"),
    ("sppas", 0, 'midpoint="0.3"', 'midpoint="x"', r"is a damaged SPPAS file \(.*\); save it again"),
    (
        "sppas",
        0,
        "<End midpoint",
        "<Fin midpoint",
        r"is a damaged SPPAS file \(an interval has no .* end\)|mismatched",
    ),
    ("xlights", 0, 'starttime="300"', 'start="300"', r"is a damaged timing track \(.*\); export it again"),
    ("papagayo_ng", 0, '"frame": 12', '"frame": "x"', r"is a damaged project \(.*\); save it again"),
    ("diffsinger", 0, '"ph_dur": "0.1 ', '"ph_dur": "', r"has a damaged line \(3 phonemes and 2 durations\)"),
    (
        "diffsinger",
        0,
        '"ph_dur"',
        '"x"',
        r"has a damaged line \(it has no ph_dur\); export it with its durations",
    ),
    (
        "characters",
        1,
        "[0.2, 0.3, ",
        "[0.2, ",
        r"has damaged times of characters \(.*7 characters, 6 starts.*\)",
    ),
    ("google_words", 0, "0.600s", "oopss", r"has a damaged word \(.*\); recognize again"),
    ("aeneas", 0, '"0.600"', '"x"', r"has a damaged fragment \(.*\); align again"),
    ("elan", 0, "<HEADER", "<!ENTITY a 'b'><HEADER", r"is a damaged ELAN file \(it declares entities"),
]


@pytest.mark.parametrize(("name", "number", "old", "new", "message"), DAMAGED)
def test_damage_is_told(name: str, number: int, old: str, new: str, message: str) -> None:
    content = EVERY[name][number].data.decode()
    assert old in content
    damaged = source(content.replace(old, new, 1))
    if not message:
        assert [tier.name for tier in load_reader(name).read(damaged).tiers] == ["words"]
        return
    with pytest.raises(AlignmentError, match=rf"x: {message}"):
        load_reader(name).read(damaged)


def test_julius_without_an_alignment() -> None:
    with pytest.raises(
        AlignmentError, match="has no phonemes in its forced alignment; run Julius with -palign"
    ):
        load_reader("julius").read(source("=== begin forced alignment ===\n"))


def test_voicevox_without_lengths() -> None:
    content = json.loads(EVERY["voicevox"][0].data)
    for mora in content["accent_phrases"][0]["moras"]:
        mora["consonant_length"] = mora["vowel_length"] = 0.0
    with pytest.raises(AlignmentError, match="has no lengths of phonemes; query `mora_data`"):
        load_reader("voicevox").read(source(json.dumps(content)))


def test_a_table_without_rows() -> None:
    with pytest.raises(AlignmentError, match="has no rows; export it again"):
        load_reader("timed_table").read(source("start,end,label\n"))


def test_a_table_with_a_cell_that_is_too_large() -> None:
    for name, header in (("timed_table", "start,end,label"), ("mfa_csv", "Begin,End,Label,Type,Speaker")):
        with pytest.raises(AlignmentError, match=r"has a damaged row \(field larger .*\); export it again"):
            load_reader(name).read(source(header + "\n" + "a" * 200_000))


def test_whisper_tables_count_milliseconds() -> None:
    recording = load_reader("timed_table").read(source("start\tend\ttext\n200\t600\tbeam me\n"))
    assert [(one.label, round(one.start, 3)) for one in recording.tiers[0].intervals] == [
        ("beam", 0.2),
        ("me", 0.45),
    ]


def test_decimal_commas_and_frequencies_of_audacity() -> None:
    text = "0,200000\t0,300000\tb\n\\\t90,000000\t4000,000000\n0,300000\t0,500000\tiː\n"
    found = find_reader(source(text))
    assert found is load_reader("seconds")
    assert [(one.label, one.start) for one in found.read(source(text)).tiers[0].intervals] == [
        ("b", 0.2),
        ("iː", 0.3),
    ]


def test_trigraphs_of_praat() -> None:
    grid = '"ooTextFile"\n"TextGrid"\n0 1\n<exists>\n1\n"IntervalTier" "phones" 0 1 1\n0 1 "\\as\\:f\\zz"\n'
    (tier,) = load_reader("textgrid").read(source(grid)).tiers
    assert tier.intervals[0].label == "ɑː\\zz"


@pytest.mark.parametrize(
    ("rows", "labels"),
    [
        ("u 0.2 0.1 B_B\nu 0.3 0.2 IY1_E\n", ["B", "IY1"]),
        ("u A 0.2 0.1 b NA lex NA\nu A 0.3 0.2 iy 0.98 lex spk1\n", ["b", "iy"]),
        (
            "u 1 0.2 0.1 ▁be 0.9\nu 1 0.3 0.1 am 0.9\nu 1 0.4 0.1 <space> 0.9\nu 1 0.5 0.1 m 0.9\n",
            ["beam", "m"],
        ),
    ],
)
def test_columns_of_ctm(rows: str, labels: list[str]) -> None:
    (tier,) = load_reader("ctm").read(source(rows)).tiers
    assert [one.label for one in tier.intervals] == labels


def test_sets_of_papagayo() -> None:
    cases = (("M", "AY", "english"), ("MBP", "AI", "preston_blair"), ("MBP", "EHSZ", "english"))
    for first, second, language in cases:
        recording = load_reader("moho").read(source(f"MohoSwitch1\n1 {first}\n7 {second}\n13 rest\n"))
        assert recording.language == language


def test_openutau_needs_a_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "yaml", None)
    with pytest.raises(MissingExtraError, match=r"x: reading .ustx needs pip install 'phonanim\[singing\]'"):
        load_reader("openutau").read(source(USTX))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("bpm: 240", "bpm: 0", r"is a damaged project \(ZeroDivisionError.*\); save it again"),
        ("- name: Mary", "- name: [", r"is a damaged project \(.*\); save it again"),
        ("- name: Mary", "- name: &a Mary", r"has anchors, which a project does not need"),
        ("  notes:", "  none:", r"has no notes; save it with a part that is sung"),
    ],
)
def test_projects_of_openutau(old: str, new: str, message: str) -> None:
    pytest.importorskip("yaml")
    with pytest.raises(AlignmentError, match=f"x: {message}"):
        load_reader("openutau").read(source(USTX.replace(old, new, 1)))


def test_notes_of_openutau_follow_the_tempo() -> None:
    pytest.importorskip("yaml")
    words, phones = load_reader("openutau").read(source(USTX)).tiers
    assert [(one.label, round(one.start, 3), round(one.end, 3)) for one in words.intervals] == [
        ("beam", 0.2, 0.6)
    ]
    assert [one.label for one in phones.intervals] == ["b", "iy", "m"]
