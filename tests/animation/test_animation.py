import numpy as np
import pytest
from animations import line


def test_channels_go_by_name():
    animation = line()
    np.testing.assert_array_equal(
        animation.channel("jawOpen"), animation.values[:, animation.channels.index("jawOpen")]
    )
    with pytest.raises(KeyError, match="nothing"):
        animation.channel("nothing")


def test_it_is_saved_in_the_format_of_the_suffix(tmp_path):
    from phonanim.exporters import load

    animation = line()
    animation.save(tmp_path / "a.npz")
    np.testing.assert_array_equal(load(tmp_path / "a.npz").values, animation.values)


def test_times_start_where_they_should():
    np.testing.assert_allclose(line(frames=3, fps=25).times, [0, 0.04, 0.08])


@pytest.mark.parametrize("fps", [24, 25, 30000 / 1001, 60, 90, 120])
def test_another_rate_agrees_at_shared_instants(fps):
    animation = line()
    other = animation.at_rate(fps)
    assert other.fps == fps
    assert other.times[-1] <= 1 + 1e-9 < other.times[-1] + 1 / fps
    for curve, again in zip(animation.values.T, other.values.T, strict=True):
        np.testing.assert_allclose(again, np.interp(other.times, animation.times, curve), atol=1e-6)


def test_the_same_rate_changes_nothing():
    np.testing.assert_array_equal(line().at_rate(60).values, line().values)
    assert len(line(frames=1).at_rate(25).values) == 1
