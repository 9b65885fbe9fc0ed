"""Controls as rows: scaled, within limits, and the same after being stored."""

from __future__ import annotations

import numpy as np
import pytest

from phonanim.animation.own_motion import rig_of_names
from phonanim.errors import CorpusError, ModelError
from phonanim.rig import load_rig
from phonanim.targets import Source, TargetSettings, target_class
from phonanim.targets.controls import Controls

NAMES = ("jaw", "lips", "still")


def frames(low: float = 0.0, high: float = 0.8) -> np.ndarray:
    rng = np.random.default_rng(2)
    return rng.uniform(low, high, (50, 3)).astype(np.float32) * [1, 1, 0] + [0, 0, 0.25]


def fitted(values: np.ndarray, **settings: str) -> Controls:
    made = TargetSettings(**settings)  # type: ignore[arg-type]
    return Controls.fit(made, Source("sample", NAMES), [(values[:20], None), (values[20:], None)])


@pytest.mark.parametrize("scale", ["minmax", "zscore", "none"])
def test_rows_lead_back_to_the_controls(scale: str) -> None:
    target = fitted(frames(), scale=scale)
    rows = target.encode(frames())
    assert rows.shape == (50, 2)
    assert target.decode(rows) == pytest.approx(frames(), abs=1e-6)
    stored = Controls.from_parts(target.facts(), target.tensors())
    assert np.array_equal(stored.decode(rows), target.decode(rows))
    assert stored.names == NAMES


def test_scales_of_the_papers() -> None:
    rows = fitted(frames(), scale="minmax").encode(frames())
    assert (rows.min(0).tolist(), rows.max(0).tolist()) == ([0, 0], [1, 1])
    rows = fitted(frames(), scale="zscore").encode(frames())
    assert rows.mean(0) == pytest.approx([0, 0], abs=1e-5)
    assert rows.std(0) == pytest.approx([1, 1], abs=1e-5)


def test_limits_are_those_of_the_data() -> None:
    far = np.full((1, 2), 9.0, np.float32)
    assert fitted(frames()).decode(far)[0].tolist() == [1, 1, 0.25]
    wide = frames(-2, 3)
    assert fitted(wide).decode(far)[0] == pytest.approx(wide.max(axis=0))
    assert fitted(wide, limits="none").decode(far)[0, 0] > 3


def test_what_is_wrong_is_said() -> None:
    with pytest.raises(CorpusError, match="sample: nothing moves"):
        fitted(np.ones((50, 3)))
    with pytest.raises(ModelError, match="there is no target 'control'; did you mean 'controls'"):
        target_class("control")
    target = fitted(frames())
    with pytest.raises(ValueError, match="not of 3 controls"):
        Controls.from_parts(target.facts(), target.tensors() | {"low": np.zeros(2)})


def test_controls_of_most_of_a_rig_are_that_rig() -> None:
    """As the 67 of IMFT'23 are of a MetaHuman's 87."""
    names = load_rig("metahuman").controls
    assert rig_of_names(names[:67]) == "metahuman"
    assert rig_of_names((*names[:67], "one more")) == ""
    assert rig_of_names(names[:50]) == ""
