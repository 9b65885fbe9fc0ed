"""Where sensors start and end in pairs of phones."""

from __future__ import annotations

import numpy as np
from speech import track_of

from phonanim.ema.articulation import Articulation
from phonanim.ema.report import PreparedRecording, _motions


def test_a_motion_goes_from_the_middle_of_a_phone_to_that_of_the_next() -> None:
    track = track_of("sil 0.2 t 0.2 iy 0.2 t 0.2 iy 0.2 sil 0.2")
    times = np.arange(0, 1.2, 0.01)
    positions = np.stack([np.stack([10 * times, 0 * times, -times], axis=1)] * 2, axis=1)
    take = PreparedRecording("a", Articulation(("TT", "UL"), positions, 100.0), [], track)
    found = _motions([take], {"t iy"})
    assert list(found) == ["t iy"]
    assert found["t iy"].shape == (2, 2, 2, 3)
    np.testing.assert_allclose(found["t iy"][:, 0, 0, 0], [3, 7], atol=0.11)
    np.testing.assert_allclose(np.diff(found["t iy"], axis=1)[:, 0, 1], [[2, 0, -0.2]] * 2, atol=0.11)
