"""Learned lips and targets meet half way; the jaw and closures are the phones' alone."""

from __future__ import annotations

import numpy as np
import pytest
from speech import made_up_face, track_of

from phonanim.articulation import articulate
from phonanim.articulation.blend import blend_articulation, lip_channels

TRACK = track_of("sil 0.6 p 0.05 aa 0.15 m 0.05 uw 0.15 s 0.1 sil 0.6")
TIMES = np.arange(0, TRACK.duration, 1 / 60)
FACE = made_up_face(np.random.default_rng(0))
CLOSED = FACE.mean


def face_of(values: list[float]) -> np.ndarray:
    """One shape of the face at all times."""
    parameters = np.zeros((len(TIMES), len(FACE.std)))
    parameters[:, : len(values)] = values
    return FACE.instance(parameters)


def test_lips_are_half_learned_and_the_jaw_is_not() -> None:
    still, moved = face_of([]), face_of([3.0, 3.0, 3.0])
    first = blend_articulation(still, FACE, CLOSED, TRACK, TIMES)
    second = blend_articulation(moved, FACE, CLOSED, TRACK, TIMES)
    speech, rounded = (TIMES > 0.71) & (TIMES < 0.75), (TIMES > 0.9) & (TIMES < 0.95)  # within aa and uw
    seen = lip_channels(moved, FACE)["lip_width"] - lip_channels(still, FACE)["lip_width"]
    gained = second.channel("lip_width") - first.channel("lip_width")
    assert np.abs(seen).max() > 0.1
    assert gained[speech] == pytest.approx(seen[speech] / 2, rel=0.25)
    shares = gained[rounded] / seen[rounded]
    assert ((shares > 0.1) & (shares < 0.3)).all()
    for name in ("jaw", "upper_lip", "protrusion", "tongue_tip_height"):
        assert np.array_equal(first.channel(name), second.channel(name))
        assert np.array_equal(first.channel(name), articulate(TRACK, TIMES).channel(name))


def test_a_face_that_never_closes_closes_in_bilabials_and_in_silence() -> None:
    gap = blend_articulation(face_of([9.0]), FACE, CLOSED, TRACK, TIMES).channel("lip_gap")
    for number in (1, 3):
        inside = (TRACK.bounds[number] <= TIMES) & (TRACK.bounds[number + 1] >= TIMES)
        assert gap[inside].min() <= 0
    assert gap[0] == pytest.approx(0, abs=1e-9)
    assert gap[-1] == pytest.approx(0, abs=1e-9)


def test_chunks_equal_the_whole() -> None:
    shapes = face_of([2.0, 1.0])
    whole = blend_articulation(shapes, FACE, CLOSED, TRACK, TIMES).values
    pieces = [
        blend_articulation(shapes[at : at + 11], FACE, CLOSED, TRACK, TIMES[at : at + 11]).values
        for at in range(0, len(TIMES), 11)
    ]
    assert np.array_equal(np.concatenate(pieces), whole)
