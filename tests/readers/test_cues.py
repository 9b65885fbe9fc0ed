"""Subtitles, lyrics and the answers of speech services: what is special in each."""

from __future__ import annotations

import json

import pytest
from timing_samples import ASSEMBLYAI, LRC, TTML

from phonanim.errors import AlignmentError
from phonanim.readers import find_reader, load_reader
from phonanim.readers._services import layouts
from phonanim.speech.alignment import Recording
from phonanim.speech.alignment_file import AlignmentFile


def read(content: object) -> Recording:
    text = content if isinstance(content, str) else json.dumps(content)
    source = AlignmentFile("x", "x", text.encode())
    return find_reader(source).read(source)


def words(content: object) -> list[tuple[str, float, float]]:
    return [
        (one.label, round(one.start, 3), round(one.end, 3))
        for tier in read(content).tiers
        for one in tier.intervals
    ]


LIVE = """WEBVTT
Kind: captions
Language: en

00:00:00.160 --> 00:00:02.070 align:start position:0%

my<00:00:00.480><c> puppy</c><00:00:00.880><c> broke</c>

00:00:02.070 --> 00:00:02.080 align:start position:0%
my puppy broke


00:00:02.080 --> 00:00:04.000 align:start position:0%
my puppy broke
two<00:00:02.500><c> tubes</c>
"""


def test_captions_that_roll_up_are_read_once() -> None:
    found = read(LIVE)
    assert [one.label for one in found.tiers[0].intervals] == ["my", "puppy", "broke", "two", "tubes"]
    assert [one.start for one in found.tiers[0].intervals] == [0.16, 0.48, 0.88, 2.08, 2.5]
    assert found.spoken == "en"
    assert found.notes == ("a line that a cue repeats from the one before it is read once",)


def test_a_line_that_is_said_twice_is_no_repeated_caption() -> None:
    text = "1\n00:00:01,000 --> 00:00:02,000\nNo!\n\n2\n00:00:02,000 --> 00:00:03,000\nNo!\n"
    assert words(text) == [("No!", 1.0, 2.0), ("No!", 2.0, 3.0)]


def test_cues_are_put_in_order_and_overlaps_are_cut() -> None:
    late = "2\n00:00:02,000 --> 00:00:03,000\ntwo\n\n"
    early = "1\n00:00:00,300 --> 00:00:02,500\nPuppy\n"
    found = read(late + early)
    assert words(late + early) == [("Puppy", 0.3, 2.0), ("two", 2.0, 3.0)]
    assert found.notes == ("lines overlap: each ends where the next one begins",)


def test_two_cues_at_one_time_are_said_one_after_the_other() -> None:
    cues = "1\n00:00:00,000 --> 00:00:01,000\n- Me\n\n2\n00:00:00,000 --> 00:00:01,000\n- It\n"
    assert words(cues) == [("Me", 0.0, 0.5), ("It", 0.5, 1.0)]


def events(*lines: str) -> str:
    head = "Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text"
    return "\n".join(("[Events]", head, *(f"Dialogue: 0,{line}" for line in lines)))


def test_karaoke_marks_time_syllables() -> None:
    line = r"0:00:01.00,0:00:03.00,D,,0,0,0,,{\k20}My {\kf22\fs20}pup{\K18}py, {\k40}broke"
    assert words(events(line)) == [("My", 1.0, 1.2), ("puppy,", 1.2, 1.6), ("broke", 1.6, 2.0)]


def test_subtitles_without_karaoke_and_drawings() -> None:
    drawn = r"0:00:00.00,0:00:03.00,D,,0,0,0,,{\p1}m 0 0 l 100 0"
    said = r"0:00:01.00,0:00:02.00,D,Mary,0,0,0,,{\an8}Me\Nit"
    assert words(events(drawn, said)) == [("Me", 1.0, 1.5), ("it", 1.5, 2.0)]
    both = read(events(said, said.replace("Mary", "").replace(":01.", ":03.").replace(":02.", ":04.")))
    assert [tier.speaker for tier in both.tiers] == ["Mary", "unnamed"]


def test_lyrics_end_with_the_next_line_or_after_a_second_a_word() -> None:
    song = "[ar:X]\n[00:01.00][00:30.00]me it\n[00:02.00]\n[00:10.5]me\n"
    assert words(song) == [
        *(("me", 1.0, 1.5), ("it", 1.5, 2.0)),
        ("me", 10.5, 11.5),
        *(("me", 30.0, 31.0), ("it", 31.0, 32.0)),
    ]


def test_the_offset_of_lyrics_shows_them_earlier() -> None:
    found = read(LRC.replace("offset:0", "offset:+100"))
    assert found.tiers[0].intervals[0].start == pytest.approx(0.1)
    assert found.notes == ("times are 100 ms earlier, as the offset of the file says",)


@pytest.mark.parametrize(
    ("times", "start", "end"),
    [
        ('begin="00:00:01:15" end="2s"', 1.5, 2.0),
        ('begin="10t" end="30t"', 0.5, 1.5),
        ('begin="1500ms" dur="0.5s"', 1.5, 2.0),
    ],
)
def test_units_of_timed_text(times: str, start: float, end: float) -> None:
    text = TTML.replace('begin="00:00:00.100" dur="400ms"', times).replace(' begin="0.1s"', "")
    rates = 'xmlns:ttp="http://www.w3.org/ns/ttml#parameter" ttp:frameRate="30" ttp:tickRate="20" xml:lang'
    assert words(text.replace("xml:lang", rates)) == [("beam", start, end)]


def test_spans_of_timed_text_time_words() -> None:
    spans = '<span begin="0s" end="0.1s">me</span> <span begin="0.1s" end="0.3s">it</span>'
    assert words(TTML.replace("beam</p>", f"{spans}</p>")) == [("me", 0.2, 0.3), ("it", 0.3, 0.5)]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        (
            "substation",
            "[Events]\nDialogue: 0,0:00:01.00\n",
            r"has a damaged line of dialogue \(.*\); save it",
        ),
        ("ttml", TTML.replace("400ms", "oops"), r"is damaged timed text \('oops' is not a time\); save it"),
        ("ttml", TTML.replace(' dur="400ms"', ""), r"the paragraph at 0.2 s has no end"),
        ("services", json.dumps(ASSEMBLYAI).replace('"words"', '"x"'), ""),
        (
            "services",
            '{"durations": [{"text": "a", "start": "x", "duration": 1}]}',
            r"has a damaged entry \(.*\); save",
        ),
    ],
)
def test_damage_is_told(name: str, text: str, message: str) -> None:
    source = AlignmentFile("x", "x", text.encode())
    reader = load_reader(name)
    if not message:
        assert not reader.recognizes(source)
        return
    assert reader.recognizes(source)
    with pytest.raises(AlignmentError, match=rf"x: .*{message}"):
        reader.read(source)


def test_each_layout_of_the_table_has_a_time_to_end_at() -> None:
    for layout in layouts():
        ends = bool(layout.end) + bool(layout.duration) + layout.pairs
        assert ends == 1 or (bool(layout.base) and not ends)
        assert layout.gives in ("words", "phones", "pieces", "lines")


def test_whole_seconds_are_no_milliseconds() -> None:
    assert words({"words": [{"text": "me", "start": 1, "end": 2}, {"text": "it", "start": 2, "end": 3}]}) == [
        ("me", 1.0, 2.0),
        ("it", 2.0, 3.0),
    ]


def test_a_duration_ends_a_word() -> None:
    assert words(
        [{"word": "me", "start": 0.3, "duration": 0.2}, {"word": "it", "start": 0.9, "end": 1.2}]
    ) == [
        ("me", 0.3, 0.5),
        ("it", 0.9, 1.2),
    ]


def test_speakers_that_are_numbers() -> None:
    content = [{"word": "me", "start": 0, "end": 1, "speaker": n} for n in (0, 1)]
    assert [tier.speaker for tier in read(content).tiers] == ["0", "1"]


def test_a_note_names_the_languages_of_sami_that_are_not_read():
    found = read(
        "<SAMI><!-- .A {lang: en-US;} .B {lang: fr-FR;} --><BODY><SYNC Start=0><P Class=A>hello"
        "<SYNC Start=0><P Class=B>bonjour<SYNC Start=900><P Class=A>&nbsp;</BODY></SAMI>"
    )
    assert found.notes == ("lines of A are read, those of B are not",)
    assert [one.label for one in found.tiers[0].intervals] == ["hello"]
