"""Models, takes, characters and recordings whose headers lie: offsets, sizes, names and counts."""

from __future__ import annotations

import json
import shutil
import struct
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.hostile import LINE, Attack, Samples, small_character
from phonanim.core.catalog import SHIPPED as MODELS
from phonanim.media.glb import glb_bytes, parse_glb, read_glb
from phonanim.rig.head import SHIPPED as HEAD

Craft = Callable[[Samples, Path], Attack]
HUGE = 2**63 - 1


def _model(header: dict[str, Any], length: int | None = None, name: str = "weights") -> Craft:
    """A model whose tensors have a header of the attacker."""

    def craft(samples: Samples, folder: Path) -> Attack:
        shutil.copytree(MODELS / "default", folder / "m")
        text = json.dumps(header).encode()
        count = len(text) if length is None else length
        (folder / f"m/{name}.safetensors").write_bytes(count.to_bytes(8, "little") + text + bytes(64))
        return ["animate", str(LINE), "-o", "o.json", "--fps", "25", "--model", "m"]

    return craft


def _tensor(*offsets: int, shape: tuple[int, ...] = (4,), kind: str = "F32") -> dict[str, Any]:
    return {"dtype": kind, "shape": list(shape), "data_offsets": list(offsets)}


def _archive(entries: list[tuple[str, bytes]], encrypted: bool = False) -> Craft:
    """A take in an archive with these files."""

    def craft(samples: Samples, folder: Path) -> Attack:
        path = folder / "a.npz"
        with warnings.catch_warnings(), zipfile.ZipFile(path, "w") as archive:
            warnings.simplefilter("ignore")  # of names that repeat
            for name, data in entries:
                archive.writestr(name, data)
        if encrypted:
            data = bytearray(path.read_bytes())
            for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
                at = data.find(mark)
                while at >= 0:
                    data[at + place] |= 1
                    at = data.find(mark, at + 1)
            path.write_bytes(data)
        return ["convert", "a.npz", "-o", "o.csv"]

    return craft


def _character(change: Callable[[dict[str, Any]], None], *command: str) -> Craft:
    """A character whose tree is changed."""

    def craft(samples: Samples, folder: Path) -> Attack:
        glb = parse_glb(small_character(), "c.glb")
        change(glb.tree)
        (folder / "c.glb").write_bytes(glb_bytes(glb.tree, glb.binary))
        show = ["convert", str(samples.folder / "a.npz"), "-o", "o.html", "--character", "c.glb"]
        return list(command) or show

    return craft


def _accessor(**facts: Any) -> Craft:
    return _character(lambda tree: tree["accessors"][0].update(facts))


def _view(**facts: Any) -> Craft:
    return _character(lambda tree: tree["bufferViews"][0].update(facts))


def textured_head(*pictures: bytes) -> bytes:
    """The shipped head, whose skin has each of these pictures as a texture of one of its materials."""
    glb = read_glb(HEAD)
    tree, binary = glb.tree, glb.binary
    parts = [part for mesh in tree["meshes"] for part in mesh["primitives"]]
    tree |= {"images": [], "textures": []}
    for number, data in enumerate(pictures):
        part = parts[number % len(parts)]
        points = tree["accessors"][part["attributes"]["POSITION"]]["count"]
        for body in (bytes(8 * points), data):
            tree["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(body)})
            binary += body + bytes(-len(body) % 4)
        view = len(tree["bufferViews"])
        tree["accessors"].append(
            {"bufferView": view - 2, "componentType": 5126, "count": points, "type": "VEC2"}
        )
        tree["images"].append({"bufferView": view - 1, "mimeType": "image/png"})
        tree["textures"].append({"source": number})
        surface = {"pbrMetallicRoughness": {"baseColorTexture": {"index": number}}}
        tree["materials"].append(surface)
        part["attributes"]["TEXCOORD_0"] = len(tree["accessors"]) - 1
        part["material"] = len(tree["materials"]) - 1
    tree["buffers"][0]["byteLength"] = len(binary)
    return glb_bytes(tree, binary)


def _picture(*pictures: bytes) -> Craft:
    """A character whose pictures are not what they say."""

    def craft(samples: Samples, folder: Path) -> Attack:
        (folder / "c.glb").write_bytes(textured_head(*pictures))
        return [
            "animate",
            str(LINE),
            "-o",
            "o.glb",
            "--fps",
            "25",
            "--character",
            "c.glb",
            "--sheet",
            "o.png",
        ]

    return craft


def _wave(header: bytes, data: bytes = bytes(3200)) -> Craft:
    """A recording beside a line."""

    def craft(samples: Samples, folder: Path) -> Attack:
        shutil.copy(LINE, folder / "a.TextGrid")
        (folder / "a.wav").write_bytes(header + data)
        return ["animate", "a.TextGrid", "-o", "o.html", "--fps", "25"]

    return craft


def _riff(
    channels: int = 1,
    rate: int = 16000,
    bits: int = 16,
    size: int = 3200,
    kind: int = 1,
    align: int = 2,
    whole: int = 0,
) -> bytes:
    form = struct.pack("<HHIIHH", kind, channels, rate, (rate * align) % 2**32, align, bits)
    return (
        b"RIFF"
        + struct.pack("<I", whole or 36 + min(size, 2**31))
        + b"WAVEfmt "
        + struct.pack("<I", 16)
        + form
        + b"data"
        + struct.pack("<I", size)
    )


def _png(width: int, height: int, bits: int = 8) -> bytes:
    return (
        b"\x89PNG\r\n\x1a\n"
        + struct.pack(">I4sIIBBBBB", 13, b"IHDR", width, height, bits, 2, 0, 0, 0)
        + bytes(4)
    )


JPEG = b"\xff\xd8\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03\x01\x22\x00\x02\x11\x01\x03\x11\x01\xff\xd9"
SPARSE = {"count": 3, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}
ARRAY = (
    b"\x93NUMPY\x01\x00v\x00"
    + b"{'descr': '<f4', 'fortran_order': False, 'shape': (2,)}".ljust(117)
    + b"\n"
    + bytes(8)
)

ACCESSORS: tuple[tuple[str, Any], ...] = (
    ("count", 0),
    ("count", -1),
    ("count", HUGE),
    ("byteOffset", HUGE),
    ("byteOffset", -4),
    ("byteOffset", 2),
    ("componentType", 5120),
    ("type", "MAT4"),
    ("bufferView", -1),
    ("bufferView", 9),
    ("sparse", SPARSE),
    ("sparse", {**SPARSE, "count": 10**10}),
)
VIEWS: tuple[tuple[str, Any], ...] = (
    ("byteStride", 4),
    ("byteStride", 0),
    ("byteStride", -12),
    ("byteStride", 13),
    ("byteStride", HUGE),
    ("byteOffset", HUGE),
    ("byteLength", -1),
    ("byteLength", HUGE),
    ("buffer", 7),
)
ARCHIVES: dict[str, Craft] = {
    "model: tensors that overlap": _model({"a": _tensor(0, 16), "b": _tensor(8, 24)}),
    "model: a tensor beyond the end": _model({"a": _tensor(0, 2**40, shape=(2**38,))}),
    "model: a tensor before the start": _model({"a": _tensor(-16, 0)}),
    "model: a tensor of the wrong size": _model({"a": _tensor(0, 16, shape=(2**62, 4))}),
    "model: a tensor of no known type": _model({"a": _tensor(0, 16, kind="OBJ")}),
    "model: a header without end": _model({}, HUGE),
    "model: a header of nothing": _model({}, 0),
    "model: a face without tensors": _model({}, name="face"),
    "take: names with folders": _archive([("../victim.npy", ARRAY), ("/etc/x.npy", ARRAY)]),
    "take: names that repeat": _archive([("values.npy", ARRAY), ("values.npy", ARRAY)]),
    "take: an archive that is encrypted": _archive([("values.npy", ARRAY)], encrypted=True),
    "take: 50,000 empty files": _archive([(f"{n}.npy", b"") for n in range(50_000)]),
    **{f"character: an accessor, {name} {value}": _accessor(**{name: value}) for name, value in ACCESSORS},
    **{f"character: a view, {name} {value}": _view(**{name: value}) for name, value in VIEWS},
    "character: a PNG of 2 billion rows": _picture(_png(2**31 - 1, 2**31 - 1)),
    "character: a PNG of no rows": _picture(_png(0, 0)),
    "character: a JPEG of 65,535 rows": _picture(JPEG),
    "character: a picture that is a film": _picture(b"\0\0\0\x18ftypmp42\0\0\0\0mp42isom" + bytes(100)),
    "character: a picture that is a playlist": _picture(b"#EXTM3U\n#EXTINF:1,\nfile:///etc/passwd\n"),
    "sound: 65,535 channels": _wave(_riff(channels=65535, align=65535)),
    "sound: no channels": _wave(_riff(channels=0, align=0)),
    "sound: no bits": _wave(_riff(bits=0)),
    "sound: 4 billion samples a second": _wave(_riff(rate=2**32 - 1)),
    "sound: 4 GB that are not there": _wave(_riff(size=2**32 - 2)),
    "sound: an unknown kind": _wave(_riff(kind=0x1234)),
    "sound: numbers that are none": _wave(_riff(kind=3, bits=32, align=4), b"\xff\xff\xff\x7f" * 800),
    "sound: nothing": _wave(b"", b""),
    "sound: a header alone": _wave(_riff(), b""),
}
