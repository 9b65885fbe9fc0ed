"""The phone table: means of the middles of phones, and bars that fail when a mouth mumbles."""

from __future__ import annotations

import numpy as np
import pytest
from speech import track_of

from phonanim.articulation import CHANNELS, articulate
from phonanim.metrics.phone_table import Table, check_table, phone_table

LINE = "sil 0.2 aa 0.15 s 0.1 iy 0.15 p 0.08 uw 0.15 z 0.1 f 0.1 aa 0.1 sh 0.1 m 0.1 iy 0.1 v 0.1 "
LINE += "ch 0.1 uw 0.2 b 0.08 jh 0.1 sil 0.2"


def table_of(gain: float = 1.0) -> Table:
    track = track_of(LINE)
    times = np.arange(0, track.duration, 0.01)
    values = articulate(track, times).values
    return phone_table([(track, times, {name: gain * values[:, i] for i, name in enumerate(CHANNELS)})])


def test_a_phone_has_the_mean_of_its_middles() -> None:
    track, times = track_of("sil 0.2 aa 0.2 sil 0.2 aa 0.2 sil 0.2"), np.arange(0, 1, 0.01)
    table = phone_table([(track, times, {"lip_gap": times})])
    assert table["aa"]["lip_gap"] == pytest.approx(0.5, abs=0.01)
    assert table["aa"]["count"] == 2
    assert table["aa"]["closest"] == pytest.approx(0.4, abs=0.01)


def test_natural_articulation_closes_and_opens() -> None:
    found = {check.name: check for check in check_table(table_of())}
    assert found["lip gap at p b m, mm"].passed
    assert found["share of p b m that close"].value == 1.0
    assert found["teeth apart at s z sh ch jh, mm"].passed
    assert found["lower lip from the teeth at f v, mm"].passed


def test_a_mouth_that_mumbles_fails() -> None:
    failed = {check.name for check in check_table(table_of(0.3)) if not check.passed}
    assert {"UW narrower than IY, mm", "UW further out than IY, mm"} <= failed


def test_phones_that_are_not_there_are_not_checked() -> None:
    track, times = track_of("sil 0.2 aa 0.2 sil 0.2"), np.arange(0, 0.6, 0.01)
    assert check_table(phone_table([(track, times, {"lip_gap": times, "jaw": times})])) == []
