"""Files that are made so that a search for a pattern, or a list that is read again and again, takes long."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from benchmarks.hostile import Attack, Samples, small_character
from phonanim.media.glb import glb_bytes, parse_glb

Craft = Callable[[Samples, Path], Attack]
MANY = 1_000_000
MAYA = "animVersion 1.1;\ntimeUnit ntscf;\n"
UNITY = "%YAML 1.1\nAnimationClip:\n  m_SampleRate: 60\n  m_FloatCurves:\n{}  m_PPtrCurves: []\n"


def _cue(text: str) -> str:
    return f"1\n00:00:00,000 --> 00:00:09,000\n{text}\n\n"


def _places(count: int) -> str:
    """Labels with times and labels without, each at a place of its own."""
    timed = {f"t{n}": {"label": "M", "start": n, "end": n + 1} for n in range(count)}
    return json.dumps(timed | {f"u{n}": {"label": "M"} for n in range(count)})


ALIGNMENTS: dict[str, tuple[str, Callable[[], str]]] = {
    "tags that do not end": ("a.srt", lambda: _cue("<" * MANY)),
    "voices that do not end": ("a.vtt", lambda: "WEBVTT\n\n" + _cue("<v " * MANY).replace(",", ".")),
    "styles that do not end": ("a.srt", lambda: _cue("{" * MANY)),
    "brackets that do not end": ("a.srt", lambda: _cue("( " * MANY)),
    "dashes without a speaker": ("a.srt", lambda: _cue("-\n" * MANY)),
    "syllables that do not end": (
        "a.ass",
        lambda: (
            "[Script Info]\n\n[Events]\nFormat: Layer, Start, End, Text\n"
            f"Dialogue: 0,0:00:00.00,0:00:09.00,{'{' * MANY}\n"
        ),
    ),
    "empty lines of FacePoser": ("a.txt", lambda: "VERSION 1.0\n" + "\n" * MANY + "WORD a 0 1\n"),
    "empty lines of Pamela": ("a.pamela", lambda: "[Speech]\n" + "\n" * MANY + "1:AA\n"),
    "empty lines of OpenUtau": (
        "a.ustx",
        lambda: "ustx_version: '0.6'\n" + "\n" * MANY + "voice_parts: []\n",
    ),
    "a long name in a CTM": ("a.ctm", lambda: "a" * MANY + " 1\n"),
    "a tier of underscores": (
        "a.TextGrid",
        lambda: (
            'File type = "ooTextFile"\nObject class = "TextGrid"\n0 1 <exists> 1\n'
            f'"IntervalTier" "{"_" * MANY}" 0 1 1\n0 1 "AA1"\n'
        ),
    ),
    "lists side by side": (
        "a.json",
        lambda: json.dumps({f"k{n}": ["a"] if n % 2 else [0.1] for n in range(MANY // 5)}),
    ),
    "labels at places of their own": ("a.json", lambda: _places(MANY // 10)),
    "empty tables": ("a.json", lambda: json.dumps([{}] * 2 * MANY)),
    "lists of labels that begin again": ("a.json", lambda: json.dumps([[["M", 0, 1]]] * (MANY // 4))),
    "labels that start at once": (
        "a.json",
        lambda: json.dumps({"phones": [{"phone": "AA", "start": 0} for _ in range(MANY // 4)]}),
    ),
    "a caption of two million words": (
        "a.json",
        lambda: json.dumps([{"text": "a " * 2 * MANY, "start": 0, "end": 5000}]),
    ),
    "captions of two million words": ("a.srt", lambda: "".join(_cue("a " * 100) for _ in range(MANY // 50))),
}
TAKES: dict[str, tuple[str, Callable[[], str]]] = {
    "curves of Maya without data": ("a.anim", lambda: MAYA + "anim a b\n" * MANY),
    "empty lines of Maya": ("a.anim", lambda: MAYA + "\n" * MANY + "x"),
    "curves of Unity without names": ("a.unity.anim", lambda: UNITY.format("  - m_Curve:\n" * (MANY // 2))),
}


def _animate(name: str, make: Callable[[], str]) -> Craft:
    def craft(samples: Samples, folder: Path) -> Attack:
        (folder / name).write_text(make())
        return ["animate", name, "-o", "o.json", "--fps", "25", "--on-unknown-label", "silence"]

    return craft


def _convert(name: str, make: Callable[[], str]) -> Craft:
    def craft(samples: Samples, folder: Path) -> Attack:
        (folder / name).write_text(make())
        return ["convert", name, "-o", "o.npz"]

    return craft


def copied_name(samples: Samples, folder: Path) -> Attack:
    """A character whose shape has the name of a copy of a copy of a copy."""
    glb = parse_glb(small_character(), "c.glb")
    glb.tree["meshes"][0]["extras"]["targetNames"] = ["jawOpen" + ".001" * (MANY // 2) + "x"]
    (folder / "c.glb").write_bytes(glb_bytes(glb.tree, glb.binary))
    return ["rig", "fit", "c.glb", "-o", "m.toml"]


PATTERNS: dict[str, Craft] = {
    **{f"alignment: {name}": _animate(*made) for name, made in ALIGNMENTS.items()},
    **{f"take: {name}": _convert(*made) for name, made in TAKES.items()},
    "character: a name of many copies": copied_name,
}
