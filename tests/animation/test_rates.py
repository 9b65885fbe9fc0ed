from fractions import Fraction

import pytest

from phonanim.animation.rates import NTSC, frame_count, parse_rate
from phonanim.errors import OptionError


@pytest.mark.parametrize(("text", "rate"), [("25", 25.0), (" 60 ", 60.0), ("12.5", 12.5), ("120", 120.0)])
def test_plain_rates(text, rate):
    assert parse_rate(text) == rate


@pytest.mark.parametrize("text", sorted(NTSC))
def test_ntsc_rates_are_exact(text):
    rate = parse_rate(text)
    assert Fraction(rate).limit_denominator(1001) == Fraction(NTSC[text] * 1000, 1001)
    assert rate == pytest.approx(float(text), abs=0.005)
    assert parse_rate(f"{NTSC[text] * 1000}/1001") == rate


@pytest.mark.parametrize("text", ["", "fast", "nan", "inf", "1/0", "25fps"])
def test_what_is_no_rate(text):
    with pytest.raises(OptionError, match="is not a frame rate; write it as 60, 29.97 or 30000/1001"):
        parse_rate(text)


@pytest.mark.parametrize("text", ["0", "-25", "0.5", "1e9"])
def test_rates_out_of_bounds(text):
    with pytest.raises(OptionError, match="the rate must lie from 1 to 1000"):
        parse_rate(text)


@pytest.mark.parametrize(
    ("duration", "fps", "frames"),
    [(1.0, 25, 26), (0.999, 25, 25), (0.0, 60, 1), (1.1, 30, 34), (2.978, 25, 75), (600, 60, 36001)],
)
def test_frames_lie_from_the_start_to_the_end(duration, fps, frames):
    assert frame_count(duration, fps) == frames
    assert (frames - 1) / fps <= duration + 1e-6 / fps < frames / fps + 1e-9
