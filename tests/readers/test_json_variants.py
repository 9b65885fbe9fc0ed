"""JSON as programs really save it: streams, results that are not final, other names, frames, encodings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment
from phonanim.readers import find_reader
from phonanim.speech.alignment_file import AlignmentFile
from phonanim.speech.intervals import Recording
from phonanim.speech.json_values import parse_stream

BEAM = [("beam", 0.2, 0.6)]
IPA = [("b", 0.2, 0.3), ("iː", 0.3, 0.5), ("m", 0.5, 0.6)]
EVENTS = [(0.2, 21), (0.3, 6), (0.5, 21), (0.6, 0)]
SHAPES = [("p", 0.2, 0.3), ("iy", 0.3, 0.5), ("p", 0.5, 0.6)]


def read(content: Any) -> Recording:
    data = content if isinstance(content, bytes) else _text(content).encode()
    source = AlignmentFile("x", "x", data)
    return find_reader(source).read(source)


def _text(content: Any) -> str:
    return content if isinstance(content, str) else json.dumps(content)


def spans(recording: Recording) -> list[tuple[str, float, float]]:
    tier = next((one for one in recording.tiers if one.name in ("phones", "labels")), recording.tiers[0])
    return [
        (one.label, round(one.start, 3), round(one.end, 3))
        for one in tier.intervals
        if one.label not in ("", "sil", "pau")
    ]


def lines(*values: Any) -> str:
    return "\n".join(map(json.dumps, values))


def word(text: str = "beam", unit: int = 1, **more: Any) -> dict[str, Any]:
    return {"start": 0.2 * unit, "end": 0.6 * unit, **more, "word": text}


DEEPGRAM = {"type": "Results", "is_final": True, "channel": {"alternatives": [{"words": [word()]}]}}
EARLIER = {"type": "Results", "is_final": False, "channel": {"alternatives": [{"words": [word("bee")]}]}}
TURN = {"type": "Turn", "turn_order": 0, "end_of_turn": True}
SPOKEN = {"text": "beam", "start": 200, "end": 600}
SPEECHMATICS = {"type": "word", "start_time": 0.2, "end_time": 0.6, "alternatives": [{"content": "beam"}]}
AMAZON = {"Type": "pronunciation", "Content": "beam", "StartTime": 0.2, "EndTime": 0.6}
REV = {"type": "text", "value": "beam", "ts": 0.2, "end_ts": 0.6}
MORA = {"text": "ブ", "consonant": "b", "consonantLength": 0.1, "vowel": "u", "vowelLength": 0.2}
SUNG = [{"phoneme": "b", "frame_length": 15}, {"phoneme": "u", "frame_length": 30}]
PARTS = [{"phoneme": "u", "wavRange": {"start": 0, "end": 4410}}]
MILLISECONDS = [{"ipa_label": p, "start_ms": s * 1000, "end_ms": e * 1000} for p, s, e in IPA]
TIMES = [200, 300, 400, 500]
MORAS = [{"moras": [MORA]}]
PROJECT = {"audioKeys": ["a"], "audioItems": {"a": {"text": "ブ", "query": {"accentPhrases": MORAS}}}}


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ([{"privAudioOffset": round(time * 1e7), "privVisemeId": n} for time, n in EVENTS], SHAPES),
        ([{"audio_offset": time * 1000, "viseme_id": n} for time, n in EVENTS], SHAPES),
        ([{"time": time, "visemeId": n} for time, n in EVENTS], SHAPES),
        ("".join(f"Viseme event: audio offset: {t * 1000}ms, viseme id: {n}.\n" for t, n in EVENTS), SHAPES),
        ("offset_ms,viseme_id\n" + "".join(f"{t * 1000},{n}\n" for t, n in EVENTS), SHAPES),
        ({"privPronJson": {"Words": [{"Word": "beam", "Offset": 2_000_000, "Duration": 4_000_000}]}}, BEAM),
        ({"chars": list("beam"), "charStartTimesMs": TIMES, "charsDurationsMs": [100] * 4}, BEAM),
        ([{"phoneme": p, "num_samples": round((end - start) * 22050)} for p, start, end in
          [("_", 0.0, 0.2), *IPA]], IPA),
        ({"phonemes": [{"phoneme": p, "duration": end - start} for p, start, end in [("_", 0, 0.2), *IPA]]},
         [("_", 0.0, 0.2), *IPA]),
        ({"accentPhrases": MORAS, "prePhonemeLength": 0.2}, [("b", 0.2, 0.3), ("u", 0.3, 0.5)]),
        (MORAS, [("b", 0.0, 0.1), ("u", 0.1, 0.3)]),
        ({"talk": PROJECT}, [("b", 0.0, 0.1), ("u", 0.1, 0.3)]),
        ({"f0": [], "phonemes": SUNG},
         [("b", 0.0, 0.16), ("u", 0.16, 0.48)]),
        ({"moraDurations": [{"phonemePitches": PARTS}]},
         [("u", 0.0, 0.1)]),
        ({"phoneme_ts": MILLISECONDS}, IPA),
        ({"alternatives": [{"result": [word()]}, {"result": [word("bee")]}]}, BEAM),
        ({"transcripts": [{"confidence": -9, "words": [word()]},
                          {"confidence": -12, "words": [word("bee")]}]}, BEAM),
        ({"speech_marks": {"chunks": [{"start": 0, "end": 4, "start_time": 200, "end_time": 600,
                                       "value": "beam"}]}}, BEAM),
        ([{"text": "beam", "audio_start_sec": 0.2, "duration": 0.4}], BEAM),
        ([[[0.2, 0.3, "b"], [0.3, 0.5, "iː"], [0.5, 0.6, "m"]], [[0.2, 0.6, "beam"]]], IPA),
        ({"results": {"channel_labels": {"channels": [{"items": [
            {"type": "pronunciation", "start_time": "0.2", "end_time": "0.6",
             "alternatives": [{"content": "beam"}]}]}]}}}, BEAM),
        ({"Transcript": [{"Items": [{"Content": "beam", "BeginOffsetMillis": 200,
                                     "EndOffsetMillis": 600}]}]}, BEAM),
    ],
)  # fmt: skip
def test_names_and_nesting(content: Any, expected: list[tuple[str, float, float]]) -> None:
    assert spans(read(content)) == expected


@pytest.mark.parametrize(
    "content",
    [
        lines(EARLIER, DEEPGRAM),
        lines({"type": "Turn", "turn_order": 0, "end_of_turn": False, "words": [SPOKEN]},
              {**TURN, "words": [SPOKEN]}, {**TURN, "turn_is_formatted": True, "words": [SPOKEN]}),
        lines({"message": "AddPartialTranscript", "results": [SPEECHMATICS]},
              {"message": "AddTranscript", "results": [SPEECHMATICS]}),
        lines({"Transcript": {"Results": [{"IsPartial": True, "Alternatives": [{"Items": [AMAZON]}]}]}},
              {"Transcript": {"Results": [{"IsPartial": False, "Alternatives": [{"Items": [AMAZON]}]}]}}),
        lines({"type": "partial", "elements": [REV]}, {"type": "final", "elements": [REV]}),
        lines({"type": "PARTIAL_TRANSCRIPTION", "speech": {"tokens": []}},
              {"is_final": True, "speech": {"tokens": [{"token": "beam", "start": 200, "end": 600}]}}),
        [EARLIER, DEEPGRAM],
    ],
)  # fmt: skip
def test_results_that_are_not_final_are_left_out(content: Any) -> None:
    assert spans(read(content)) == BEAM


MARKS = [
    {"time": 200, "type": "viseme", "value": "p"},
    {"time": 300, "type": "viseme", "value": "i"},
    {"time": 500, "type": "viseme", "value": "p"},
    {"time": 600, "type": "viseme", "value": "sil"},
]


@pytest.mark.parametrize(
    "content",
    [
        "".join(map(json.dumps, MARKS)),
        "\n".join(json.dumps(mark, indent=2) for mark in MARKS),
        ",\n".join(map(json.dumps, MARKS)) + ",\n",
        "[" + ",".join(map(json.dumps, MARKS)) + ",\n]",
        "".join(f"event: mark\ndata: {json.dumps(mark)}\n\n" for mark in MARKS) + "data: [DONE]\n",
        ("\ufeff" + lines(*MARKS)).replace("\n", "\r\n").encode(),
        lines(*MARKS).encode("utf-16"),
        lines(*MARKS).encode("utf-16-le"),
        lines(*MARKS).encode("utf-16-be"),
    ],
)
def test_values_one_behind_the_other(content: str | bytes) -> None:
    assert spans(read(content)) == SHAPES


@pytest.mark.parametrize("text", ['{"a": 1} x', '{"a": 1} 5', "x {}", '{"a": ' * 5000, ""])
def test_other_text_is_no_stream(text: str) -> None:
    assert parse_stream(text) == []


@pytest.mark.parametrize("encoding", ["utf-8", "cp932", "euc_jp"])
def test_japanese_encodings(encoding: str) -> None:
    text = "[#VERSION]\n[#SETTING]\nTempo=120\n[#0000]\nLength=480\nLyric=ま\n[#TRACKEND]\n"
    assert spans(read(text.encode(encoding)))[0][0] == "ま"


def test_french_in_latin_1_is_not_japanese() -> None:
    assert AlignmentFile("x", "x", "déjà vu, à côté".encode("latin-1")).text == "déjà vu, à côté"


def test_xml_in_the_encoding_that_it_declares() -> None:
    turn = '<Turn startTime="0.2" endTime="0.6">šíp</Turn>'
    text = f'<?xml version="1.0" encoding="ISO-8859-2"?><Trans><Episode>{turn}</Episode></Trans>'
    assert spans(read(text.encode("iso-8859-2")))[0][0] == "šíp"


OFFSETS = (("b", 10, 15), ("iː", 15, 25), ("m", 25, 30))
FRAMES = [
    [{"word": "beam", "start_offset": 10, "end_offset": 30},
     {"word": "bob", "start_offset": 30, "end_offset": 45}],
    [{"label": "BEAM", "start": 10, "end": 30, "score": 0.9}, {"label": "BOB", "start": 30, "end": 45}],
    [{"phoneme": p, "start_offset": s, "end_offset": e} for p, s, e in OFFSETS],
]  # fmt: skip


@pytest.mark.parametrize("content", FRAMES)
def test_frames_of_a_network_are_refused_with_their_likely_length(tmp_path: Path, content: Any) -> None:
    path = tmp_path / "x.json"
    path.write_text(json.dumps(content))
    with pytest.raises(AlignmentError, match=r"its times are likely samples@50: give --unit samples@50, or"):
        read_alignment(path)
    alignment = read_alignment(path, unit="samples@50")
    first = next(one for one in alignment.intervals if one.label)
    assert (round(first.start, 3), round(alignment.intervals[-1].end, 3)) in ((0.2, 0.9), (0.2, 0.6))


def test_letters_are_no_words() -> None:
    content = [{"token": c, "start": 10 * n, "end": 10 * n + 8} for n, c in enumerate("beamers")]
    with pytest.raises(AlignmentError, match="its labels are letters, not words or sounds"):
        read(content)
