"""The utterance "beam" in formats of games, of linguistics, and in JSON that no reader names."""

from __future__ import annotations

import json

from alignment_samples import WORD, Sample, Spans, dumped, labelled, text

IPA: Spans = (("b", 0.2, 0.3), ("iː", 0.3, 0.5), ("m", 0.5, 0.6))
ARPABET: Spans = labelled("", "b", "iy", "m", "")[1:4]
SHAPES: Spans = (("p", 0.2, 0.3), ("ih", 0.3, 0.5), ("p", 0.5, 0.6))

ANNO = """audio C:\\beam.wav
phn 0 200 0 x
word 200 600 beam
phn 200 300 90 b
phn 300 500 90 IY
phn 500 600 90 m
%%-begin-anno-text-%%
phn is a word here
%%-end-anno-text-%%
"""
PAM = "// Pamela\n[Setup]\nfps=24\n[Speech]\n0:None\n72:B\n108:IY1\n180:M\n216:None\n[Other]\n999:AA\n"
FACEPOSER = """VERSION 1.0
PLAINTEXT
{
Beam.
}
WORDS
{
WORD beam 0.200 0.600
{
98 b 0.200 0.300 1.000
105 iy 0.300 0.500 1.000
109 m 0.500 0.600 1.000
}
}
EMPHASIS
{
}
"""
MARY = """<?xml version="1.0" encoding="UTF-8"?>
<maryxml xmlns="http://mary.dfki.de/2002/MaryXML" version="0.5" xml:lang="en-US"><p><s><phrase>
<boundary breakindex="3" duration="200"/><t pos="NN">
beam
<syllable ph="b i m"><ph d="100" end="0.3" p="b"/><ph d="200" end="0.5" p="i"/><ph d="100" end="0.6" p="m"/>
</syllable></t></phrase></s></p></maryxml>"""
UST = "[#VERSION]\nUST Version1.2\n[#SETTING]\nTempo=120,00\n" + "".join(
    f"[#{n:04}]\nLength={length}\nLyric={lyric}\nNoteNum=60\n"
    for n, (length, lyric) in enumerate(((192, "R"), (96, "- b"), (192, "i"), (96, "i m")))
)
YOUTUBE_OLD = '<?xml version="1.0"?><transcript><text start="0.2" dur="0.4">beam</text></transcript>'
YOUTUBE = (
    '<?xml version="1.0"?><timedtext format="3"><body><p t="100" d="500" w="1"><s t="100">beam</s></p>'
    '<p t="600" d="10" w="1" a="1">\n</p></body></timedtext>'
)
RTTM = "SPEAKER x 1 0.2 0.4 <NA> <NA> mary <NA> <NA>\nLEXEME x 1 0.2 0.4 beam lex mary 0.9 <NA>\n"
STM = ";; LABEL\nx 1 mary 0.20 0.60 <o,f0,male> beam\n"
EXB = """<?xml version="1.0" encoding="UTF-8"?>
<basic-transcription><head/><basic-body><common-timeline><tli id="T0" time="0.2"/><tli id="T1"/>
<tli id="T2" time="0.6"/></common-timeline>
<tier id="A" speaker="S" category="v" type="t"><event start="T0" end="T2">beam </event></tier>
<tier id="B" speaker="S" category="k" type="a"><event start="T0" end="T1">loud</event></tier>
</basic-body></basic-transcription>"""
TRS = """<?xml version="1.0" encoding="ISO-8859-1"?>
<!DOCTYPE Trans SYSTEM "trans-14.dtd">
<Trans xml:lang="en"><Speakers><Speaker id="spk1" name="Mary"/></Speakers><Episode><Section startTime="0"
 endTime="1"><Turn speaker="spk1" startTime="0" endTime="0.6"><Sync time="0"/><Sync time="0.2"/>beam</Turn>
</Section></Episode></Trans>"""

PHONES_MS = {"phones": [{"label": a, "begin_ms": 1000 * s, "end_ms": 1000 * e} for a, s, e in IPA]}
FRAMES = {"fps": 10, "phonemes": [{"phoneme": a, "frame": round(10 * s)} for a, s, _ in (*IPA, ("", 0.6, 0))]}
BESIDE = {"phonemes": ["b", "iː", "m"], "starts": [0.2, 0.3, 0.5], "durations": [0.1, 0.2, 0.1]}
LISTS = {"alignment": {"phone": [[a, s, round(e - s, 3), None] for a, s, e in IPA]}}
VOSK = {
    "result": [
        {
            **{"word": "beam", "start": 0.2, "end": 0.6, "phone_label": ["b", "iː", "m"]},
            **{"phone_start": [0.2, 0.3, 0.5], "phone_end": [0.3, 0.5, 0.6]},
        }
    ]
}
TIMELINE = [
    {
        **{"type": "sentence", "text": "Beam.", "startTime": 0.1, "endTime": 0.7},
        "timeline": [
            {
                **{"type": "word", "text": "beam", "startTime": 0.2, "endTime": 0.6},
                "timeline": [{"type": "phone", "text": a, "startTime": s, "endTime": e} for a, s, e in IPA],
            }
        ],
    }
]
TIERS = {"tiers": [{"name": "phones", "items": [{"xmin": s, "xmax": e, "text": a} for a, s, e in IPA]}]}
STUDIO = [{"label": [{"start": s, "end": e, "labels": [a]} for a, s, e in IPA], "transcription": ["beam"]}]
CUES = {
    "mouthCues": [{"value": a, "start": s} for a, s in (("viseme_PP", 0.2), ("viseme_I", 0.3), ("PP", 0.5))]
    + [{"value": "viseme_sil", "start": 0.6}]
}
NUMBERS = {"visemes": [{"offset": t, "id": n} for t, n in ((200, 21), (300, 6), (500, 21), (600, 0))]}
EMBEDDED = {
    "frontend": json.dumps({"phonemes": [{"phone": a, "start_time": s, "end_time": e} for a, s, e in IPA]})
}
SPEECHACE = {
    "text_score": {
        "word_score_list": [
            {
                "word": "beam",
                "phone_score_list": [
                    {"phone": a, "extent": [round(100 * s), round(100 * e)]} for a, s, e in ARPABET
                ],
            }
        ]
    }
}
INWORLD_PHONES = {
    "timestampInfo": {
        "wordAlignment": {
            **{"words": ["beam"], "wordStartTimeSeconds": [0.2], "wordEndTimeSeconds": [0.6]},
            "phoneticDetails": [
                {
                    "wordIndex": 0,
                    "phones": [
                        {"phoneSymbol": a, "startTimeSeconds": s, "durationSeconds": round(e - s, 3)}
                        for a, s, e in IPA
                    ],
                }
            ],
        }
    }
}
END: Spans = (("sil", 0.6, 0.7),)

FESTIVAL = """EST_File utterance
DataType ascii
version 2
EST_Header_End
Features max_id 4 ; type Text ;
Stream_Items
1 id _1 ; name pau ; dur_factor 1 ; end 0.2 ;
2 id _2 ; name b ; end 0.3 ;
3 id _3 ; name iy ; end 0.5 ;
4 id _4 ; name m ; end 0.6 ;
End_of_Stream_Items
Relations
Relation Segment ; ()
1 1 0 0 2 0
2 2 0 0 3 1
3 3 0 0 4 2
4 4 0 0 0 3
End_of_Relation
End_of_Relations
End_of_Utterance
"""

PHONED: dict[str, list[Sample]] = {
    "festival": [text(FESTIVAL, (("pau", 0.0, 0.2), ("b", 0.2, 0.3), ("iy", 0.3, 0.5), ("m", 0.5, 0.6)))],
    "annosoft": [text(ANNO, labelled("", "b", "IY", "m", "")[:4], WORD)],
    "pamela": [text(PAM, (*labelled("", "B", "IY1", "M", "")[:4], ("", 0.6, 0.6 + 1 / 24)), notes=1)],
    "faceposer": [text(FACEPOSER, ARPABET, WORD)],
    "marytts": [text(MARY, labelled("_", "b", "i", "m", "")[:4], WORD)],
    "utau": [text(UST, labelled("", "b", "i", "m", "")[:4], notes=1)],
    "characters": [dumped(INWORLD_PHONES, IPA, WORD)],
    "services": [dumped(SPEECHACE, ARPABET)],
    "seconds": [
        text("0 0.2 sil\n0.2 0.3 b\n0.3 0.5 iː\n0.5 0.6 m\n", (("sil", 0.0, 0.2), *IPA)),
        text("b\t0.2\t0.3\niː\t0.3\t0.5\nm\t0.5\t0.6\n", IPA),
        text("0.2\tb\n0.3\tiː\n0.5\tm\n0.6\tsil\n", (*IPA, *END), notes=1),
        text("0.2 sil\n0.3 b\n0.5 iː\n0.6 m\n", (("sil", 0.0, 0.2), *IPA), notes=1),
        text("0.2 0.1 b\n0.3 0.2 iː\n0.5 0.1 m\n", IPA, notes=1),
        text("0.200000\t0.200000\tb\n0.3\t0.3\tiː\n0.5\t0.5\tm\n0.6\t0.6\tsil\n", (*IPA, *END), notes=1),
    ],
    "timed_table": [
        text("tmin\ttier\ttext\ttmax\n0.2\twords\tbeam\t0.6\n0.2\tphones\tb\t0.3\n"
             "0.3\tphones\tiː\t0.5\n0.5\tphones\tm\t0.6\n", IPA, WORD),
        text("tmin\ttext\ttmax\n0.2\tb\t0.3\n0.3\tiː\t0.5\n0.5\tm\t0.6\n", IPA),
        text(",word,phone,Start Time (s),End Time (s)\n"
             "0,beam,b,0.2,0.3\n1,beam,iː,0.3,0.5\n2,beam,m,0.5,0.6\n", IPA),
    ],
    "any_json": [
        *(dumped(content, IPA, notes=1) for content in (PHONES_MS, BESIDE, LISTS, TIERS, STUDIO, EMBEDDED)),
        dumped(FRAMES, (*IPA, ("", 0.6, 0.7)), notes=1),
        dumped(VOSK, IPA, WORD, 2),
        dumped(TIMELINE, IPA, WORD, 1),
        dumped(CUES, (*SHAPES, *END), notes=2),
        dumped(NUMBERS, (("p", 0.2, 0.3), ("iy", 0.3, 0.5), ("p", 0.5, 0.6), *END), notes=2),
    ],
}  # fmt: skip

EDGE = {"type": "WordBoundary", "offset": 2_000_000, "duration": 4_000_000, "text": "beam"}
FUNASR = [{"key": "x", "text": "beam", "timestamp": [[200, 600]]}]
_PIECES = (("be", 200, 400), ("am", 400, 600), (" me", 700, 900))
SONIOX = {"tokens": [{"text": a, "start_ms": start, "end_ms": end} for a, start, end in _PIECES]}
SHERPA = {"text": "beam me", "tokens": ["▁be", "am", "▁me"], "timestamps": [0.2, 0.4, 0.6]}
PODCAST = {"segments": [{"speaker": "Mary", "startTime": 0.2, "endTime": 0.6, "body": "beam"}]}
MINIMAX = [{"text": "Beam.", "timestamped_words": [{"word": "beam", "time_begin": 200, "time_end": 600.0}]}]
TENCENT = {
    "Response": {
        "Data": {
            "ResultDetail": [
                {"StartMs": 100, "Words": [{"Word": "beam", "OffsetStartMs": 100, "OffsetEndMs": 500}]}
            ]
        }
    }
}
AUDITION = "Name\tStart\tDuration\tTime Format\tType\tDescription\nbeam\t0:00.200\t0:00.400\tdecimal\tCue\t\n"
REAPER = "#,Name,Start,End,Length,Color\nR1,beam,0:00.200,0:00.600,0:00.400,\nM1,here,0:00.700,,,\n"
CLOCK = "Start Time,End Time,Text\n00:00:00.2000000,00:00:00.6000000,beam\n"

SAMI = """<SAMI><HEAD><STYLE TYPE="text/css"><!-- .ENCC {Name: English; lang: en-US;} --></STYLE></HEAD><BODY>
<SYNC Start=200><P Class=ENCC>beam<SYNC Start=600><P Class=ENCC>&nbsp;</BODY></SAMI>
"""
ULTRASTAR = "#TITLE:x\n#BPM:75\n#GAP:200\n: 0 1 60 be\n: 1 1 60 am\n- 3\nE\n"
CHAT = """@UTF8
@Begin
@Languages:\teng
*MAR:\tbeam . \x15200_600\x15
@End
"""
CHAT_WORDS = CHAT.replace("@End", "%wor:\tbeam \x15200_600\x15 .\n@End")

WORDED: dict[str, list[Sample]] = {
    "sami": [text(SAMI, (), WORD)],
    "microdvd": [text("{1}{1}10\n{2}{6}{y:i}beam\n", (), WORD), text("[2][6]/beam\n", (), WORD)],
    "ultrastar": [text(ULTRASTAR, (), WORD)],
    "chat": [text(content, (), WORD) for content in (CHAT, CHAT_WORDS)],
    "youtube": [text(content, (), WORD) for content in (YOUTUBE_OLD, YOUTUBE)],
    "nist": [text(content, (), WORD) for content in (RTTM, STM)],
    "exmaralda": [text(EXB, (), WORD)],
    "transcriber": [text(TRS, (), WORD)],
    "services": [dumped(TENCENT, (), WORD)],
    "timed_table": [text(content, (), WORD) for content in (AUDITION, REAPER, CLOCK)],
    "any_json": [
        *(dumped(content, (), WORD) for content in (EDGE, FUNASR, PODCAST, MINIMAX)),
        dumped(SONIOX, (), (*WORD, ("me", 0.7, 0.9))),
        dumped(SHERPA, (), (*WORD, ("me", 0.6, 1.2))),
    ],
}
