"""Context features: box averages against a slow version, timing, and no matter how long the track is."""

from __future__ import annotations

import numpy as np
import pytest
from speech import random_track, track_of

from phonanim.features.context import (
    EDGES,
    FAR,
    N_BOXES,
    context_features,
    part_table,
    segment_timing,
    with_silence_beyond,
)
from phonanim.features.inputs import FEATURES, n_features, window_features
from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.inventory import INVENTORY


@pytest.mark.parametrize("kind", FEATURES)
def test_the_number_of_columns(kind: str) -> None:
    track = random_track(np.random.default_rng(0))
    assert window_features(kind, track, np.arange(10) / 25).shape == (10, n_features(kind))


def test_unknown_features_are_refused() -> None:
    with pytest.raises(ValueError, match="there are no features 'sounds'; use one of indicators, raw, all"):
        window_features("sounds", track_of("sil 1"), np.zeros(1))


def test_boxes_agree_with_a_slow_version() -> None:
    track = random_track(np.random.default_rng(1), 40)
    table, parts = part_table("gestures"), split_parts(track)
    time = 1.234
    found = context_features(track, np.array([time]), "gestures")[0, :-12].reshape(N_BOXES, -1)
    for box in range(N_BOXES):
        fine = np.linspace(time + EDGES[box], time + EDGES[box + 1], 20001)
        segment = np.clip(np.searchsorted(parts.bounds, fine, side="right") - 1, 0, len(parts.parts) - 1)
        assert np.allclose(found[box], table[parts.parts[segment]].mean(axis=0), atol=2e-3)


def test_features_are_continuous_in_time() -> None:
    track = random_track(np.random.default_rng(2))
    boxes = context_features(track, np.arange(0, 2, 0.001), "gestures")[:, :-12]
    assert np.abs(np.diff(boxes, axis=0)).max() <= 0.001 / 0.03 + 1e-4


def test_a_chunk_sees_what_the_whole_sees() -> None:
    track = random_track(np.random.default_rng(3), 200)
    times = np.arange(0, track.duration, 0.04)
    whole = context_features(track, times)
    for begin in range(0, len(times), 50):
        part = context_features(track, times[begin : begin + 50])
        assert np.allclose(part, whole[begin : begin + 50], atol=1e-5)


def test_shifted_speech_has_shifted_features() -> None:
    early, late = track_of("sil 1 p 0.1 aa 0.2 sil 1"), track_of("sil 1.4 p 0.1 aa 0.2 sil 1")
    times = np.arange(0.9, 1.3, 0.01)
    assert np.allclose(
        context_features(early, times)[:, :-12], context_features(late, times + 0.4)[:, :-12], atol=1e-5
    )


def test_it_is_no_matter_where_silence_is_cut() -> None:
    speech = "p 0.1 aa 0.2 ch 0.1"
    long, short = track_of(f"sil 2 {speech} sil 2"), track_of(f"sil 0.1 {speech} sil 0.02")
    none = track_of(speech)
    times = np.arange(0.005, 0.4, 0.01)
    whole = context_features(long, times + 2)
    assert np.allclose(context_features(short, times + 0.1), whole, atol=1e-5)
    assert np.allclose(context_features(none, times), whole, atol=1e-5)


def test_diphthongs_and_affricates_are_two_gestures() -> None:
    parts = split_parts(track_of("sil 0.2 ch 0.1 ay 0.2 m 0.1 sil 0.2"))
    names = [GESTURES.names[g] for g in GESTURES.part_gesture[parts.parts]]
    assert names == ["sil", "t", "sh", "a", "ih", "m", "sil"]
    assert np.allclose(parts.bounds, [0, 0.2, 0.245, 0.3, 0.41, 0.5, 0.6, 0.8])


def test_every_phone_has_its_gestures() -> None:
    assert set(GESTURES.part_phone) == set(range(len(INVENTORY.phones)))
    assert ((GESTURES.articulation >= 0) & (GESTURES.articulation <= 1)).all()


def test_the_timing_of_a_segment_by_hand() -> None:
    """At 1.25 s, 0.05 s into an aa of 0.2 s; the silences at the ends count as half a second."""
    track = track_of("sil 1 m 0.1 p 0.1 aa 0.2 t 0.3 sil 1")
    found = segment_timing(track, np.array([1.25, 0.8]))
    lengths = [0.2, 0.1, 0.3, 0.1, 0.5]  # itself, before, after, two before, two after
    memories = [np.exp(-x / decay) for decay in (0.04, 0.12) for x in (0.05, 0.15)]
    np.testing.assert_allclose(found[0], [0.05, 0.15, 0.25, *lengths, *memories], atol=1e-12)
    # In the first segment what lies before it is itself, and its 0.8 s count as half a second.
    memories = [np.exp(-x / decay) for decay in (0.04, 0.12) for x in (0.8, 0.2)]
    np.testing.assert_allclose(found[1], [0.5, 0.2, 0.8, 0.5, 0.5, 0.1, 0.5, 0.1, *memories], atol=1e-12)


def test_silence_goes_on_beyond_both_ends() -> None:
    whole = with_silence_beyond(track_of("sil 0.1 aa 0.2 sil 0.3"))
    np.testing.assert_allclose(whole.bounds, [-FAR, 0.1, 0.3, 0.6 + FAR])
    assert whole.labels == ("sil", "aa", "sil")
    bare = with_silence_beyond(track_of("aa 0.2 m 0.1"))
    np.testing.assert_allclose(bare.bounds, [-FAR, 0, 0.2, 0.3, 0.3 + FAR])
    assert bare.codes.tolist() == INVENTORY.codes(("sil", "aa", "m", "sil")).tolist()
    assert bare.labels == ("", "aa", "m", "")


def test_the_parts_are_gestures_then_classes_that_tell_phones_apart() -> None:
    gestures, classes, whole = (part_table(kind) for kind in ("gestures", "classes", "all"))
    assert np.array_equal(whole, np.hstack([gestures, classes]))
    assert set(np.unique(classes)) == {0, 1}
    assert (np.ptp(classes, axis=0) == 1).all()
    assert len(np.unique(classes, axis=1).T) == classes.shape[1]
