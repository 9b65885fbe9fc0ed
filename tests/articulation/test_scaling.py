"""More or less articulation keeps what must be kept."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.articulation import CHANNELS, Articulation
from phonanim.articulation.scaling import scale_articulation

MOUTHS = Articulation(
    np.array(
        [
            [1.2, 6.0, 2.0, 1.0, 1.5, 4.0, 5.0, 0.0, 1.0, 2.0],  # teeth that nearly meet
            [3.0, -0.5, 0.0, 0.0, 0.0, 2.0, -1.0, 0.0, 0.0, 0.0],  # lips that touch
            [9.5, 12.0, -1.0, 0.5, 1.0, 9.0, -6.0, -5.0, -3.0, -5.0],  # wide open
        ]
    )
)


def column(name: str) -> int:
    return CHANNELS.index(name)


def test_one_changes_nothing() -> None:
    assert scale_articulation(MOUTHS) is MOUTHS


@pytest.mark.parametrize("gain", [0.5, 1.5, 3.0])
def test_contacts_and_the_tongue_are_kept(gain: float) -> None:
    scaled = scale_articulation(MOUTHS, gain).values
    assert scaled[0, column("jaw")] <= 1.2
    assert scaled[1, column("lip_gap")] == -0.5
    tongue = [column(name) for name in CHANNELS if name.startswith("tongue")]
    np.testing.assert_array_equal(scaled[:, tongue], MOUTHS.values[:, tongue])
    np.testing.assert_array_equal(
        scaled[:, column("lower_lip_to_teeth")], MOUTHS.channel("lower_lip_to_teeth")
    )


def test_gains_scale_their_channels() -> None:
    wide = scale_articulation(MOUTHS, jaw=2.0, lips=1.5, own={"lip_width": 2.0}).values[2]
    assert wide[column("jaw")] == pytest.approx(1.5 + 2.0 * 8.0)
    assert wide[column("lip_gap")] == pytest.approx(18.0)
    assert wide[column("lip_width")] == pytest.approx(-3.0)


def test_none_is_a_mouth_at_rest() -> None:
    still = scale_articulation(MOUTHS, 0.0).values
    assert still[0, column("jaw")] == 0
    assert still[2, [column(name) for name in ("jaw", "lip_gap", "lip_width", "protrusion")]].max() == 0
