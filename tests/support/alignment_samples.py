"""One utterance, "beam", as each program writes it: files that reproduce the quirks of their formats."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass

from textgrid_text import BEAM, WORDS, long_text, short_text

Spans = tuple[tuple[str, float, float], ...]

PHONES: Spans = tuple((label, float(start), float(end)) for start, end, label in BEAM)
SPOKEN: Spans = PHONES[1:4]
WORD: Spans = (("beam", 0.2, 0.6),)


@dataclass(frozen=True)
class Sample:
    """A file and what is in it: phones, words that are not silence, and what must be noted."""

    data: bytes
    phones: Spans
    words: Spans = ()
    notes: int = 0
    name: str = "x"


def text(content: str, phones: Spans, words: Spans = (), notes: int = 0, name: str = "x") -> Sample:
    return Sample(content.encode(), phones, words, notes, name)


def dumped(content: object, phones: Spans, words: Spans = (), notes: int = 0) -> Sample:
    return text(json.dumps(content), phones, words, notes, "x.json")


def praat_binary(wide: bool) -> bytes:
    def short(string: str) -> bytes:
        return struct.pack(">B", len(string)) + string.encode()

    def label(string: str) -> bytes:
        if wide:
            return struct.pack(">HH", 0xFFFF, len(string)) + string.encode("utf-16-be")
        return struct.pack(">H", len(string)) + string.encode()

    def intervals(name: str, entries: list) -> bytes:
        head = short("IntervalTier") + label(name) + struct.pack(">ddi", 0, 1, len(entries))
        return head + b"".join(struct.pack(">dd", start, end) + label(x) for start, end, x in entries)

    points = short("TextTier") + label("phones") + struct.pack(">ddid", 0, 1, 1, 0.5) + label("H*")
    head = b"ooBinaryFile" + short("TextGrid") + struct.pack(">ddBi", 0, 1, 1, 3)
    return head + points + intervals("words", WORDS) + intervals("phones", BEAM)


def emu(bundle: bool) -> dict:
    items = [(0, 1999, ""), (2000, 1000, "b"), (3000, 1999, "i:"), (5000, 999, "m"), (6000, 4000, "")]
    segments = [
        {"id": n, "sampleStart": start, "sampleDur": length, "labels": [{"name": "Phones", "value": label}]}
        for n, (start, length, label) in enumerate(items)
    ]
    segments[0]["labels"] = []
    levels = [
        {"name": "Word", "type": "ITEM", "items": [{"id": 9, "labels": []}]},
        {"name": "Phonetic", "type": "SEGMENT", "items": segments},
    ]
    annotation = {"name": "x", "annotates": "x.wav", "sampleRate": 10000, "levels": levels, "links": []}
    return {"ssffFiles": [], "annotation": annotation} if bundle else annotation


HTK = """0 2000000 sil -312.5 SENT-START
2000000 3000000 b -12.5 beam
3000000 5000000 iy -11.5
5000000 6000000 m -12
6000000 10000000 sil -900 SENT-END
"""

HTK_WORDS: Spans = (*WORD, ("SENT-END", 0.6, 1.0))

HTS = """0 2000000 xx^xx-sil+m=i/A:xx+xx+xx/B:xx-xx_xx
2000000 2500000 xx^sil-b+i:=m/A:-2+1+3/B:xx-xx_xx[2]
2500000 3000000 xx^sil-b+i:=m/A:-2+1+3/B:xx-xx_xx[3]
3000000 5000000 sil^b-i:+m=pau/A:-2+1+3
5000000 6000000 b^i:-m+pau=xx/A:-2+1+3
6000000 10000000 i:^m-pau+xx=xx/A:xx
"""

TIMIT = "0 3200 h#\n3200 3800 bcl\n3800 4800 b\n4800 8000 iy\n8000 9600 m\n9600 16000 h#\n"

XWAVES = """signal x
type 0
color 122
comment created using xlabel
separator ;
nfields 1
#
    0.200000  122 {B_TRANS}
    0.300000  122 b; remark
    0.500000  122 iy
    0.600000  122 m
    1.000000  122 SIL
"""

CTM = """;; comment
x 1 0.00 0.20 sil 1.00
x 1 0.20 0.10 B_B 0.98
x 1 0.30 0.19 IY1_I 0.7
x 1 0.50 0.10 M_E
x 1 0.60 0.40 sil
"""

BAS = """LHD: Partitur 1.3.2
SAM: 10000
LBD:
ORT: 0 beam
KAN: 0 bi:m
MAU: 0 1999 -1 <p:>
MAU: 2000 999 0 b
MAU: 3000 1999 0 i:
MAU: 5000 999 0 m
MAU: 6000 3999 -1 <p:>
"""

ELAN = """<?xml version="1.0" encoding="UTF-8"?>
<ANNOTATION_DOCUMENT AUTHOR="" FORMAT="3.0">
<HEADER MEDIA_FILE="" TIME_UNITS="milliseconds"/>
<TIME_ORDER>
<TIME_SLOT TIME_SLOT_ID="ts1" TIME_VALUE="200"/>
<TIME_SLOT TIME_SLOT_ID="ts2"/>
<TIME_SLOT TIME_SLOT_ID="ts3"/>
<TIME_SLOT TIME_SLOT_ID="ts4" TIME_VALUE="500"/>
<TIME_SLOT TIME_SLOT_ID="ts5" TIME_VALUE="600"/>
</TIME_ORDER>
<TIER TIER_ID="words" PARTICIPANT="Mary" LINGUISTIC_TYPE_REF="t">
<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a1" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts5">
<ANNOTATION_VALUE>beam</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION></TIER>
%s
</ANNOTATION_DOCUMENT>"""

ELAN_TIMED = """<TIER TIER_ID="phones" PARTICIPANT="Mary" LINGUISTIC_TYPE_REF="t">
<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a3" TIME_SLOT_REF1="ts4" TIME_SLOT_REF2="ts5">
<ANNOTATION_VALUE>m</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION>
<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a2" TIME_SLOT_REF1="ts1" TIME_SLOT_REF2="ts2">
<ANNOTATION_VALUE>b</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION>
<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a4" TIME_SLOT_REF1="ts2" TIME_SLOT_REF2="ts4">
<ANNOTATION_VALUE>iː</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION></TIER>"""

ELAN_SHARED = """<TIER TIER_ID="phones" PARENT_REF="words" PARTICIPANT="Mary" LINGUISTIC_TYPE_REF="t">
<ANNOTATION><REF_ANNOTATION ANNOTATION_ID="a2" ANNOTATION_REF="a1">
<ANNOTATION_VALUE>b</ANNOTATION_VALUE></REF_ANNOTATION></ANNOTATION>
<ANNOTATION><REF_ANNOTATION ANNOTATION_ID="a3" ANNOTATION_REF="a1" PREVIOUS_ANNOTATION="a2">
<ANNOTATION_VALUE>iːm</ANNOTATION_VALUE></REF_ANNOTATION></ANNOTATION></TIER>"""

GENTLE = {
    "transcript": "beam me up",
    "words": [
        {
            "alignedWord": "beam",
            "case": "success",
            "start": 0.2,
            "end": 0.6,
            "word": "beam",
            "phones": [
                {"duration": 0.1, "phone": "b_B"},
                {"duration": 0.2, "phone": "iy_I"},
                {"duration": 0.1, "phone": "m_E"},
            ],
        },
        {"case": "not-found-in-audio", "word": "me"},
    ],
}

ROWS = [(start, end, label) for label, start, end in PHONES]
MFA_TIERS = {
    "start": 0,
    "end": 1,
    "tiers": {
        "words": {"type": "interval", "entries": [[0.2, 0.6, "beam"]]},
        "phones": {"type": "interval", "entries": ROWS},
        "tones": {"type": "point", "entries": [[0.4, "H*"]]},
    },
}
PRAATIO_TIERS = {
    "xmin": 0,
    "xmax": 1,
    "tiers": [{"class": "IntervalTier", "name": "phones", "xmin": 0, "xmax": 1, "entries": ROWS}],
}

MFA_CSV = "Begin,End,Label,Type,Speaker\n0.2,0.6,beam,words,Mary\n" + "".join(
    f"{start},{end},{label},phones,Mary\n" for start, end, label in reversed(ROWS[1:4])
)

CUES: Spans = (("X", 0.0, 0.2), ("A", 0.2, 0.3), ("B", 0.3, 0.5), ("A", 0.5, 0.6), ("X", 0.6, 1.0))
RHUBARB_JSON = {
    "metadata": {"soundFile": "x.wav", "duration": 1.0},
    "mouthCues": [{"start": start, "end": end, "value": shape} for shape, start, end in CUES],
}
RHUBARB_XML = (
    '<?xml version="1.0" encoding="utf-8"?>\n<rhubarbResult><metadata><duration>1.00</duration></metadata>\n'
    "<mouthCues>"
    + "".join(f'<mouthCue start="{start}" end="{end}">{shape}</mouthCue>' for shape, start, end in CUES)
    + "</mouthCues></rhubarbResult>"
)
RHUBARB_TSV = "".join(f"{start:.2f}\t{shape}\n" for shape, start, _ in CUES)

MOHO = "MohoSwitch1\n1 rest\n7 MBP\n13 E\n19 MBP\n25 rest\n"

PAPAGAYO = """lipsync version 1
x.wav
24
48
1
\tMary
\t
\t1
\t\tbeam
\t\t6
\t\t23
\t\t1
\t\t\tbeam 6 23 3
\t\t\t\t6 MBP
\t\t\t\t12 E
\t\t\t\t18 MBP
"""


def labelled(*labels: str) -> Spans:
    """The times of the sample with the labels of another alphabet."""
    return tuple((label, start, end) for label, (_, start, end) in zip(labels, PHONES, strict=True))


SAMPLES: dict[str, list[Sample]] = {
    "textgrid": [
        text(long_text([("words", WORDS), ("phones", BEAM)]), PHONES, WORD),
        text(short_text([("words", WORDS), ("phones", BEAM)]), PHONES, WORD),
        Sample(b"\xff\xfe" + short_text([("phones", BEAM)]).encode("utf-16-le"), PHONES),
    ],
    "praat_binary": [Sample(praat_binary(wide), PHONES, WORD) for wide in (False, True)],
    "emu": [dumped(emu(bundle), labelled("", "b", "i:", "m", "")) for bundle in (True, False)],
    "htk": [
        text(HTK, labelled("sil", "b", "iy", "m", "sil"), HTK_WORDS),
        text(HTS, labelled("sil", "b", "i:", "m", "pau")),
        text(f'#!MLF!#\n"*/x.lab"\n{HTK}.\n', labelled("sil", "b", "iy", "m", "sil"), HTK_WORDS),
    ],
    "timit": [
        text(
            TIMIT,
            (
                ("h#", 0.0, 0.2),
                ("bcl", 0.2, 0.2375),
                ("b", 0.2375, 0.3),
                *labelled("", "", "iy", "m", "h#")[2:],
            ),
            name="x.PHN",
        )
    ],
    "seconds": [
        text("".join(f"{s:.6f}\t{e:.6f}\t{x}\n" for x, s, e in PHONES), PHONES),
        text(
            "0.0 0.2 silB\n0.2 0.3 b\n0.3 0.5 i:\n0.5 0.6 m\n0.6 1.0 silE\n",
            labelled("silB", "b", "i:", "m", "silE"),
        ),
    ],
    "xwaves": [text(XWAVES, labelled("{B_TRANS}", "b", "iy", "m", "SIL"))],
    "ctm": [text(CTM, labelled("sil", "B", "IY1", "M", "sil"))],
    "bas": [text(BAS, labelled("<p:>", "b", "i:", "m", "<p:>"), WORD)],
    "elan": [
        text(ELAN % ELAN_TIMED, (("b", 0.2, 0.3), ("iː", 0.3, 0.5), ("m", 0.5, 0.6)), WORD),
        text(ELAN % ELAN_SHARED.replace("iːm", "m"), (("b", 0.2, 0.4), ("m", 0.4, 0.6)), WORD),
    ],
    "gentle": [dumped(GENTLE, (("b_B", 0.2, 0.3), ("iy_I", 0.3, 0.5), ("m_E", 0.5, 0.6)), WORD, notes=1)],
    "tiers_json": [dumped(MFA_TIERS, PHONES, WORD), dumped(PRAATIO_TIERS, PHONES)],
    "mfa_csv": [text(MFA_CSV, SPOKEN, WORD)],
    "rhubarb": [
        dumped(RHUBARB_JSON, CUES, notes=1),
        text(RHUBARB_XML, CUES, notes=1),
        text(RHUBARB_TSV, (*CUES[:-1], ("X", 0.6, 0.7)), notes=1),
    ],
    "moho": [
        text(
            MOHO,
            (
                ("rest", 0, 0.25),
                ("MBP", 0.25, 0.5),
                ("E", 0.5, 0.75),
                ("MBP", 0.75, 1),
                ("rest", 1, 1 + 1 / 24),
            ),
            notes=2,
        )
    ],
    "papagayo": [
        text(
            PAPAGAYO,
            (("MBP", 0.25, 0.5), ("E", 0.5, 0.75), ("MBP", 0.75, 1), ("rest", 1, 1 + 1 / 24)),
            (("beam", 0.25, 1.0),),
            notes=1,
        )
    ],
}
"""By reader. `words_json` has words alone: see WORD_LISTS."""

WHISPERX = {
    "segments": [
        {
            "start": 0.2,
            "end": 1,
            "text": "beam 2",
            "words": [{"word": "beam", "start": 0.2, "end": 0.6}, {"word": "2"}],
        }
    ],
    "word_segments": [],
    "language": "en",
}
VOSK = {"result": [{"conf": 1.0, "start": 0.2, "end": 0.6, "word": "beam"}], "text": "beam"}
WORD_LISTS = [
    dumped(WHISPERX, (), WORD, notes=1),
    dumped(VOSK, (), WORD),
    dumped([VOSK, {"text": ""}], (), WORD),
]
