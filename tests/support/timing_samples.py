"""The utterance "beam" as synthesizers, recognizers and animation programs write it."""

from __future__ import annotations

import json

import other_timings
from alignment_samples import SAMPLES, WORD, WORD_LISTS, Sample, Spans, dumped, labelled, text

IPA: Spans = (("b", 0.2, 0.3), ("iː", 0.3, 0.5), ("m", 0.5, 0.6))
SHAPES: Spans = (("p", 0.2, 0.3), ("iy", 0.3, 0.5), ("p", 0.5, 0.6))
TICKS = 10_000_000


def lines(*values: object, **rest: object) -> Sample:
    return text("".join(json.dumps(value) + "\n" for value in values), **rest)  # type: ignore[arg-type]


AZURE = {
    "RecognitionStatus": "Success",
    "NBest": [
        {
            "Lexical": "beam",
            "Words": [
                {
                    "Word": "beam",
                    "Offset": int(0.2 * TICKS),
                    "Duration": int(0.4 * TICKS),
                    "Phonemes": [
                        {"Phoneme": "b", "Offset": 2_000_000, "Duration": 900_000},
                        {"Phoneme": "iy", "Offset": 3_000_000, "Duration": 1_900_000},
                        {"Phoneme": "m", "Offset": 5_000_000, "Duration": 1_000_000},
                    ],
                }
            ],
        }
    ],
}
AZURE_VISEMES = [
    {"audioOffset": int(time * TICKS), "visemeId": number}
    for time, number in ((0.0, 0), (0.2, 21), (0.3, 6), (0.5, 21), (0.6, 0))
]
AZURE_LOG = {
    "Metadata": [
        {"Type": "Viseme", "Data": {"Offset": int(time * TICKS), "VisemeId": number}}
        for time, number in ((0.2, 21), (0.3, 6), (0.5, 21), (0.6, 0))
    ]
}
POLLY = [
    {"time": 0, "type": "sentence", "start": 0, "end": 5, "value": "Beam."},
    {"time": 200, "type": "word", "start": 0, "end": 4, "value": "Beam"},
    {"time": 200, "type": "viseme", "value": "p"},
    {"time": 300, "type": "viseme", "value": "i"},
    {"time": 500, "type": "viseme", "value": "p"},
    {"time": 600, "type": "viseme", "value": "sil"},
]
KOKORO = {
    "audio": "",
    "words": [
        {"word": "Beam", "phonemes": "bˈim", "start_time": 0.2, "end_time": 0.6},
        {"word": ".", "phonemes": ".", "start_time": None, "end_time": None},
    ],
}
HEADTTS = {
    "type": "audio",
    "data": {
        **{"words": ["beam"], "wtimes": [200], "wdurations": [400]},
        **{"visemes": ["PP", "I", "PP"], "vtimes": [200, 300, 500], "vdurations": [100, 200, 100]},
    },
}


def mora(consonant: str | None, before: float | None, vowel: str, length: float) -> dict:
    return {
        **{"text": "", "consonant": consonant, "consonant_length": before},
        **{"vowel": vowel, "vowel_length": length, "pitch": 5.0},
    }


VOICEVOX = {
    "accent_phrases": [
        {
            "moras": [mora("b", 0.2, "i", 0.4), mora("m", 0.2, "u", 0.2)],
            "accent": 1,
            "pause_mora": mora(None, None, "pau", 0.2),
        }
    ],
    **{"speedScale": 2.0, "prePhonemeLength": 0.4, "postPhonemeLength": 0.2},
}
MBROLA = "; eSpeak\n_\t200\t0 80\nb\t100\ni:\t200\t0 110 50 120 100 100\nm 100 ; the last\n_ 400\n"
PIPER = {
    "phonemes": [{"phoneme": label, "start": start, "end": end} for label, start, end in IPA],
    "total_duration": 1.0,
}
PIPER_MS = {
    "phonemes": [{"phoneme": x, "start_ms": 1000 * s, "end_ms": 1000 * e} for x, s, e in IPA],
}
PIPER_SAMPLES = {
    **{"phonemes": ["^", "b", "i", "ː", "m", "$"], "sample_rate": 10_000},
    "phoneme_id_samples": [2000, 1000, 1500, 500, 1000, 4000],
}
TSV = "start\tend\tphoneme\n" + "".join(f"{s:.3f}\t{e:.3f}\t{x}\n" for x, s, e in IPA)
SEMICOLONS = "Label;Start ms;Duration\nb;200;100\niː;300;200\nm;500;100\n"
BFA = {
    "segments": [
        {
            **{"start": 0.0, "end": 1.0, "text": "beam"},
            "phoneme_ts": [
                {"phoneme_label": "b", "ipa_label": "b", "start_ms": 200.0, "end_ms": 216.0},
                {"phoneme_label": "i:", "ipa_label": "iː", "start_ms": 300.0, "end_ms": 480.0},
                {"phoneme_label": "m", "ipa_label": "m", "start_ms": 500.0, "end_ms": 600.0},
            ],
            "words_ts": [{"word": "beam", "start_ms": 200.0, "end_ms": 600.0}],
        }
    ]
}
JULIUS = """### read waveform input
pass1_best: beam
=== begin forced alignment ===
-- word alignment --
 id: from  to    n_score    unit
 ----------------------------------------
[  20   59]  -22.500000  beam\t[beam]
re-computed AM score: -1234.5
=== end forced alignment ===
=== begin forced alignment ===
-- phoneme alignment --
 id: from  to    n_score    unit
 ----------------------------------------
[   0   19]  -23.696209  silB
[  20   29]  -25.000000  b+i:
[  30   49]  -20.000000  b-i:+m
[  50   59]  -21.000000  i:-m
[  60   99]  -23.000000  silE
=== end forced alignment ===
"""
POCKETSPHINX = {
    **{"b": 0.0, "d": 1.0, "p": 1.0, "t": "beam"},
    "w": [
        {"b": 0.0, "d": 0.2, "p": 1.0, "t": "<s>", "w": [{"b": 0.0, "d": 0.2, "p": 1.0, "t": "SIL"}]},
        {
            **{"b": 0.2, "d": 0.4, "p": 1.0, "t": "beam(2)"},
            "w": [
                {"b": 0.2, "d": 0.1, "p": 1.0, "t": "B"},
                {"b": 0.3, "d": 0.2, "p": 1.0, "t": "IY"},
                {"b": 0.5, "d": 0.1, "p": 1.0, "t": "M"},
            ],
        },
    ],
}
SPPAS = """<?xml version="1.0" encoding="UTF-8"?>
<Document author="" date="" format="1.5" version="1.5">
<Tier id="t1" tiername="PhonAlign">%s</Tier>
<Tier id="t2" tiername="TokensAlign">%s</Tier>
</Document>"""


def annotation(label: str, start: float, end: float, more: str = "") -> str:
    return (
        f'<Annotation><Location><Interval><Begin midpoint="{start}" radius="0.005"/>'
        f'<End midpoint="{end}" radius="0.005"/></Interval></Location>'
        f'<Label><Tag score="0.9">{label}</Tag>{more}</Label></Annotation>'
    )


XRA = SPPAS % (
    annotation("b", 0.2, 0.3, '<Tag score="0.1">p</Tag>')
    + annotation("i:", 0.3, 0.5)
    + annotation("m", 0.5, 0.6),
    annotation("beam", 0.2, 0.6),
)
XTIMING = """<?xml version="1.0" encoding="UTF-8"?>
<timing name="Lyrics" SourceVersion="2024.01">
<EffectLayer><Effect label="beam" starttime="200" endtime="600"/></EffectLayer>
<EffectLayer><Effect label="BEAM" starttime="200" endtime="600"/></EffectLayer>
<EffectLayer><Effect label="MBP" starttime="200" endtime="300"/>
<Effect label="E" starttime="300" endtime="500"/>
<Effect label="MBP" starttime="500" endtime="600"/></EffectLayer>
</timing>"""
PG2 = {
    **{"version": 2, "sound_path": "x.wav", "sound_duration": 40, "fps": 40, "num_voices": 1},
    "voices": [
        {
            **{"name": "Mary", "text": "beam", "start_frame": 0, "end_frame": 24},
            "children": [
                {
                    **{"text": "beam", "start_frame": 8, "end_frame": 23},
                    "children": [
                        {
                            **{"text": "beam", "start_frame": 8, "end_frame": 23, "children": []},
                            "phonemes": [
                                {"frame": 8, "text": "B"},
                                {"frame": 12, "text": "IY"},
                                {"frame": 20, "text": "M"},
                            ],
                        }
                    ],
                }
            ],
        }
    ],
}
DS = [
    {
        **{"offset": 0.2, "text": "AP", "ph_seq": "b en/iy m", "ph_dur": "0.1 0.2 0.1", "ph_num": "2 1"},
        "f0_seq": "200 200",
    }
]
USTX = """name: beam
resolution: 480
tempos:
- position: 0
  bpm: 120
- position: 480
  bpm: 240
ustx_version: "0.6"
voice_parts:
- name: Mary
  position: 0
  notes:
  - {position: 192, duration: 96, tone: 60, lyric: "beam[b iy m]"}
  - {position: 288, duration: 192, tone: 60, lyric: "+~"}
  - {position: 480, duration: 192, tone: 60, lyric: "+"}
"""
SUNG: Spans = (("b", 0.2, 0.2 + 0.4 / 3), ("iy", 0.2 + 0.4 / 3, 0.6 - 0.4 / 3), ("m", 0.6 - 0.4 / 3, 0.6))

HUME = [
    {"type": "timestamp", "timestamp": {"type": kind, "text": label, "time": {"begin": start, "end": end}}}
    for kind, label, start, end in (
        ("word", "beam", 200, 600),
        *(("phoneme", label, round(1000 * start), round(1000 * end)) for label, start, end in IPA),
    )
]
RESEMBLE = {
    "audio_timestamps": {
        "phon_chars": ["b", "ˈiː", "m", "."],
        "phon_times": [[0.2, 0.3], [0.3, 0.5], [0.5, 0.6], [0.6, 0.7]],
    }
}

NEW: dict[str, list[Sample]] = {
    "azure_speech": [dumped(AZURE, labelled("", "b", "iy", "m", "")[1:4], WORD)],
    "azure_visemes": [
        dumped(AZURE_VISEMES, (("sil", 0.0, 0.2), *SHAPES, ("sil", 0.6, 0.7)), notes=1),
        dumped(AZURE_LOG, (*SHAPES, ("sil", 0.6, 0.7)), notes=1),
    ],
    "polly": [
        lines(
            *POLLY, phones=(*SHAPES, ("sil", 0.6, 0.7)), words=(("Beam", 0.2, 0.7),), notes=1, name="x.marks"
        )
    ],
    "kokoro": [
        dumped(
            KOKORO,
            (("b", 0.2, 0.2 + 0.4 / 3), ("i", 0.2 + 0.4 / 3, 0.6 - 0.4 / 3), ("m", 0.6 - 0.4 / 3, 0.6)),
            (("Beam", 0.2, 0.6),),
            1,
        )
    ],
    "headtts": [dumped(HEADTTS, (("p", 0.2, 0.3), ("ih", 0.3, 0.5), ("p", 0.5, 0.6)), WORD, 1)],
    "voicevox": [
        dumped(
            VOICEVOX,
            (
                *(("pau", 0.0, 0.2), ("b", 0.2, 0.3), ("i", 0.3, 0.5), ("m", 0.5, 0.6), ("u", 0.6, 0.7)),
                *(("pau", 0.7, 0.8), ("pau", 0.8, 0.9)),
            ),
        )
    ],
    "mbrola": [text(MBROLA, labelled("_", "b", "i:", "m", "_"))],
    "piper": [
        dumped(PIPER, IPA),
        dumped(PIPER_MS, IPA),
        dumped(PIPER_SAMPLES, labelled("", "b", "i", "m", "")),
    ],
    "timed_table": [text(TSV, IPA), text(SEMICOLONS, IPA)],
    "bournemouth": [dumped(BFA, IPA, WORD)],
    "julius": [text(JULIUS, labelled("silB", "b", "i:", "m", "silE"), WORD)],
    "pocketsphinx": [
        lines(POCKETSPHINX, phones=labelled("SIL", "B", "IY", "M", "")[:4], words=(("<s>", 0.0, 0.2), *WORD))
    ],
    "sppas": [text(XRA, labelled("", "b", "i:", "m", "")[1:4], WORD)],
    "xlights": [
        text(XTIMING, labelled("", "MBP", "E", "MBP", "")[1:4], (("BEAM", 0.2, 0.6),), notes=1),
    ],
    "papagayo_ng": [
        dumped(PG2, (*labelled("", "B", "IY", "M", "")[1:4], ("rest", 0.6, 0.625)), WORD),
    ],
    "diffsinger": [dumped(DS, labelled("", "b", "iy", "m", "")[1:4])],
    "services": [dumped(HUME, IPA, WORD), dumped(RESEMBLE, IPA)],
}
"""By reader; `openutau` needs a package: see USTX."""

ELEVENLABS = {
    "audio_base64": "",
    "alignment": {
        "characters": ["b", "e", "a", "m", " ", "m", "e"],
        "character_start_times_seconds": [0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7],
        "character_end_times_seconds": [0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8],
    },
    "normalized_alignment": {"characters": [], "character_start_times_seconds": []},
}
STREAMED = [
    {"audio": "", "alignment": {"chars": list(piece), "charStartTimesMs": starts, "charDurationsMs": lasts}}
    for piece, starts, lasts in (("bea", [200, 300, 400], [100] * 3), ("m ", [0, 100], [100, 50]))
]
INWORLD = {
    "timestampInfo": {
        "wordAlignment": {
            **{"words": ["beam"], "wordStartTimeSeconds": [0.2], "wordEndTimeSeconds": [0.6]},
        }
    }
}
GOOGLE = {
    "results": [
        {
            "alternatives": [{"words": [{"startTime": "0.200s", "endTime": "0.600s", "word": "beam"}]}],
            "languageCode": "en-us",
        }
    ]
}
GOOGLE_PROTO = {
    "results": [
        {
            "alternatives": [
                {
                    "words": [
                        {
                            "start_time": {"nanos": 200_000_000},
                            "end_time": {"nanos": 600_000_000},
                            "word": "beam",
                        }
                    ]
                }
            ]
        }
    ]
}
AENEAS = {
    "fragments": [
        {"id": "f1", "begin": "0.200", "end": "0.600", "language": "eng", "lines": ["beam"], "children": []}
    ]
}
SRT = "1\n00:00:00,200 --> 00:00:00,600\nBeam\n"
VTT = "WEBVTT\n\nNOTE x\n\n00:00.200 --> 00:00.600\n<v Mary><i>Beam</i> <00:00:00.600>\n"
TIMESTAMPED = {"segments": [{"words": [{"text": "beam", "start": 0.2, "end": 0.6, "confidence": 0.9}]}]}
OPENAI = {"task": "transcribe", "words": [{"word": "beam", "start": 0.2, "end": 0.6}], "text": "beam"}
SEGMENTS = {"word_segments": [{"word": "beam", "start": 0.2, "end": 0.6, "score": 0.9}]}
CAPTIONS = [{"word": "beam", "start_time": 0.2, "end_time": 0.6}]
CHUNKS = {"text": "beam", "chunks": [{"text": " beam", "timestamp": [0.2, 0.6]}]}
LINES_ONLY = {"segments": [{"id": 0, "start": 0.2, "end": 0.6, "text": " beam"}], "language": "en"}
DEEPGRAM = {
    "results": {"channels": [{"alternatives": [{"words": [{"word": "beam", "start": 0.2, "end": 0.6}]}]}]}
}
NEMO = "x 1 0.00 0.20 <b>\nx 1 0.20 0.04 ▁be\nx 1 0.24 0.20 <b>\nx 1 0.44 0.04 am\nx 1 0.48 0.12 <b>\n"
TIMES = "<s> 0.000 0.200 1.0\nbeam 0.200 0.600 0.98\n</s> 0.600 1.000 1.0\n"

ASSEMBLYAI = {
    "language_code": "en_us",
    "words": [{"text": "beam", "start": 200, "end": 600, "confidence": 0.9, "speaker": "A"}],
}
_PIECES = (("[_BEG_]", 0, 0), (" be", 200, 400), ("am", 400, 600), ("[_TT_30]", 600, 600))
WHISPER_CPP = {
    "result": {"language": "en"},
    "transcription": [
        {
            "offsets": {"from": 200, "to": 600},
            "text": " beam",
            "tokens": [{"text": a, "offsets": {"from": b, "to": c}} for a, b, c in _PIECES],
        }
    ],
}
WHISPER_CPP_LINES = {"transcription": [{"offsets": {"from": 200, "to": 600}, "text": " beam"}]}
CARTESIA = [
    {"type": "chunk", "data": ""},
    {"type": "timestamps", "word_timestamps": {"words": ["beam"], "start": [0.2], "end": [0.6]}},
    {"type": "done"},
]
SPEECHMATICS = {
    "results": [
        {"alternatives": [{"content": "beam"}], "start_time": 0.2, "end_time": 0.6, "type": "word"},
        {"alternatives": [{"content": "."}], "start_time": 0.6, "end_time": 0.6, "type": "punctuation"},
    ]
}
TRANSCRIBE = {
    "results": {
        "language_code": "en-US",
        "items": [
            {
                **{"start_time": "0.2", "end_time": "0.6", "type": "pronunciation"},
                "alternatives": [{"confidence": "0.9", "content": "beam"}],
            },
            {"alternatives": [{"confidence": "0.0", "content": "."}], "type": "punctuation"},
        ],
    }
}
REV = {
    "monologues": [
        {
            "speaker": 0,
            "elements": [
                {"type": "text", "value": "beam", "ts": 0.2, "end_ts": 0.6},
                {"type": "punct", "value": "."},
            ],
        }
    ]
}
WATSON = {"results": [{"alternatives": [{"timestamps": [["beam", 0.2, 0.6]]}]}]}
LMNT = {
    "durations": [{"text": "", "start": 0, "duration": 0.2}, {"text": "beam", "start": 0.2, "duration": 0.4}]
}
YOUTUBE = {
    "events": [
        {"tStartMs": 100, "segs": [{"utf8": "beam", "tOffsetMs": 100}]},
        {"tStartMs": 600, "aAppend": 1, "segs": [{"utf8": "\n"}]},
        {"tStartMs": 600, "segs": [{"utf8": "me"}]},
    ]
}
AZURE_FAST = {
    "phrases": [{"words": [{"text": "beam", "offsetMilliseconds": 200, "durationMilliseconds": 400}]}]
}
AZURE_BATCH = {
    "recognizedPhrases": [
        {"nBest": [{"words": [{"word": "beam", "offsetInTicks": 2e6, "durationInTicks": 4e6}]}]}
    ]
}
RIVA = {"results": [{"alternatives": [{"words": [{"startTime": 200, "endTime": 600, "word": "beam"}]}]}]}
NEMO_TIMES = {"timestamp": {"word": [{"word": "beam", "start_offset": 2, "start": 0.2, "end": 0.6}]}}
SCRIBE = {
    "words": [
        {"text": "beam", "start": 0.2, "end": 0.6, "type": "word"},
        {"text": " ", "start": 0.6, "end": 0.7, "type": "spacing"},
    ]
}
ASS = (
    "[Script Info]\nScriptType: v4.00+\n\n[Events]\n"
    "Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text\n"
    "Comment: 0,0:00:00.00,0:00:05.00,Default,,0,0,0,template,x\n"
    "Dialogue: 0,0:00:00.10,0:00:00.60,Default,,0,0,0,,{\\k10}{\\kf20}be{\\k20}am\n"
)
LRC = "[ti:Beam]\n[offset:0]\n[00:00.20]<00:00.20>beam<00:00.60>\n"
TTML = (
    '<?xml version="1.0"?><tt xmlns="http://www.w3.org/ns/ttml" xml:lang="en"><body begin="0.1s">'
    '<div><p begin="00:00:00.100" dur="400ms">beam</p></div></body></tt>'
)
SBV = "0:00:00.200,0:00:00.600\nBeam\n"

WORDS_ALONE: dict[str, list[Sample]] = {
    "services": [
        *(dumped(content, (), WORD) for content in (ASSEMBLYAI, WHISPER_CPP, WHISPER_CPP_LINES, CARTESIA)),
        *(dumped(content, (), WORD) for content in (SPEECHMATICS, TRANSCRIBE, REV, WATSON, LMNT)),
        *(dumped(content, (), WORD) for content in (AZURE_FAST, AZURE_BATCH, RIVA, NEMO_TIMES, SCRIBE)),
        dumped(YOUTUBE, (), (*WORD, ("me", 0.6, 1.2))),
    ],
    "substation": [text(ASS, (), WORD)],
    "lyrics": [text(LRC, (), WORD)],
    "ttml": [text(TTML, (), WORD)],
    "characters": [
        dumped(ELEVENLABS, (), (*WORD, ("me", 0.65, 0.8))),
        lines(*STREAMED, phones=(), words=WORD),
        dumped(INWORLD, (), WORD),
    ],
    "google_words": [dumped(GOOGLE, (), WORD), dumped(GOOGLE_PROTO, (), WORD)],
    "aeneas": [dumped(AENEAS, (), WORD)],
    "subtitles": [text(content, (), (("Beam", 0.2, 0.6),)) for content in (SRT, VTT, SBV)],
    "words_json": [
        *WORD_LISTS,
        *(dumped(content, (), WORD) for content in (TIMESTAMPED, OPENAI, SEGMENTS, CAPTIONS, CHUNKS)),
        *(dumped(content, (), WORD) for content in (LINES_ONLY, DEEPGRAM)),
    ],
    "ctm": [text(NEMO, (), WORD)],
    "pocketsphinx": [text(TIMES, (), (("<s>", 0.0, 0.2), *WORD, ("</s>", 0.6, 1.0)))],
}
"""By reader: files that have words and no phones."""

OPENUTAU = [text(USTX, SUNG, (("beam", 0.2, 0.6),), 1)]


def merged(*groups: dict[str, list[Sample]]) -> dict[str, list[Sample]]:
    """All samples of each reader."""
    names = dict.fromkeys(name for group in groups for name in group)
    return {name: [sample for group in groups for sample in group.get(name, [])] for name in names}


PHONED = merged(SAMPLES, NEW, other_timings.PHONED)
WORDS_ALONE = merged(WORDS_ALONE, other_timings.WORDED)
EVERY = merged(PHONED, WORDS_ALONE, {"openutau": OPENUTAU})
"""Every sample by its reader."""
