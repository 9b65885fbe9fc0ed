"""Small files that somebody crafts so that they grow, or take long, when they are read."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.crafted import lying_archive
from benchmarks.hostile import LINE, Attack, Samples
from phonanim.media.glb import glb_bytes

Craft = Callable[[Samples, Path], Attack]
SHORT = ["-o", "o.json", "--fps", "25"]
POSES = ("mean", *(f"mode{n}_{side}" for n in (1, 2, 3, 4) for side in ("minus", "plus")))
MANY = 700_000  # vertices whose positions fill 8.4 MB


def _animate(name: str, make: Callable[[], str | bytes], *more: str) -> Craft:
    """An alignment, and how it is animated."""

    def craft(samples: Samples, folder: Path) -> Attack:
        data = make()
        (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
        return ["animate", name, *SHORT, *more]

    return craft


def _convert(name: str, make: Callable[[], str | bytes], out: str = "o.npz") -> Craft:
    """A take or a capture, and how it is converted."""

    def craft(samples: Samples, folder: Path) -> Attack:
        data = make()
        (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
        return ["convert", name, "-o", out]

    return craft


def _option(option: str, name: str, make: Callable[[], str | bytes]) -> Craft:
    """A file beside the example line, named by an option."""

    def craft(samples: Samples, folder: Path) -> Attack:
        data = make()
        (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
        return ["animate", str(LINE), *SHORT, option, name]

    return craft


def _textgrid(labels: list[str], step: float) -> str:
    """A TextGrid of one tier, `step` seconds for each label."""
    head = 'File type = "ooTextFile"\nObject class = "TextGrid"\n'
    end = len(labels) * step
    rows = "\n".join(f'{n * step:.3f} {(n + 1) * step:.3f} "{label}"' for n, label in enumerate(labels))
    return f'{head}0 {end:.3f} <exists> 1 "IntervalTier" "phones" 0 {end:.3f} {len(labels)}\n{rows}\n'


def _distinct(count: int) -> list[str]:
    """Labels that no language has, all different."""
    return [f"q{np.base_repr(number, 36).lower()}" for number in range(count)]


def _tree(**more: Any) -> dict[str, Any]:
    """A glTF tree of one mesh, whose one accessor all of its parts share."""
    size = 12 * MANY
    accessor = {"bufferView": 0, "componentType": 5126, "count": MANY, "type": "VEC3"}
    primitive: dict[str, Any] = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}]}
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": size}],
        "bufferViews": [{"buffer": 0, "byteLength": size}],
        "accessors": [accessor],
        "meshes": [{"primitives": [primitive], "extras": {"targetNames": ["jawOpen"]}}],
        "nodes": [{"mesh": 0}],
        **more,
    }


def _character(make: Callable[[], tuple[dict[str, Any], bytes]], *command: str) -> Craft:
    """A character, and a command on it (by default, to show a take on it)."""

    def craft(samples: Samples, folder: Path) -> Attack:
        (folder / "c.glb").write_bytes(glb_bytes(*make()))
        given = command or ("convert", str(samples.folder / "a.npz"), "-o", "o.html", "--character", "c.glb")
        return list(given)

    return craft


def shared_targets() -> tuple[dict[str, Any], bytes]:
    """Two thousand targets that are all the same 8 MB."""
    names = [f"shape{n}" for n in range(2000)]
    part = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}] * len(names)}
    return _tree(meshes=[{"primitives": [part], "extras": {"targetNames": names}}]), bytes(12 * MANY)


def shared_meshes() -> tuple[dict[str, Any], bytes]:
    """A thousand nodes that all show the same 8 MB."""
    return _tree(nodes=[{"mesh": 0} for _ in range(1000)]), bytes(12 * MANY)


def sparse_accessor() -> tuple[dict[str, Any], bytes]:
    """An accessor of 400 million values of which none is stored."""
    accessor = {"componentType": 5126, "count": 400_000_000, "type": "VEC3"}
    return _tree(accessors=[accessor]), bytes(12)


def deep_nodes() -> tuple[dict[str, Any], bytes]:
    """A chain of 19,000 nodes, each the child of the one before."""
    chain: list[dict[str, Any]] = [{"children": [n + 1], "scale": [2, 2, 2]} for n in range(19_000)]
    return _tree(nodes=[*chain, {"mesh": 0}]), bytes(12 * MANY)


def large_picture() -> tuple[dict[str, Any], bytes]:
    """A texture of 30,000 x 30,000 pixels in some hundred kilobytes."""
    side = 30_000
    rows = zlib.compressobj(9)
    data = b"".join(rows.compress(bytes(1 + side)) for _ in range(side)) + rows.flush()
    picture = b"\x89PNG\r\n\x1a\n"
    for kind, body in ((b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)), (b"IDAT", data)):
        picture += struct.pack(">I", len(body)) + kind + body
        picture += struct.pack(">I", zlib.crc32(kind + body))
    picture += struct.pack(">I", 0) + b"IEND" + struct.pack(">I", zlib.crc32(b"IEND"))
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    views = [
        {"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 24},
        {"buffer": 0, "byteOffset": 60, "byteLength": len(picture)},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
    ]
    part = {
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
        "targets": [{"POSITION": 0}],
        "material": 0,
    }
    tree = _tree(
        buffers=[{"byteLength": 60 + len(picture)}],
        bufferViews=views,
        accessors=accessors,
        meshes=[{"primitives": [part], "extras": {"targetNames": ["jawOpen"]}}],
        images=[{"bufferView": 2, "mimeType": "image/png"}],
        textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    )
    return tree, points + bytes(24) + picture


def repeated_channels() -> bytes:
    """An animation of 20,000 channels that all share 300,000 keys."""
    count = 300_000
    views = [{"buffer": 0, "byteLength": 4 * count}]
    accessor = {"bufferView": 0, "componentType": 5126, "count": count, "type": "SCALAR"}
    channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 4 * count}],
        "bufferViews": views,
        "accessors": [accessor, {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [
            {
                "primitives": [{"attributes": {"POSITION": 1}, "targets": [{"POSITION": 1}]}],
                "extras": {"targetNames": ["jawOpen"]},
            }
        ],
        "nodes": [{"mesh": 0}],
        "animations": [{"samplers": [{"input": 0, "output": 0}], "channels": [channel] * 20_000}],
    }
    return glb_bytes(tree, np.linspace(0, 5000, count, dtype="<f4").tobytes())


def wide_capture() -> str:
    """A capture of a million columns."""
    head, row = "Timecode,BlendShapeCount", "00:00:00:00.000,1"
    return f"{head}{',a' * 1_000_000}\n{row}{',0' * 1_000_000}\n"


def long_capture() -> str:
    """A capture of two rows, a day apart."""
    rows = "".join(f"{hour:02}:00:00:00.000,1,0.5\n" for hour in (0, 23))
    return f"Timecode,BlendShapeCount,JawOpen\n{rows}"


def wide_rig() -> str:
    """A rig of 60,000 controls, in less than a megabyte."""
    controls = "".join(f"c{n}=[0,0,1]\n" for n in range(60_000))
    poses = "".join(f"[poses.{name}]\nc0 = 0.5\n" for name in POSES)
    return f'name = "mine"\nspeech = ["c0"]\n[controls]\n{controls}{poses}'


def many_edits() -> str:
    """Edits of 40,000 curves of a whole line."""
    edit = {"channel": "jawOpen", "kind": "offset", "start": 0, "end": 4, "fade": [0, 0], "keys": [[0, 0.1]]}
    tree = {"format": "phonanim edits 1", "rig": "arkit", "error": 0.01, "phones": [["AA", 0.0, 1.0]]}
    return json.dumps({**tree, "edits": [edit] * 40_000})


def many_cues() -> str:
    """Subtitles of 100,000 cues."""
    return "".join(
        f"{n}\n00:{n // 60 % 60:02}:{n % 60:02},000 --> 00:{n // 60 % 60:02}:{n % 60:02},900\nso\n\n"
        for n in range(100_000)
    )


def nested_usd() -> str:
    """A stage of 20,000 scopes, each in the one before."""
    return "#usda 1.0\n" + "".join(f'def Scope "a{n}" {{\n' for n in range(20_000)) + "}\n" * 20_000


WORDS = '{"words": [%s]}'
GROWING: dict[str, Craft] = {
    "take: an archive that lies about its size": lying_archive,
    "alignment: 60,000 unknown labels": _animate(
        "a.TextGrid",
        lambda: _textgrid(_distinct(60_000), 0.05),
        "--on-unknown-label",
        "nearest",
        "--language",
        "english",
    ),
    "alignment: 60,000 labels of no language": _animate(
        "a.TextGrid", lambda: _textgrid(_distinct(60_000), 0.05), "--on-unknown-label", "silence"
    ),
    "alignment: a label of a million letters": _animate("a.TextGrid", lambda: _textgrid(["a" * 10**6], 1.0)),
    "alignment: a million marks on a letter": _animate(
        "a.TextGrid", lambda: _textgrid(["a" + "\u0303\u0330" * 500_000], 1.0), "--language", "ipa"
    ),
    "alignment: 100,000 phones in a second": _animate(
        "a.TextGrid", lambda: _textgrid(["AA1", "S"] * 50_000, 0.00001).replace("0.000 ", "0.0 ")
    ),
    "alignment: 200,000 tiers": _animate(
        "a.TextGrid",
        lambda: (
            'File type = "ooTextFile"\nObject class = "TextGrid"\n0 1 <exists> 200000\n'
            + '"IntervalTier" "a" 0 1 1\n0 1 "s"\n' * 200_000
        ),
    ),
    "alignment: 100,000 words that no dictionary has": _animate(
        "a.json",
        lambda: (
            WORDS
            % ", ".join(
                f'{{"word": "{word}", "start": {n * 0.05:.2f}, "end": {n * 0.05 + 0.04:.2f}}}'
                for n, word in enumerate(_distinct(100_000))
            )
        ),
    ),
    "alignment: 100,000 subtitles": _animate("a.srt", many_cues),
    "alignment: YAML that merges itself": _animate(
        "a.ustx",
        lambda: "ustx_version: '0.6'\na: &a {x: 1}\nb: &b {<<: *a}\nvoice_parts: [{notes: *b}]\n" * 2000,
    ),
    "alignment: XML of one long attribute": _animate(
        "a.xml", lambda: f'<?xml version="1.0"?><timing a="{"x" * 9_000_000}"/>'
    ),
    "aside: 700,000 pronunciations": _option("--lexicon", "l.dict", lambda: "so S OW1\n" * 700_000),
    "aside: 300,000 emotions": _option(
        "--emotion", "e.csv", lambda: "emotion,weight,start,end\n" + "joy,1,0,1\n" * 190_000
    ),
    "aside: 40,000 edits": _option("--edits", "e.json", many_edits),
    "aside: an overlay of 300,000 frames": _option(
        "--overlay",
        "p.json",
        lambda: json.dumps({f"c{n}": 0.5 for n in range(300_000)}),
    ),
    "rig: 60,000 controls": _option("--rig", "r.toml", wide_rig),
    "take: a million columns": _convert("a.csv", wide_capture),
    "take: two frames a day apart": _convert("a.csv", long_capture),
    "take: 20,000 channels of the same keys": _convert("a.glb", repeated_channels),
    "take: 20,000 scopes": _convert("a.usda", nested_usd),
    "take: a million names": _convert(
        "a.json",
        lambda: json.dumps({"fps": 25, "rig": "arkit", "curves": {f"c{n}": [0, 0] for n in range(400_000)}}),
    ),
    "take: a motion of four billion keys": _convert(
        "a.vmd", lambda: b"Vocaloid Motion Data 0002".ljust(50, b"\0") + b"\xff" * 8
    ),
    "character: 2000 targets of the same points": _character(shared_targets),
    "character: 2000 targets to a rig": _character(shared_targets, "rig", "fit", "c.glb", "-o", "m.toml"),
    "character: 1000 nodes of the same mesh": _character(shared_meshes),
    "character: 1000 nodes to a rig": _character(shared_meshes, "rig", "fit", "c.glb", "-o", "m.toml"),
    "character: values that are not stored": _character(sparse_accessor),
    "character: 19,000 nodes deep": _character(deep_nodes, "rig", "fit", "c.glb", "-o", "m.toml"),
    "character: a texture of 900 million pixels": _character(
        large_picture, "animate", str(LINE), "-o", "o.glb", "--character", "c.glb", "--sheet", "o.png"
    ),
}
