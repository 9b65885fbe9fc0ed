"""What is damaged or unclear in the formats of games and of linguistics, and in JSON found by its names."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from other_timings import ANNO, EXB, FACEPOSER, FRAMES, MARY, NUMBERS, TRS, UST, YOUTUBE_OLD

from phonanim.errors import AlignmentError
from phonanim.readers import find_reader, load_reader
from phonanim.speech.alignment_file import AlignmentFile
from phonanim.speech.intervals import Recording


def read(content: Any) -> Recording:
    text = content if isinstance(content, str) else json.dumps(content)
    source = AlignmentFile("x", "x", text.encode())
    return find_reader(source).read(source)


def spans(recording: Recording, place: int = 0) -> list[tuple[str, float, float]]:
    return [(one.label, round(one.start, 3), round(one.end, 3)) for one in recording.tiers[place].intervals]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ANNO.replace("600 90 m", "oops 90 m"), r'has a damaged line "phn 500 oops 90 m"; export it again'),
        (re.sub(r"\n\d+ ", "\n", FACEPOSER), r"has words but no phonemes"),
        (MARY.replace('d="200"', 'd="inf"'), r"is damaged MaryXML \('inf' is not a duration\); synthesize"),
        (MARY.replace(' d="', ' x="'), r"has no phones with durations; ask MaryTTS for REALISED_ACOUSTP"),
        (UST.replace("Length=96", "Length=0"), r"has a damaged note \(.*'0' is not above 0.*\); save it"),
        (YOUTUBE_OLD.replace('dur="0.4"', 'dur="x"'), r"has damaged captions \(.*\); download them again"),
        (EXB.replace(' time="', ' x="'), r"is a damaged transcription \(.*its timeline has no times"),
        (TRS.replace('endTime="0.6"', ""), r"is a damaged transcription \(KeyError\('endTime'\)\); save"),
        ("Start,End,Text\n00:00:01:05,00:00:02:05,hi\n", r"row 2 has a time code that counts frames \(00:"),
        (json.dumps(FRAMES).replace('"fps"', '"x"'), r'has damaged times \("frame" counts frames'),
        (
            json.dumps(NUMBERS).replace("21", "1"),
            r"has numbers of visemes up to 14, which Azure and Oculus count differently; write the names",
        ),
    ],
)  # fmt: skip
def test_damage_is_told(text: str, message: str) -> None:
    with pytest.raises(AlignmentError, match=rf"x: {message}"):
        read(text)


@pytest.mark.parametrize(
    ("content", "start", "end"),
    [
        ([{"word": "me", "from": 200, "to": 600}], 0.2, 0.6),
        ([{"word": "me", "startOffset": 2_000_000, "length": 4_000_000}], 0.2, 0.6),
        ([{"word": "me", "onset": 0.2, "offset": 0.6}], 0.2, 0.6),
        ([{"word": "me", "time": {"begin": 200, "end": 600}}], 0.2, 0.6),
        ([{"word": "me", "startTime": "00:00:00.200", "endTime": "00:00:00.600"}], 0.2, 0.6),
        ({"sentences": [{"tokens": [{"content": "me", "start_ms": 200, "duration_ms": 400}]}]}, 0.2, 0.6),
        ({"words": ["me"], "wordStartTimesSeconds": [0.2], "wordEndTimesSeconds": [0.6]}, 0.2, 0.6),
    ],
)
def test_units_of_json_that_no_reader_names(content: Any, start: float, end: float) -> None:
    assert spans(read(content)) == [("me", start, end)]


def test_sounds_in_milliseconds_are_no_frames() -> None:
    sounds = [{"phoneme": "m", "start": 0, "end": 60}, {"phoneme": "i", "start": 60, "end": 160}]
    recording = read({"data": sounds})
    assert spans(recording) == [("m", 0.0, 0.06), ("i", 0.06, 0.16)]
    assert recording.notes == (
        'read by its names, check the times: "phoneme" with "start" and "end", in milliseconds',
    )


def test_an_empty_label_is_silence_that_ends_the_one_before() -> None:
    frames = [{"phone": "m", "t": 0.1}, {"phone": "", "t": 0.2}, {"phone": "a", "t": 0.5}]
    assert spans(read({"track": frames})) == [("m", 0.1, 0.2), ("", 0.2, 0.5), ("a", 0.5, 0.6)]


def test_words_whose_times_have_unknown_names_are_not_given_new_times() -> None:
    words = {"words": [{"word": "me", "start_time_ms": 700, "end_time_ms": 900}]}
    assert spans(read(words)) == [("me", 0.7, 0.9)]


def test_json_without_times_is_no_alignment() -> None:
    for content in ({"a": 1}, {"weights": [[0, 1]], "names": ["jawOpen"]}, [{"name": "x", "value": 3}]):
        assert not load_reader("any_json").recognizes(AlignmentFile("x", "x", json.dumps(content).encode()))


def test_a_clock_time_beside_a_text_is_no_subtitle() -> None:
    recording = read("Start,End,Text\n00:00:00.200,00:00:00.600,me\n")
    assert spans(recording) == [("me", 0.2, 0.6)]


def test_labels_without_times_are_counted_and_damaged_times_are_refused() -> None:
    sounds = [{"phoneme": "m", "start": 0, "end": 0.1}, {"phoneme": "i"}, {"phoneme": "b", "start": None}]
    recording = read({"data": sounds})
    assert spans(recording) == [("m", 0.0, 0.1)]
    assert recording.notes[1] == "2 labels without times are left out: i, b"
    sounds[1]["start"] = "x1"
    with pytest.raises(AlignmentError, match=r"has damaged times \('i' has the time 'x1' in \"start\"\)"):
        read({"data": sounds})
