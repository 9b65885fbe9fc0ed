"""What is damaged or unclear in the formats of games and of linguistics, and in JSON found by its names."""

from __future__ import annotations

import contextlib
import json
import re
import sys
from typing import Any

import pytest
from other_timings import ANNO, EXB, FACEPOSER, FRAMES, MARY, NUMBERS, TRS, UST, YOUTUBE_OLD

from phonanim.errors import AlignmentError
from phonanim.readers import find_reader, load_reader, read_recording
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


LABELLED = {"label": "M", "start": 0.1, "end": 0.5}


@pytest.mark.parametrize(
    "content",
    [
        {"a": [{"b": 0}] * 300_001},
        {"a": [json.dumps([{"b": 0}] * 100_001)] * 3},
    ],
)
def test_json_of_too_many_tables_is_refused(content: Any) -> None:
    with pytest.raises(AlignmentError, match=r"has damaged times \(it has more than 300,000 tables\)"):
        load_reader("any_json").read(AlignmentFile("x", "x", json.dumps(content).encode()))


@pytest.mark.parametrize(
    "content",
    [
        {f"{n}": {**LABELLED, "start": n} for n in range(4_000)}
        | {f"u{n}": {"label": "a"} for n in range(4_000)},
        {f"{n}": ["a"] if n % 2 else [0.1] for n in range(4_000)},
        {"phones": [{"phone": "M", "start": 0.0} for _ in range(4_000)]},
    ],
    ids=["places", "lists side by side", "labels that start at once"],
)
def test_the_work_grows_with_the_size_of_json_alone(content: Any) -> None:
    calls = 0

    def count(frame: Any, event: str, argument: Any) -> None:
        nonlocal calls
        calls += 1

    sys.setprofile(count)
    try:
        with contextlib.suppress(AlignmentError):
            load_reader("any_json").read(AlignmentFile("x", "x", json.dumps(content).encode()))
    finally:
        sys.setprofile(None)
    assert calls < 4_000 * 1000


def test_lists_side_by_side_of_a_table_with_many_other_names() -> None:
    content = {f"n{n}": n for n in range(150)} | {
        "phones": ["M", "AA"],
        "start": [0.1, 0.2],
        "end": [0.2, 0.5],
    }
    assert spans(read(content)) == [("M", 0.1, 0.2), ("AA", 0.2, 0.5)]


@pytest.mark.parametrize(
    "text",
    [
        f"1\n00:00:00,000 --> 01:00:00,000\n{'a ' * 200_001}\n",
        "".join(f"{n}\n00:00:{n:02},000 --> 00:00:{n:02},900\n{'a ' * 50_000}\n\n" for n in range(5)),
        json.dumps([{"text": "a " * 200_001, "start": 0, "end": 5000}]),
    ],
)
def test_more_words_than_a_recording_has(text: str) -> None:
    with pytest.raises(AlignmentError, match=r"x: has more than 200,000 words; split the recording"):
        read_recording(AlignmentFile("x", "x", text.encode()))


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
