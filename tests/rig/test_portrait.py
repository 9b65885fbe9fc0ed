"""Characters are drawn with their hair and textures, from the front, framed on the face."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from animations import line
from conventions import write_convention

from phonanim.errors import RigError
from phonanim.media.glb import Glb, glb_bytes, read_glb
from phonanim.rig import textures
from phonanim.rig.character import load_dressed_character
from phonanim.rig.head import load_head
from phonanim.rig.portrait import FACE, load_portrait
from phonanim.rig.render import render
from phonanim.rig.textures import decode_picture, linear_light
from phonanim.viewer.sheet import save_sheet

MOUTH = ("jawOpen", "mouthFunnel", "eyeBlinkLeft")


def turned(path: Path, **changes: Any) -> Path:
    """A character whose node has other properties."""
    glb = read_glb(path)
    glb.tree["nodes"][0] |= changes
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    return path


@pytest.fixture
def hero(tmp_path: Path) -> Path:
    return write_convention("BS_", tmp_path / "hero.glb")


@pytest.mark.parametrize(
    "changes",
    [{}, {"rotation": [0, 1, 0, 0]}, {"rotation": [0, 2**-0.5, 0, 2**-0.5]}, {"scale": [100.0] * 3}],
)
def test_the_face_is_in_front_at_any_size(hero, changes):
    portrait = load_portrait(turned(hero, **changes), MOUTH, 64, 64, 0.0)
    view, points = portrait.view, portrait.head.vertices
    plain = load_portrait(write_convention("BS_", hero), MOUTH, 64, 64, 0.0)
    assert view.span == pytest.approx(plain.view.span, rel=1e-3)
    assert FACE < view.span < 3 * FACE
    np.testing.assert_allclose(points - view.centre, plain.head.vertices - plain.view.centre, atol=1e-4)


def test_what_is_far_from_the_face_is_not_drawn(hero):
    assert np.ptp(load_portrait(hero, MOUTH, 64, 64, 0.0).head.vertices[:, 1]) < 6 * FACE


def test_meshes_without_shapes_are_worn(tmp_path, hero):
    glb = read_glb(hero)
    mesh = {
        "primitives": [{k: v for k, v in glb.tree["meshes"][0]["primitives"][0].items() if k != "targets"}]
    }
    glb.tree["meshes"].append(mesh)
    glb.tree["nodes"].append({"name": "hair", "mesh": 1, "translation": [0, 0.01, 0]})
    hero.write_bytes(glb_bytes(glb.tree, glb.binary))
    head = load_dressed_character(hero)
    assert len(head.vertices) > len(load_head().vertices)
    assert "hair." in " ".join(head.parts)


def painted(hero: Path, picture: bytes, material: dict[str, Any], webp: bool = False) -> int:
    """Give the skin of a character a picture, at one place for all of its points; return their number."""
    glb = read_glb(hero)
    count = len(load_head().vertices[load_head().parts["skin"]])
    places = np.full((count, 2), 0.5, "<f4").tobytes()
    tree, start = glb.tree, len(glb.binary) + -len(glb.binary) % 4
    tree["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": len(places)},
        {"buffer": 0, "byteOffset": start + len(places), "byteLength": len(picture)},
    ]
    views = len(tree["bufferViews"])
    tree["accessors"].append({"bufferView": views - 2, "componentType": 5126, "count": count, "type": "VEC2"})
    skin = tree["meshes"][0]["primitives"][0]
    skin["attributes"]["TEXCOORD_0"] = len(tree["accessors"]) - 1
    texture = {"extensions": {"EXT_texture_webp": {"source": 0}}} if webp else {"source": 0}
    tree |= {"images": [{"bufferView": views - 1, "mimeType": "image/png"}], "textures": [texture]}
    tree["materials"][skin["material"]] |= {
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        **material,
    }
    data = glb.binary.ljust(start, b"\0") + places + picture
    tree["buffers"] = [{"byteLength": len(data)}]
    hero.write_bytes(glb_bytes(tree, data))
    return count


def picture_of(color: tuple[int, ...], kind: str = "PNG") -> bytes:
    images = pytest.importorskip("PIL.Image")
    stream = io.BytesIO()
    images.fromarray(np.full((4, 4, len(color)), color, np.uint8)).save(stream, kind)
    return stream.getvalue()


@pytest.mark.parametrize("kind", ["PNG", "WEBP"])
def test_a_texture_colours_the_points(hero, kind):
    count = painted(hero, picture_of((255, 0, 0), kind), {}, webp=kind == "WEBP")
    colors = load_dressed_character(hero).colors[:count]
    np.testing.assert_allclose(colors, np.broadcast_to([1.0, 0, 0], (count, 3)), atol=0.01)


def test_glass_is_not_drawn(hero):
    """A clear surface in front of eyes would hide them; one that is declared opaque is drawn."""
    solid = len(load_dressed_character(hero).triangles)
    skin = int((load_head().triangles < load_head().parts["skin"].stop).all(axis=1).sum())
    painted(hero, picture_of((9, 9, 9, 40)), {"alphaMode": "BLEND"})
    assert len(load_dressed_character(hero).triangles) == solid - skin
    painted(write_convention("BS_", hero), picture_of((9, 9, 9, 40)), {})
    assert len(load_dressed_character(hero).triangles) == solid


def test_pictures_are_decoded_or_left():
    picture = decode_picture(picture_of((255, 0, 0)))
    assert picture is not None
    np.testing.assert_array_equal(linear_light(picture), np.broadcast_to([1.0, 0, 0, 1], (4, 4, 4)))
    assert decode_picture(b"\x89PNG nothing") is None
    assert decode_picture(picture_of((255, 0, 0)), most=15) is None


def test_the_pixels_of_all_pictures_of_a_character_are_bounded(monkeypatch):
    asked = []
    monkeypatch.setattr(textures, "decode_picture", lambda data, most: asked.append(most))
    for count in (1, 12, 48, 2000):
        tree = {"images": [{"bufferView": 0}] * count, "bufferViews": [{"byteLength": 1}]}
        for number in (*range(-count, 0), *range(count)):
            textures._picture(Glb(tree, b"a", "a.glb"), number)
        assert sum(asked) <= 12 * 8192 * 8192
        assert len(asked) == min(count, 64)
        asked.clear()


def test_a_sheet_shows_the_character(tmp_path, hero):
    animation = replace(line(), phones=line().phones[:2])
    save_sheet(animation, tmp_path / "shipped.png", size=64)
    save_sheet(animation, tmp_path / "hero.png", hero, size=64)
    assert (tmp_path / "shipped.png").read_bytes() != (tmp_path / "hero.png").read_bytes()
    portrait = load_portrait(hero, animation.channels, 64, 64, 0.0)
    picture = render(portrait.head.vertices, portrait.head, portrait.view).astype(int)
    assert np.abs(picture[32, 32] - picture[0, 0]).max() > 50


def test_a_character_without_the_channels(hero):
    with pytest.raises(RigError, match=r"hero\.glb: has no morph target named like x \.\.\."):
        load_portrait(hero, ("x",), 64, 64, 0.0)
