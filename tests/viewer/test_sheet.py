import time
from dataclasses import replace

import numpy as np
import pytest
from animations import line

from phonanim.errors import OutputError, RigError
from phonanim.speech.alignment import Interval
from phonanim.viewer.sheet import choose_shots, save_sheet


def test_one_shot_per_phone_at_its_middle():
    shots = choose_shots(line(), 24)
    assert [shot.phone for shot in shots] == ["HH", "ə", "L", "OW"]
    assert [shot.time for shot in shots] == pytest.approx([0.15, 0.25, 0.35, 0.55], abs=0.5 / 60)
    assert [shot.frame for shot in shots] == [round(shot.time * 60) for shot in shots]
    assert {shot.word for shot in shots} == {"hello"}


def test_long_lines_are_thinned_and_keep_their_ends():
    phones = tuple(Interval(f"p{i}", i * 0.02, i * 0.02 + 0.02) for i in range(50))
    shots = choose_shots(replace(line(), phones=phones), 10)
    assert len(shots) == 10
    assert (shots[0].phone, shots[-1].phone) == ("p0", "p49")


def test_lines_without_phones_are_cut_evenly():
    shots = choose_shots(replace(line(), phones=(), words=()), 4)
    assert [shot.frame for shot in shots] == [0, 20, 40, 60]
    assert {shot.phone + shot.word for shot in shots} == {""}


def test_labels_beyond_the_animation_show_its_last_frame():
    phones = (Interval("a", 0.0, 0.1), Interval("b", 5.0, 6.0))
    assert [shot.frame for shot in choose_shots(replace(line(), phones=phones), 4)] == [3, 60]


def test_a_sheet_is_a_picture_that_repeats(tmp_path):
    for name in ("a.png", "b.png"):
        save_sheet(line(), tmp_path / name, size=64, columns=3)
    data = (tmp_path / "a.png").read_bytes()
    assert data[:4] == b"\x89PNG"
    assert data == (tmp_path / "b.png").read_bytes()


def test_sheets_that_cannot_be_drawn(tmp_path):
    with pytest.raises(RigError, match=r"the head has none of the channels"):
        save_sheet(replace(line(), channels=tuple(f"x{i}" for i in range(52))), tmp_path / "a.png")
    with pytest.raises(OutputError, match=r"the folder .* does not exist"):
        save_sheet(line(frames=2), tmp_path / "none" / "a.png", size=32)


def test_a_sheet_of_24_takes_two_seconds(tmp_path):
    phones = tuple(Interval("AA", i / 24, (i + 1) / 24) for i in range(24))
    start = time.process_time()
    save_sheet(replace(line(), phones=phones), tmp_path / "a.png")
    assert time.process_time() - start < 4  # twice the aim, for slow machines
    assert np.fromfile(tmp_path / "a.png", np.uint8).size > 50_000
