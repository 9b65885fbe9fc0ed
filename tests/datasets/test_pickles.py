"""Pickles of data sets: real content comes through, a hostile file ends in one line."""

import io
import pickle
import struct
import subprocess
import sys

import numpy as np
import pytest

from phonanim.datasets._pickles import read_pickle
from phonanim.errors import CorpusError


def read(tmp_path, data):
    (tmp_path / "a.pkl").write_bytes(data)
    return read_pickle(tmp_path / "a.pkl")


def refused(tmp_path, data, message=""):
    with pytest.raises(
        CorpusError, match=r"a\.pkl: cannot be read as a pickle of arrays: .*" + message
    ) as caught:
        read(tmp_path, data)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("protocol", range(6))
def test_arrays_of_numbers_come_through(tmp_path, protocol):
    kept = {
        "grid": np.arange(12, dtype=">f4").reshape(3, 4),
        "columns": np.asfortranarray(np.arange(6).reshape(2, 3)),
        "empty": np.zeros((0, 3), np.int16),
        "flags": np.array([True, False]),
        "texts": np.array(["a", "bc"]),
        "scalar": np.float64(0.5),
        "list": [1, 2.5, "ä", None, (3, 4)],
    }
    found = read(tmp_path, pickle.dumps(kept, protocol=protocol))
    for name in ("grid", "columns", "empty", "flags", "texts"):
        np.testing.assert_array_equal(found[name], kept[name])
        assert found[name].dtype == kept[name].dtype
    assert found["scalar"] == 0.5
    assert found["list"] == kept["list"]


def global_(module, name):
    return b"c" + module + b"\n" + name + b"\n"


def test_an_array_of_objects_over_the_bytes_of_the_file_is_refused(tmp_path):
    pointers = struct.pack("<2Q", 0x4141414141414141, 0x4242424242424242)
    shape = b"(I2\nt"
    payload = b"C" + bytes([len(pointers)]) + pointers
    call = global_(b"numpy", b"ndarray") + b"(" + shape + b"X\x01\x00\x00\x00O" + payload + b"tR."
    refused(tmp_path, b"\x80\x03" + call, "numpy.ndarray")
    made = global_(b"numpy", b"ndarray") + b"(" + shape + b"t\x81."
    refused(tmp_path, b"\x80\x03" + made, "numpy.ndarray")


@pytest.mark.parametrize("name", ["O", "O8", "V8", "object", "i4,O", "f99999999999", ""])
def test_a_dtype_of_anything_but_numbers_is_refused(tmp_path, name):
    text = b"X" + struct.pack("<I", len(name)) + name.encode()
    refused(tmp_path, b"\x80\x03" + global_(b"numpy", b"dtype") + b"(" + text + b"\x89\x88tR.")


def test_the_state_of_a_dtype_cannot_smuggle_in_fields(tmp_path):
    class State:
        def __reduce__(self):
            return np.dtype, ("i8", False, True), (3, "<", None, ("x",), {"x": (np.dtype("O"), 0)}, 8, 8, 0)

    stream = io.BytesIO()
    pickle.Pickler(stream, protocol=2).dump({"a": np.arange(2), "b": State()})
    refused(tmp_path, stream.getvalue())


def test_bytes_that_do_not_fill_the_shape_are_refused(tmp_path):
    data = pickle.dumps(np.arange(4, dtype=np.int64), protocol=2).replace(b"K\x04", b"K\x40")
    refused(tmp_path, data, "bytes for an array of shape")


def test_one_list_in_many_places_is_finished_once(tmp_path):
    value: list = ["end"]
    for _ in range(40):
        value = [value, value]
    assert read(tmp_path, pickle.dumps(value))[0] is not None


def test_depth_memory_and_steps_are_bounded(tmp_path, monkeypatch):
    deep: list = []
    for _ in range(60):
        deep = [deep]
    refused(tmp_path, pickle.dumps(deep), "nests more than 50")
    refused(tmp_path, b"\x80\x02Nr\xff\xff\xff\x7f.", "stores item")
    refused(tmp_path, b"\x80\x04\x8e" + struct.pack("<Q", 1 << 40) + b"x.")
    monkeypatch.setattr("phonanim.datasets._pickles.MOST_STEPS", 10)
    refused(tmp_path, pickle.dumps(list(range(100))), "more than 10 steps")


def test_a_name_alone_is_no_content(tmp_path):
    refused(tmp_path, b"\x80\x02" + global_(b"_codecs", b"encode") + b".", "not a number, a text or an array")
    refused(tmp_path, b"\x80\x02" + global_(b"numpy.core.multiarray", b"_reconstruct") + b".")
    refused(tmp_path, b"\x80\x02" + global_(b"os", b"system") + b".", "it tries to run os.system")


def texted(text):
    return b"X" + struct.pack("<I", len(text)) + text.encode()


@pytest.mark.parametrize(
    ("name", "field", "value"),
    [
        ((b"_codecs", b"encode"), "__defaults__", texted("ascii") + b"\x85"),
        ((b"numpy", b"ndarray"), "__new__", global_(b"_codecs", b"encode")),
    ],
)
def test_a_constructor_takes_no_state_from_a_file(tmp_path, name, field, value):
    state = b"N}" + texted(field) + value + b"s\x86"
    refused(tmp_path, b"\x80\x03" + global_(*name) + state + b"b0N.", "a state to something that has none")
    assert read(tmp_path, pickle.dumps(np.arange(3), protocol=2)).tolist() == [0, 1, 2]
    refused(tmp_path, b"\x80\x03" + global_(b"numpy", b"ndarray") + b")R.", "numpy.ndarray")


@pytest.mark.parametrize(
    "key", [b"\x8a\x09" + bytes(7) + b"\x00\x10", b"J\xff\xff\xff\xffJ\xfe\xff\xff\xff\x86"]
)
def test_keys_that_may_all_have_one_hash_are_refused(tmp_path, key):
    for pairs in (b"}(" + key + b"Nu.", b"}" + key + b"Ns.", b"(" + key + b"Nd."):
        refused(tmp_path, b"\x80\x03" + pairs, "with a key of (int|tuple)")
    pairs = global_(b"collections", b"OrderedDict") + b"]" + key + b"N\x86a\x85R."
    refused(tmp_path, b"\x80\x03" + pairs, "with a key of (int|tuple)")


def test_bytes_that_are_made_into_arrays_again_and_again_are_counted(tmp_path):
    content = b"B" + struct.pack("<I", 1 << 16) + bytes(1 << 16) + b"q\x000"
    kind = global_(b"numpy", b"dtype") + texted("u1") + b"\x85Rq\x010"
    make = global_(b"numpy.core.numeric", b"_frombuffer") + b"(h\x00h\x01J\x00\x00\x01\x00\x85tR0"
    assert read(tmp_path, b"\x80\x03" + content + kind + make * 3 + b"N.") is None
    refused(tmp_path, b"\x80\x03" + content + kind + make * 1000 + b"N.", "makes much more than it holds")


def test_sets_and_names_in_several_lines_are_refused(tmp_path):
    refused(tmp_path, b"\x80\x04\x8f.", "that a pickle of arrays does not need")
    refused(
        tmp_path, b"\x80\x04" + texted("o\ns") + texted("system") + b"\x93.", "it tries to run o s.system"
    )


FUZZ = """
import random, sys, pathlib, pickle
import numpy as np
from phonanim.datasets._pickles import read_pickle
from phonanim.errors import CorpusError
rng, path = random.Random(int(sys.argv[2])), pathlib.Path(sys.argv[1])
seeds = [pickle.dumps({"a": np.arange(5.0), "b": [np.float32(1), ("x", 2)]}, protocol=p) for p in range(6)]
names = [b"cnumpy\\nndarray\\n", b"cnumpy\\ndtype\\n", b"R", b"b", b"\\x81", b"(", b"t", b"."]
for _ in range(400):
    data = bytearray(rng.choice(seeds))
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(data))
        if rng.random() < 0.3:
            data[at:at] = rng.choice(names)
        else:
            data[at] = rng.randrange(256)
    path.write_bytes(bytes(data))
    try:
        read_pickle(path)
    except CorpusError:
        pass
"""


def test_damaged_pickles_never_crash_the_process(tmp_path):
    for seed in ("1", "2"):
        code = [sys.executable, "-c", FUZZ, str(tmp_path / "a.pkl"), seed]
        done = subprocess.run(code, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-500:]
