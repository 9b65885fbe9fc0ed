"""The quick solver against one that takes its time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from phonanim.articulation import articulate
from phonanim.rig import load_rig, pronounce
from phonanim.rig.bounded import QUICK, THOROUGH, Pace, minimize
from phonanim.rig.fit_quality import probe


@pytest.mark.parametrize("name", ["vrm", "oculus15", "half a mouth"])
def test_mouths_of_shapes_are_near_the_minimum(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    track, times = probe()
    wanted, rig = articulate(track, times), load_rig("arkit" if name == "half a mouth" else name)
    assert rig.mouth is not None
    mouth = replace(rig.mouth, moved=rig.mouth.moved * 0.5) if name == "half a mouth" else rig.mouth
    lead = [rig.controls.index(names[0]) for names in mouth.names]
    found = pronounce.pronounce(wanted, rig, mouth)[:, lead] @ mouth.moved
    monkeypatch.setattr(pronounce, "THOROUGH", Pace(3000, THOROUGH.firmness, 1.6))
    best = pronounce.pronounce(wanted, rig, mouth)[:, lead] @ mouth.moved
    np.testing.assert_allclose(found, best, atol=0.1)


def test_the_quick_pace_is_not_enough_for_shapes_that_share_a_sum() -> None:
    rng = np.random.default_rng(0)
    seen = rng.normal(size=(6, 4))
    gram, pull = seen @ seen.T + 0.1 * np.eye(6), seen @ rng.normal(size=(4, 50)) * 2
    low, high, shared = np.zeros_like(pull), np.ones_like(pull), np.ones(6, bool)
    paces = (QUICK, THOROUGH, Pace(20000, 0.2, 1.6))
    quick, thorough, best = (minimize(gram, pull, np.full(6, 0.1), low, high, shared, pace) for pace in paces)
    assert np.abs(thorough - best).max() < np.abs(quick - best).max()
    assert best.sum(axis=0).max() <= 1 + 1e-9
