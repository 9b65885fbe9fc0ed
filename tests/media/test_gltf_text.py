import json
from pathlib import Path

import numpy as np
import pytest
from animations import line

from phonanim.errors import RigError
from phonanim.exporters import load, save
from phonanim.media.glb import glb_bytes, parse_glb, read_glb
from phonanim.media.gltf_text import data_uri
from phonanim.rig.head import SHIPPED, load_head

PNG = b"\x89PNG\r\n\x1a\n picture"


def write_text_head(folder, **changes):
    """The shipped head as a `.gltf`, its data in two files, with a picture."""
    glb = read_glb(SHIPPED)
    half = glb.tree["bufferViews"][len(glb.tree["bufferViews"]) // 2]["byteOffset"]
    views = [
        {
            **v,
            "buffer": int(v["byteOffset"] >= half),
            "byteOffset": v["byteOffset"] % half if v["byteOffset"] < half else v["byteOffset"] - half,
        }
        for v in glb.tree["bufferViews"]
    ]
    (folder / "data").mkdir(exist_ok=True)
    (folder / "data" / "a b.bin").write_bytes(glb.binary[:half])
    (folder / "b.bin").write_bytes(glb.binary[half:])
    (folder / "skin.png").write_bytes(PNG)
    buffers = [
        {"uri": "data/a%20b.bin", "byteLength": half},
        {"uri": "b.bin", "byteLength": len(glb.binary) - half},
    ]
    tree = {**glb.tree, "bufferViews": views, "buffers": buffers, "images": [{"uri": "skin.png"}], **changes}
    path = folder / "head.gltf"
    path.write_text(json.dumps(tree))
    return path


def test_a_character_with_files_beside_it(tmp_path):
    path = write_text_head(tmp_path)
    np.testing.assert_array_equal(load_head(path).deltas, load_head().deltas)
    save(line(), tmp_path / "a.glb", character=path)
    np.testing.assert_allclose(load(tmp_path / "a.glb").values, line().values, atol=1e-5)
    glb = read_glb(tmp_path / "a.glb")
    (image,) = glb.tree["images"]
    view = glb.tree["bufferViews"][image["bufferView"]]
    assert glb.binary[view["byteOffset"] :][: view["byteLength"]] == PNG
    assert image["mimeType"] == "image/png"
    assert len(glb.tree["buffers"]) == 1


def test_what_is_written_holds_all_its_data(tmp_path):
    save(line(), tmp_path / "a.gltf")
    tree = json.loads((tmp_path / "a.gltf").read_text())
    assert [buffer["uri"][:5] for buffer in tree["buffers"]] == ["data:"]
    save(line(), tmp_path / "a.glb")
    assert read_glb(tmp_path / "a.gltf").binary == read_glb(tmp_path / "a.glb").binary
    packed = parse_glb(glb_bytes(read_glb(tmp_path / "a.gltf").tree, b""), "a")
    assert packed.tree["animations"] == read_glb(tmp_path / "a.glb").tree["animations"]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (
            {"buffers": [{"uri": "../head.bin"}]},
            r"is damaged: its file '\.\./head\.bin' is not in its folder",
        ),
        ({"buffers": [{"uri": "/etc/passwd"}]}, "is not in its folder"),
        ({"buffers": [{"uri": "http://127.0.0.1:1/a.bin"}]}, "is not in its folder"),
        ({"buffers": [{"uri": "c%3A%5Ca.bin"}]}, "is not in its folder"),
        ({"buffers": [{"uri": "none.bin"}]}, r"its file .*none\.bin cannot be read: No such file"),
        ({"buffers": [{"byteLength": 3}]}, "the uri of a buffer or an image is None; it is a text"),
        ({"buffers": [{"uri": "data:,abc"}]}, "a data URI in it is not base64"),
        ({"buffers": [{"uri": "data:x;base64,a"}]}, "a data URI in it is not base64: "),
        ({"buffers": []}, "is damaged: "),
        ({"buffers": 3}, "buffers is 3; it is a list"),
        ({"images": [{"uri": 3}]}, "the uri of a buffer or an image is 3"),
        ({"bufferViews": [{"extensions": {}}]}, "it has several buffers with compressed data"),
    ],
)
def test_files_that_are_not_read(tmp_path, changes, reason):
    with pytest.raises(RigError, match=rf"head\.gltf: .*{reason}"):
        read_glb(write_text_head(tmp_path, **changes))


def test_more_than_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr("phonanim.media.glb.MAX_BYTES", 1 << 21)
    content = data_uri(bytes(1 << 20))
    other = data_uri(b"x" + bytes(1 << 20))
    with pytest.raises(RigError, match=r"its buffers and images have more than 2 MB|it has more than 2 MB"):
        read_glb(write_text_head(tmp_path, images=[{"uri": content}, {"uri": other}]))


def test_a_file_that_many_name_is_read_once(tmp_path):
    glb = read_glb(write_text_head(tmp_path, images=[{"uri": "skin.png"}] * 1000))
    assert len(glb.binary) < SHIPPED.stat().st_size + 100
    assert (
        len({glb.tree["bufferViews"][image["bufferView"]]["byteOffset"] for image in glb.tree["images"]}) == 1
    )


def test_text_that_is_no_gltf(tmp_path):
    for text in ("[]", "{", "null"):
        Path(tmp_path / "a.gltf").write_text(text)
        with pytest.raises(RigError, match=r"a\.gltf: is damaged: "):
            read_glb(tmp_path / "a.gltf")
