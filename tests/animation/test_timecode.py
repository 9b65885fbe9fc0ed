import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from phonanim.animation.timecode import Timecode, timecode_for_label
from phonanim.errors import OptionError

DROP = Timecode(60, drop=True)


def labels_slowly(nominal, minutes):
    """Drop-frame labels by counting every label and leaving out those that are left out."""
    for minute in range(minutes):
        for second in range(60):
            for frame in range(nominal):
                if not (second == 0 and minute % 10 and frame < nominal // 30 * 2):
                    yield f"{minute // 60:02}:{minute % 60:02}:{second:02};{frame:02}.000"


@pytest.mark.parametrize("nominal", [30, 60])
def test_drop_frame_leaves_out_the_right_labels(nominal):
    clock = Timecode(nominal, drop=True)
    for number, label in enumerate(labels_slowly(nominal, 22)):
        assert clock.format(number / clock.rate) == label


def test_drop_frame_keeps_to_the_clock():
    assert DROP.format(3600).startswith("01:00:00;00")
    assert Timecode(30, drop=True).format(86400 - 0.1).startswith("23:59:59;")


@given(st.integers(0, 24 * 3600 * 60 - 1), st.sampled_from([Timecode(24), Timecode(25), Timecode(60), DROP]))
def test_labels_are_read_back(thousandths, clock):
    time = thousandths / 60000 * 7
    assert clock.parse(clock.format(time)) == pytest.approx(time, abs=0.6e-3 / clock.rate)


def test_plain_counting():
    assert Timecode(60).format(3723.9999999) == "01:02:04:00.000"
    assert Timecode(25).format(24 * 3600) == "00:00:00:00.000"
    assert timecode_for_label("01:00:00;00", 60) == DROP
    assert timecode_for_label("01:00:00:00", 60) == Timecode(60)


@pytest.mark.parametrize(
    ("clock", "text", "message"),
    [
        (Timecode(25), "1:2:3", "'1:2:3' is not a timecode at 25 frames per second; write 01:00:00:02"),
        (DROP, "01:00:00:00", "is not a timecode at 59.9401 frames per second; write 01:00:00;02"),
        (Timecode(25), "00:00:00:25", "minutes and seconds go to 59, frames to 24"),
        (Timecode(25), "00:60:00:00", "minutes and seconds go to 59"),
        (DROP, "00:01:00;03", "'00:01:00;03' is left out in drop-frame counting; write frame 04"),
    ],
)
def test_labels_that_are_none(clock, text, message):
    with pytest.raises(OptionError, match=re.escape(message)):
        clock.parse(text)
