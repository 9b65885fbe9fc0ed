from dataclasses import replace

import numpy as np
import pytest
from animations import line, only

from phonanim.errors import AudioError
from phonanim.exporters import save
from phonanim.exporters.png import LANE, SIDE, _scale, blend_curve, lane_name, most_moving_channels


def test_the_liveliest_channels_come_first():
    animation = line()
    values = np.zeros_like(animation.values)
    for place, (name, reach) in enumerate({"jawOpen": 0.2, "mouthFunnel": 0.7, "mouthClose": 0.0005}.items()):
        values[place, animation.channels.index(name)] = reach
    assert most_moving_channels(animation.with_values(values), 12) == ["mouthFunnel", "jawOpen"]
    assert most_moving_channels(animation.with_values(values), 1) == ["mouthFunnel"]


def test_the_sides_of_a_face_share_a_lane_while_they_move_alike():
    animation = line()
    left, right = (animation.channels.index(f"mouthSmile{side}") for side in ("Left", "Right"))
    values = np.zeros_like(animation.values)
    values[0, left] = values[0, right] = 0.5
    alike = animation.with_values(values)
    assert most_moving_channels(alike, 12) == ["mouthSmileLeft"]
    assert lane_name(alike, "mouthSmileLeft") == "mouthSmile L R"
    values[0, right] = 0.4
    apart = animation.with_values(values)
    assert most_moving_channels(apart, 12) == ["mouthSmileLeft", "mouthSmileRight"]
    assert lane_name(apart, "mouthSmileLeft") == "mouthSmileLeft"


@pytest.mark.parametrize(
    ("name", "plain"),
    [
        ("CTRL_expressions_mouthStretchL", "CTRL_expressions_mouthStretch"),
        ("mouth_smile.R", "mouth_smile."),
        ("brow_l", "brow_"),
        ("jawOpen", "jawOpen"),
        ("mouthRollUpper", "mouthRollUpper"),
        ("mouthL_upper", "mouth_upper"),
    ],
)
def test_a_side_is_read_from_a_name(name, plain):
    assert SIDE.sub("", name) == plain


def test_degrees_of_the_head_do_not_flatten_the_mouth(tmp_path):
    animation = line()
    place = {name: animation.channels.index(name) for name in ("headYaw", "jawOpen")}
    assert place["headYaw"] >= 0
    values = np.zeros_like(animation.values)
    values[::2, place["jawOpen"]] = 0.5
    plain = animation.with_values(values)
    save(plain, tmp_path / "a.png")
    values[::2, place["headYaw"]] = 3.0
    turned = animation.with_values(values)
    assert most_moving_channels(turned, 12) == ["jawOpen", "headYaw"]
    save(turned, tmp_path / "b.png")
    assert picture_size(tmp_path / "b.png")[1] == picture_size(tmp_path / "a.png")[1] + LANE
    assert _scale(turned, ["jawOpen"]) == (0.0, 0.5)


def test_a_curve_is_two_pixels_thick_and_tints_what_is_under_it():
    image = np.zeros((40, 30, 3), np.uint8)
    blend_curve(image, np.full(31, 10.0), 30.0, (200, 100, 50))
    column = image[:, 15, 0].astype(float)
    assert column[:8].max() == 0
    np.testing.assert_array_equal(column[9:11], 200)
    assert column[12:29].min() == column[12:29].max() == 44
    assert column[31:].max() == 0


def test_a_steep_curve_has_no_gaps():
    image = np.zeros((60, 12, 3), np.uint8)
    blend_curve(image, np.linspace(5, 55, 13), 60.0, (255, 255, 255))
    assert image[6:54].max(axis=(1, 2)).min() > 150


def picture_size(path):
    return tuple(np.frombuffer(path.read_bytes()[16:24], ">u4"))


def test_long_lines_are_wide_and_still_lines_are_plotted(tmp_path):
    save(line(), tmp_path / "a.png")
    save(line(frames=1200), tmp_path / "b.png")
    save(only(line()), tmp_path / "c.png")
    assert picture_size(tmp_path / "b.png")[0] > 4 * picture_size(tmp_path / "a.png")[0]
    assert picture_size(tmp_path / "c.png")[1] < picture_size(tmp_path / "a.png")[1]
    save(line(frames=1), tmp_path / "d.png")


def test_the_waveform_is_drawn(tmp_path, root):
    silent = only(line())
    save(silent, tmp_path / "a.png")
    save(replace(silent, audio=root / "examples" / "line.wav"), tmp_path / "b.png")
    assert picture_size(tmp_path / "b.png")[1] > picture_size(tmp_path / "a.png")[1]


def test_a_damaged_recording_leaves_no_picture(tmp_path):
    pytest.importorskip("soundfile", reason="needs the extra audio")
    (tmp_path / "a.wav").write_bytes(b"RIFF")
    with pytest.raises(AudioError, match=r"a\.wav"):
        save(replace(only(line()), audio=tmp_path / "a.wav"), tmp_path / "a.png")
    assert not (tmp_path / "a.png").exists()
