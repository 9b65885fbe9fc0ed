import io
import json
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from phonanim.core import decode
from phonanim.core.decode import DecodeError
from phonanim.core.text import printable


def npy(array, header=None):
    stream = io.BytesIO()
    if header:
        np.lib.format.write_array_header_1_0(stream, header)
        return stream.getvalue() + array.tobytes()
    np.lib.format.write_array(stream, array, allow_pickle=True)
    return stream.getvalue()


def test_what_is_sound_is_read(tmp_path):
    (tmp_path / "a.json").write_text('{"a": [1, "\\ud83d\\ude00"]}')
    assert decode.read_json(tmp_path / "a.json") == {"a": [1, "\U0001f600"]}
    (tmp_path / "a.toml").write_text('\ufeffname = "a"\n', encoding="utf-8")
    assert decode.read_toml(tmp_path / "a.toml") == {"name": "a"}
    arrays = {"a": np.arange(6.0).reshape(2, 3), "b": np.asfortranarray(np.arange(6).reshape(2, 3))}
    arrays |= {"text": np.array("words"), "none": np.zeros((0, 3))}
    np.savez(tmp_path / "a.npz", **arrays)
    found = decode.read_arrays(tmp_path / "a.npz")
    assert found.keys() == arrays.keys()
    assert all(np.array_equal(found[name], arrays[name]) for name in arrays)
    np.save(tmp_path / "a.npy", arrays["b"])
    assert np.array_equal(decode.read_array(tmp_path / "a.npy"), arrays["b"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "it is not JSON: Expecting property name"),
        ("[NaN]", "it is not JSON: it has NaN, which is not a number"),
        ("[" * 100_000, "it is not JSON: it is nested deeper than 64 levels"),
        ("[" * 70 + "]" * 70, "it is nested deeper than 64 levels"),
        ('["\\ud800"]', r"it holds half a character, \\ud800"),
        ("1" * 5000, "it is not JSON: Exceeds the limit"),
    ],
)
def test_json_that_nobody_means(text, message):
    with pytest.raises(DecodeError, match=message):
        decode.parse_json(text)
    with pytest.raises(DecodeError, match=message):
        decode.parse_json(text.encode())


def test_depth_is_bounded_exactly():
    tree = json.loads("[" * 64 + "]" * 64)
    decode.check_depth(tree)
    with pytest.raises(DecodeError, match="nested deeper than 64 levels"):
        decode.check_depth([tree])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"a = ", "it is not TOML: Invalid value"),
        (b"a = " + b"[" * 5000, "it is not TOML: it is nested deeper than 64 levels"),
        (b"[" + b".".join([b"a"] * 100) + b"]", "it is nested deeper than 64 levels"),
        (b"\xff", r"it is not UTF-8 text \(byte 0\)"),
        (b"#" * (1 << 20) + b"#", "it has more than 1 MB"),
    ],
)
def test_toml_that_nobody_means(tmp_path, text, message):
    (tmp_path / "a.toml").write_bytes(text)
    with pytest.raises(DecodeError, match=message):
        decode.read_toml(tmp_path / "a.toml")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "it has no array of numbers"),
        (npy(np.array([{}])), "its array has objects; store numbers"),
        (
            npy(np.zeros(2), {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}),
            r"its array of \(1000000000000,\) values is truncated",
        ),
        (
            npy(np.zeros(2), {"descr": "<f8", "fortran_order": False, "shape": (-1, -2)}),
            "is truncated",
        ),
        (npy(np.zeros(2), {"descr": "(((", "fortran_order": False, "shape": (2,)}), "no array of numbers"),
        (npy(np.zeros(3))[:-1], r"its array of \(3,\) values is truncated"),
    ],
)
def test_arrays_that_are_none(tmp_path, data, message):
    with pytest.raises(DecodeError, match=message):
        decode.parse_array(data)
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("a.npy", data)
    with pytest.raises(DecodeError, match=message):
        decode.read_arrays(tmp_path / "a.npz")


def test_an_archive_that_unpacks_to_too_much_is_not_unpacked(tmp_path, monkeypatch):
    np.savez_compressed(tmp_path / "a.npz", a=np.zeros(1 << 20))
    monkeypatch.setattr(decode, "MAX_UNPACKED", 1 << 20)
    with pytest.raises(DecodeError, match="it unpacks to more than 1 MB"):
        decode.read_arrays(tmp_path / "a.npz")
    (tmp_path / "b.npz").write_bytes((tmp_path / "a.npz").read_bytes()[:-40])
    with pytest.raises(DecodeError, match="it is not an archive of arrays"):
        decode.read_arrays(tmp_path / "b.npz")


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_an_archive_that_lies_about_its_size_is_not_unpacked(tmp_path, method):
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w", method) as archive:
        archive.writestr("a.npy", bytes(1 << 26))
    data = path.read_bytes()
    real = (1 << 26).to_bytes(4, "little")
    assert data.count(real) == 2
    path.write_bytes(data.replace(real, (1000).to_bytes(4, "little")))
    tracemalloc.start()
    with pytest.raises(DecodeError, match=r"Bad CRC-32|packed in another way"):
        decode.read_arrays(path)
    assert tracemalloc.get_traced_memory()[1] < 1 << 23
    tracemalloc.stop()


def test_an_array_is_mapped_where_it_is_one(tmp_path):
    np.save(tmp_path / "a.npy", np.arange(6.0).reshape(2, 3))
    assert decode.map_array(tmp_path / "a.npy").tolist() == [[0, 1, 2], [3, 4, 5]]
    np.savez(tmp_path / "b.npy.npz", a=np.zeros(2))
    (tmp_path / "c.npy").write_bytes((tmp_path / "a.npy").read_bytes()[:-8])
    for name in ("b.npy.npz", "c.npy", "../../dev/zero"):
        with pytest.raises((DecodeError, FileNotFoundError)):
            decode.map_array(tmp_path / name)
    with pytest.raises(DecodeError, match="a pipe or a device"):
        decode.map_array(Path("/dev/zero"))


@pytest.mark.parametrize("name", ["", "..", "../a", "a/b", "/a", "a\0b", 5, None])
def test_parts_of_paths(name):
    assert decode.decode_part("take 1: 3", "clip") == "take 1: 3"
    with pytest.raises(DecodeError, match="clip is .*; it is a name without a folder"):
        decode.decode_part(name, "clip")


def test_an_array_that_is_no_plain_file_is_not_read():
    with pytest.raises(DecodeError, match="it is a pipe or a device"):
        decode.read_array(Path("/dev/zero"))
    with pytest.raises(DecodeError, match="it has no tensors: it is a pipe or a device"):
        decode.read_tensors(Path("/dev/zero"))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e300, -1, 0, True, "30", None, [30]])
def test_rates_that_nobody_films_at(value):
    with pytest.raises(DecodeError, match=r"fps is .*; it is a number from 0.001 to 1000"):
        decode.decode_rate(value)


def test_values_of_other_types():
    assert decode.decode_number(np.float32(0.5), "a") == 0.5
    with pytest.raises(DecodeError, match="a is list; it is a table"):
        decode.decode_table([], "a")
    with pytest.raises(DecodeError, match="a is 'no'; it is a list"):
        decode.decode_list("no", "a")
    with pytest.raises(DecodeError, match="a is None; it is a text"):
        decode.decode_text(None, "a")


@pytest.mark.parametrize(
    "name", ["http://127.0.0.1/a.wav", "../a.wav", "/etc/passwd", "C:a.wav", "..\\a.wav", "..", ".", "", 3]
)
def test_names_that_lead_elsewhere(name):
    with pytest.raises(DecodeError, match="audio is .*; it is the plain name of a file beside this one"):
        decode.decode_file_name(name, "audio")


def test_names_that_are_not_utf8_are_printed():
    assert decode.decode_file_name("a b.wav", "audio") == "a b.wav"
    assert printable("a\udcff.wav") == "a\\udcff.wav"
