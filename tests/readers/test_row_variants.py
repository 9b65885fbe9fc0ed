"""Rows, subtitles and XML as programs really save them: columns, alternatives, marked words, speakers."""

from __future__ import annotations

from itertools import chain
from pathlib import Path

import pytest

from phonanim.errors import AlignmentError
from phonanim.inputs.alignment import read_alignment
from phonanim.readers import find_reader
from phonanim.speech.alignment_file import AlignmentFile
from phonanim.speech.intervals import Recording

WORDS = [("maybe", 0.2, 0.5), ("Bobby", 0.5, 1.0)]
PHONES = [("b", 0.2, 0.3), ("iy", 0.3, 0.5), ("m", 0.5, 0.6)]
TICKS = [(0, 2_000_000), (2_000_000, 3_000_000), (3_000_000, 5_000_000), (5_000_000, 6_000_000)]


def read(content: str) -> Recording:
    source = AlignmentFile("x", "x", content.encode())
    return find_reader(source).read(source)


def spans(recording: Recording, *names: str) -> list[tuple[str, float, float]]:
    tiers = [tier for tier in recording.tiers if tier.name in names] or [recording.tiers[0]]
    found = chain.from_iterable(tier.intervals for tier in tiers)
    silent = ("", "sil", "SIL", "<s>", "</s>", "pau", "AP", "SENT-START")
    return [(one.label, round(one.start, 3), round(one.end, 3)) for one in found if one.label not in silent]


SEGMENTS = "  SFrm  EFrm    SegAScr {}\n     0    19    -1177 {}\n{}Total score:   -5000\n"
TRACE = "INFO: x\nword   start end  pprob  ascr  lscr  lback\n<s>  0  19  1.0  -1  0  1\n"
ASS = (
    "[Script Info]\n\n[Events]\n"
    "Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text\n"
    "Dialogue: 0,0:00:00.20,0:00:00.50,D,,0,0,0,,%s\nDialogue: 0,0:00:00.50,0:00:01.00,D,,0,0,0,,%s\n"
)
SRT = "1\n00:00:00,200 --> 00:00:00,500\n%s\n\n2\n00:00:00,500 --> 00:00:01,000\n%s\n"
APPLE = (
    '<tt xmlns="http://www.w3.org/ns/ttml" xmlns:a="http://music.apple.com/lyric-ttml-internal" {}>'
    '<body dur="1.0"><div begin="0.2" end="1.0"><p begin="0.2" end="1.0">'
    '<span begin="0.2" end="0.5">maybe</span> <span begin="0.5" end="1.0">Bobby</span></p></div></body></tt>'
)
LATE = (
    '<tt xmlns="http://www.w3.org/ns/ttml"><body><div><p begin="00:10.200" end="00:11.000">'
    '<span begin="00:10.200">maybe</span> <span begin="00:10.500">Bobby</span></p></div></body></tt>'
)


@pytest.mark.parametrize(
    "content",
    [
        "u 1 2e-01 3e-01 maybe 1\nu 1 0.5 0.5 Bobby 1\n",
        "u A * * <ALT_BEGIN>\nu A 0.2 0.3 maybe\nu A * * <ALT>\n"
        "u A 0.2 0.3 mine\nu A * * <ALT_END>\nu A 0.5 0.5 Bobby\n",
        'f000001,0.200,0.500,"maybe"\nf000002,0.500,1.000,"Bobby"\n',
        'f000001 0.200 0.500 "maybe"\nf000002 0.500 1.000 "Bobby"\n',
        "maybe,maybe,0.2,0.5\nBobby,bobby,0.5,1.0\n",
        "maybe Bobby\n<s> 0.000 0.200 0.9\nmaybe(2) 0.200 0.500 0.9\nBobby 0.500 1.000 0.8\n",
        SEGMENTS.format("Word", "<s>", "    20    49   -10 maybe\n    50    99   -10 Bobby(2)\n"),
        TRACE + "maybe  20  49  0.9 -200 -100 1\nBobby(2) 50 99 0.9 -200 -100 1\nINFO: y\n",
        "# made by x\nstart_ms\tend_ms\tword\n200\t500\tmaybe\n500\t1000\tBobby\n",
        "[00:00.200 --> 00:00.500]  maybe\n[00:00.500 --> 00:01.000]  Bobby\n",
        SRT % ("<u>maybe</u> Bobby", "maybe <u>Bobby</u>"),
        SRT % ('<font color="#00ff00">maybe</font> Bobby', 'maybe <font color="#00ff00">Bobby</font>'),
        (SRT % ("maybe", "Bobby")).replace("\n\n", "\n"),
        SRT % ("JOHN: maybe", "JOHN: Bobby"),
        SRT % ("maybe", "JOHN: Bobby"),
        SRT % ("[SPEAKER_00]: maybe", "[SPEAKER_00]: Bobby"),
        SRT % ("[speaker 0]\nmaybe", "[speaker 0]\nBobby"),
        ASS % ("{\\1c&HFF00&}maybe{\\r} Bobby", "maybe {\\1c&HFF00&}Bobby{\\r}"),
        ASS % ("{\\c&H3d&}maybe{\\c&H00&} {\\c&Hc7&}Bobby", "{\\c&H00&}maybe {\\c&H3d&}Bobby"),
        APPLE.format('a:timing="Word"'),
        "u 1 0.20 0.04 m NA lex NA\nu 1 0.30 0.20 aybe NA lex NA\n"
        "u 1 0.5 0.0 <space> NA\nu 1 0.50 0.5 Bobby NA lex\n",
    ],
)  # fmt: skip
def test_words(content: str) -> None:
    assert spans(read(content), "words", "labels") == WORDS


@pytest.mark.parametrize(
    "content",
    [
        "u 1 0.20 0.80 maybe<space>Bobby NA lex NA\n",
        '"maybe Bobby",0.2,1.0\n',
        "0.2\t1.0\t[SPEAKER_00]: maybe Bobby\n",
        SRT % ("<i>maybe</i> Bobby", "") ,
        "default\t\t00:00:00.200\t0.2\t00:00:01.000\t1.0\t00:00:00.800\t0.8\tmaybe Bobby\n",
    ],
)  # fmt: skip
def test_lines_of_text_share_their_time(content: str) -> None:
    found = spans(read(content))
    assert [label for label, *_ in found] == ["maybe", "Bobby"]
    assert found[0][1] == 0.2
    assert found[0][2] == found[1][1]


@pytest.mark.parametrize(
    "content",
    [
        '#!MLF!#\n"*/x.rec"\n'
        + "".join(
            f"{start} {end} s2 -7.2 {label} -200.1{word}\n{end} {end + 50} s3 -70.2\n".replace(
                f"{end} {end + 50}", f"{end} {end}"
            )
            for (start, end), label, word in zip(
                TICKS, ("sil", "b", "iy", "m"), (" SENT-START", " BEAM", "", ""), strict=True
            )
        )
        + ".\n",
        '#!MLF!#\n"*/x.lab"\n'
        + "".join(
            f"{start} {end} {label}[2] -7.2 {label}{word}\n"
            for (start, end), label, word in zip(
                TICKS, ("sil", "b", "iy", "m"), (" SENT-START", " BEAM", "", ""), strict=True
            )
        )
        + ".\n",
        SEGMENTS.format("Phone", "SIL", "20 29 -10 b SIL iy b\n30 49 -10 iy b m i\n50 59 -10 m iy SIL e\n"),
        "name,ph_seq,ph_dur\nu,AP b iy m,0.2 0.1 0.2 0.1\n",
        "2001|beam|AP b iy m|rest C4 C4 C4|0.2 0.1 0.2 0.1|0.2 0.1 0.2 0.1|0 0 0 0\n",
        "".join(
            f"phones\t\t00:00:00.{start * 1000:03.0f}\t{start}\t00:00:00.{end * 1000:03.0f}\t{end}\t{label}\n"
            for label, start, end in PHONES
        ),
        "Tier\tBegin Time - hh:mm:ss.ms\tBegin Time - ss.msec\tEnd Time - ss.msec\tAnnotation\n"
        + "".join(f"phones\t00:00:00.{s * 1000:03.0f}\t{s}\t{e}\t{x}\n" for x, s, e in PHONES),
        'File type = "ooTextFile"\nObject class = "IntervalTier"\n\n0\n0.6\n4\n0 0.2 ""\n'
        + "".join(f'{start} {end} "{label}"\n' for label, start, end in PHONES),
        'File type = "ooTextFile"\nObject class = "Collection"\n\nsize = 2\n'
        '"TextGrid 8" "x" 0 0.6 <exists> 1\n'
        '"IntervalTier" "phones" 0 0.6 4\n0 0.2 ""\n'
        + "".join(f'{start} {end} "{label}"\n' for label, start, end in PHONES)
        + '"Sound 2" "x" 0 0.6\n',
        '<?xml version="1.0"?><Document name="x" xra="1"><Tier tiername="PhonAlign">'
        + "".join(
            f'<Annotation><Location><TimeInterval><Begin midpoint="{s}"/><End midpoint="{e}"/></TimeInterval>'
            f"</Location><Label><Text>{x}</Text></Label></Annotation>"
            for x, s, e in PHONES
        )
        + "</Tier></Document>",
    ],
)
def test_phones(content: str) -> None:
    assert spans(read(content), "phones", "labels") == PHONES


def test_spans_of_subtitles_that_count_from_the_file() -> None:
    assert spans(read(LATE)) == [("maybe", 10.2, 10.5), ("Bobby", 10.5, 11.0)]


def test_several_speakers_of_subtitles() -> None:
    recording = read(SRT % ("JOHN: maybe", "MARY: Bobby"))
    assert [tier.speaker for tier in recording.tiers] == ["JOHN", "MARY"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("u 1 0.000 0.200 1\nu 1 0.200 0.100 45\n", r"has numbers for its labels; replace them by"),
        ('<?xml version="1.0"?><fcpxml version="1.9">', r"is a timeline in XML, which places clips"),
        ("TITLE: x\nFCM: NON-DROP FRAME\n", r"is an edit list \(EDL\), which places clips, not"),
        ("SESSION NAME:\tx\nSAMPLE RATE:\t48000\n", r"is a session of Pro Tools, which places clips"),
        ("EST_File utterance\n1 id _1 ; name b ;\n", r"has no segments with end times; save it after"),
        ("EST_File utterance\n1 id _1 ; end x ;\nRelation Segment ; ()\n1 1 0 0 0 0\n", r"has a damaged end"),
        ("#BPM:x\n: 0 1 2 a\n", r'has a damaged "#BPM" or "#GAP"; save it again'),
        ("#BPM:75\n: 0 1 2 a\nxyz\n", r'has a damaged row "xyz"; save it again'),
        ("@Begin\n*MAR:\tbeam .\n@End\n", r"has no times; link it to its recording in CLAN"),
        ('File type = "ooTextFile"\n"Collection"\n0\n', r"is a collection of Praat with 0 TextGrids; save"),
        (SEGMENTS.format("Word", "x y", "")[:40], r"has no segments; align again"),
        ("name,ph_seq,ph_dur\nu,a b,0.1\n", r"has a damaged line \(2 phonemes and 1 durations\); export it"),
    ],
)  # fmt: skip
def test_messages(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "x"
    path.write_text(content)
    with pytest.raises(AlignmentError, match=message):
        read_alignment(path)
