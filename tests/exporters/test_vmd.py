import shutil
import struct
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from animations import line, vowels

from phonanim.errors import OutputError
from phonanim.exporters import load, save
from phonanim.rig.neck import TURNS

LATE = 54 + 111 * 61 + 4 + 15  # where the frame of the first morph is written
TURN = 54 + 15 + 4 + 12  # where the first rotation of the head is written
NODE = shutil.which("node")


@pytest.fixture
def motion(tmp_path):
    path = tmp_path / "a.vmd"
    save(vowels(fps=30), path)
    return path


def morphs(path):
    """Every key of a morph, by the layout of the format: (name, frame, weight)."""
    data = path.read_bytes()
    assert data[:30] == b"Vocaloid Motion Data 0002" + bytes(5)
    (bones,) = struct.unpack_from("<I", data, 50)
    at = 54 + 111 * bones
    (count,) = struct.unpack_from("<I", data, at)
    assert len(data) == at + 4 + 23 * count + 16
    rows = [struct.unpack_from("<15sIf", data, at + 4 + 23 * n) for n in range(count)]
    return [(name.rstrip(b"\0").decode("cp932"), frame, weight) for name, frame, weight in rows]


def test_morphs_have_japanese_names_and_frames(motion):
    found = morphs(motion)
    assert list(dict.fromkeys(name for name, _, _ in found)) == list("あいうえお")
    assert [frame for _, frame, _ in found[:61]] == list(range(61))
    np.testing.assert_allclose([w for _, _, w in found[:61]], vowels(fps=30).channel("aa"), atol=1e-7)


def test_the_head_turns_about_axes_of_which_z_is_mirrored(tmp_path):
    still = replace(vowels(fps=30, frames=2), values=np.zeros((2, 8), np.float32))
    for channel, (place, sign) in {"headPitch": (0, -1), "headYaw": (1, -1), "headRoll": (2, 1)}.items():
        still.values[:] = 0
        still.values[:, still.channels.index(channel)] = 90
        save(still, tmp_path / "a.vmd")
        data = (tmp_path / "a.vmd").read_bytes()
        assert data[54:58] == "頭".encode("cp932") + bytes(2)
        rotation = struct.unpack_from("<4f", data, 54 + 15 + 4 + 12)
        assert rotation[place] == pytest.approx(sign * np.sqrt(0.5), abs=1e-6)
        assert rotation[3] == pytest.approx(np.sqrt(0.5), abs=1e-6)
        np.testing.assert_allclose(load(tmp_path / "a.vmd").channel(channel), 90, atol=1e-2)
    still.values[:] = 0
    save(still, tmp_path / "a.vmd")
    assert not set(TURNS) & set(load(tmp_path / "a.vmd").channels)


def test_other_rates_and_starts(tmp_path):
    late = replace(vowels(frames=121, fps=120), start=0.5)
    save(late, tmp_path / "a.vmd", keys=1e-6)
    again = load(tmp_path / "a.vmd")
    assert (again.fps, len(again.values)) == (30, 46)
    np.testing.assert_allclose(again.channel("aa")[15:], late.channel("aa")[::4], atol=1e-5)
    save(replace(late, start=-0.5), tmp_path / "a.vmd")
    np.testing.assert_allclose(load(tmp_path / "a.vmd").channel("aa"), late.channel("aa")[::4], atol=1e-6)


@pytest.mark.parametrize("name", ["mouthStretchLeft", "あいうえおかきく", "\N{GRINNING FACE}"])
def test_names_that_do_not_fit(tmp_path, name):
    animation = replace(vowels(), channels=(name, *vowels().channels[1:]))
    with pytest.raises(OutputError, match=r"a\.vmd: .* cannot be the name of a morph, .*--rig vrm"):
        save(animation, tmp_path / "a.vmd")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda data: b"x" + data, "it does not begin with"),
        (lambda data: data[:200], "it is truncated: 61 keys"),
        (lambda data: data[:50] + bytes(8), "it has no morphs"),
        (lambda data: data[:40], ""),
        (lambda data: data[:TURN] + b"\xff\xff\x7f\x7f" + data[TURN + 4 :], "a rotation of 頭 is not a unit"),
        (lambda data: data[:LATE] + b"\xff\xff\xff\x7f" + data[LATE + 4 :], ""),
    ],
)
def test_files_that_are_none(motion, damage, reason):
    motion.write_bytes(damage(motion.read_bytes()))
    with pytest.raises(OutputError, match=rf"a\.vmd: is not a motion of MikuMikuDance with morphs: {reason}"):
        load(motion)


def has_parser():
    code = "require.resolve('mmd-parser')"
    return NODE is not None and subprocess.run([NODE, "-e", code], capture_output=True).returncode == 0


@pytest.mark.skipif(not has_parser(), reason="needs node and the npm package mmd-parser on NODE_PATH")
def test_another_reader_finds_the_same(motion):
    code = """
        const data = require("fs").readFileSync(process.argv[1]);
        const bytes = data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength);
        const { morphs, motions } = new (require("mmd-parser").Parser)().parseVmd(bytes);
        for (const one of morphs) console.log(one.morphName, one.frameNum, one.weight);
        console.error(motions.length, motions[0].boneName);
    """
    done = subprocess.run([NODE, "-e", code, motion], capture_output=True, text=True, check=True)
    rows = [line.split() for line in done.stdout.splitlines()]
    assert done.stderr.split() == ["61", "頭"]
    expected = morphs(motion)
    assert [(name, int(frame)) for name, frame, _ in rows] == [(name, frame) for name, frame, _ in expected]
    np.testing.assert_allclose([float(row[2]) for row in rows], [row[2] for row in expected])


def test_line_is_what_fits(tmp_path):
    with pytest.raises(OutputError, match=r"browOuterUpRight cannot be the name"):
        save(line(), tmp_path / "a.vmd")
