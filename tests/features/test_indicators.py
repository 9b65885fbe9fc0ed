"""The 2379 indicators: how many of each group, and windows worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from speech import random_track, track_of

from phonanim.features.indicators import groups, indicators, n_indicators, raw_indicators
from phonanim.features.inputs import NO_CLUSTERS, frame_codes, n_features, window_features
from phonanim.speech.inventory import INVENTORY

NONE = np.full((41, 41), -1, np.int8)


def window(text: str) -> np.ndarray:
    return INVENTORY.codes(text.split())[None]


def group(row: np.ndarray, name: str) -> np.ndarray:
    return row[groups()[name]]


def test_counts_of_each_group() -> None:
    assert tuple(map(len, groups().values())) == (1558, 660, 1, 20, 30, 30, 50, 30)
    assert n_indicators() == 2379
    assert n_indicators(1) == 41 + 60 + 1  # one frame has neither spans of several nor pairs


def test_spans_by_hand() -> None:
    row = indicators(window("sil sil sil m m m m m aa aa aa"), NONE).dense()[0]
    spans = group(row, "span")
    # Three runs of 3, 5 and 3 frames: a run of n frames fills n - k windows of k + 1 frames.
    assert spans.sum() == (3 + 5 + 3) + (2 + 4 + 2) + (1 + 3 + 1) + (0 + 2 + 0)
    m = INVENTORY.code("m")
    assert spans[3 * 41 + m] == 1  # m at frame 3
    assert spans[2 * 41 + m] == 0  # not yet at frame 2
    assert spans[11 * 41 + 6 * 41 + m] == 1  # m fills frames 6 and 7
    assert spans[11 * 41 + 7 * 41 + m] == 0  # but not 7 and 8
    assert spans[(11 + 10 + 9) * 41 + 4 * 41 + m] == 1  # and frames 4 to 7


def test_attributes_by_hand() -> None:
    row = indicators(window("sil sil sil m m m m m aa aa aa"), NONE).dense()[0]
    attributes = group(row, "attribute").reshape(11, 60).astype(bool)
    names = np.array(INVENTORY.attribute_names)
    assert set(names[attributes[0]]) == {"silences"}
    assert set(names[attributes[5]]) == {
        "Nasal", "Bilabial", "Voiced-Consonant", "Front-Consonant", "Front",
    }  # fmt: skip
    assert "Vowel-Open" in names[attributes[9]]
    assert "AVowel" in names[attributes[9]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("aa aa aa aa aa aa aa aa aa aa aa", 0),
        ("aa aa aa aa m m m aa aa aa aa", 0),  # only in frames c-1, c, c+1
        ("aa aa aa m aa aa aa aa aa aa aa", 1),  # c-2
        ("aa aa aa aa aa aa aa aa aa aa m", 1),  # c+5
        ("sil sil sil sil sil sil sil sil sil sil sil", 0),
    ],
)
def test_consonant_around_the_centre(text: str, expected: int) -> None:
    assert group(indicators(window(text), NONE).dense()[0], "consonant")[0] == expected


def test_transitions_by_hand() -> None:
    clusters = NONE.copy()
    clusters[INVENTORY.code("m"), INVENTORY.code("aa")] = 1
    clusters[INVENTORY.code("aa"), INVENTORY.code("s")] = 2
    clusters[INVENTORY.code("s"), INVENTORY.code("t")] = 0
    row = indicators(window("m m aa aa s s t t ow ow ow"), clusters).dense()[0]
    assert np.flatnonzero(group(row, "cv")).tolist() == [1 * 2 + 1]  # frames 1, 2; cluster 1
    assert np.flatnonzero(group(row, "vc")).tolist() == [3 * 3 + 2]
    assert np.flatnonzero(group(row, "cc")).tolist() == [5 * 3 + 0]
    assert np.flatnonzero(group(row, "starts")).tolist() == [1 * 5 + 0, 7 * 5 + 3]  # m-aa, t-ow
    assert np.flatnonzero(group(row, "ends")).tolist() == [7 * 3 + 1]  # ow ends with w


def test_sparse_rows_are_sorted_and_agree_with_a_slow_version() -> None:
    rng = np.random.default_rng(3)
    track = random_track(rng)
    codes = frame_codes(track, np.arange(40) / 25)
    found = indicators(codes, rng.integers(-1, 2, (41, 41)).astype(np.int8))
    dense = found.dense()
    assert dense.sum() == len(found.columns)
    for k, row in ((0, dense[7]), (3, dense[20])):
        codes_row = codes[7] if k == 0 else codes[20]
        base = 41 * sum(11 - j for j in range(k))
        for place in range(11 - k):
            for phone in range(41):
                filled = all(codes_row[place + j] == phone for j in range(k + 1))
                assert row[base + place * 41 + phone] == filled


def test_raw_indicators() -> None:
    found = raw_indicators(window("sil sil sil m m m m m aa aa aa"))
    assert found.dense().shape == (1, 41 * 11)
    assert np.flatnonzero(found.dense()[0])[3] == 3 * 41 + INVENTORY.code("m")
    assert raw_indicators(window("sil m aa")).dense().shape == (1, 41 * 3)


@pytest.mark.parametrize("width", [1, 3, 5, 7, 21])
def test_other_windows_ask_the_same_of_the_same_frames(width: int) -> None:
    """What lies in two windows has one answer; a consonant is looked for up to five frames away."""
    rng = np.random.default_rng(5)
    track, times = random_track(rng), np.arange(40) / 25
    clusters = rng.integers(-1, 2, (41, 41)).astype(np.int8)
    narrow, wide = sorted((width, 11))
    inner, outer = (window_features("indicators", track, times, clusters, w) for w in (narrow, wide))
    assert (inner.shape[1], outer.shape[1]) == (
        n_features("indicators", narrow),
        n_features("indicators", wide),
    )
    first = wide // 2 - narrow // 2
    each = {"span": 41, "attribute": 60, "cv": 2, "vc": 3, "cc": 3, "starts": 5, "ends": 3}
    for name, size in each.items():
        count = 41 * narrow if name == "span" else len(groups(narrow)[name])  # spans of one frame
        shared = outer[:, groups(wide)[name]][:, first * size :][:, :count]
        np.testing.assert_array_equal(inner[:, groups(narrow)[name]][:, :count], shared)
    seen, seen_wide = inner[:, groups(narrow)["consonant"]], outer[:, groups(wide)["consonant"]]
    if width > 11:
        np.testing.assert_array_equal(seen, seen_wide)
    assert seen.any() == (width > 3)
    assert (seen <= seen_wide).all()


def test_codes_that_are_no_windows_are_refused() -> None:
    with pytest.raises(ValueError, match=r"expected windows \(frames, Kx\) of phone codes, got \(3,\)"):
        indicators(window("sil sil m")[0], NO_CLUSTERS)


def test_the_frames_around_an_instant_are_centred_on_it() -> None:
    """Eleven frames of 40 ms: five before, the one at hand, five after; an instant lies where it begins."""
    names = INVENTORY.phones[1:14]
    track = track_of(" ".join(f"{name} 0.04" for name in names))
    assert frame_codes(track, np.array([0.24]))[0].tolist() == INVENTORY.codes(names[1:12]).tolist()
    assert frame_codes(track, np.array([0.24]), 3)[0].tolist() == INVENTORY.codes(names[5:8]).tolist()
    first, last = INVENTORY.codes((names[0], names[-1])).tolist()
    assert frame_codes(track, np.array([0.0]))[0, :6].tolist() == [first] * 6
    assert frame_codes(track, np.array([0.5]))[0, 5:].tolist() == [last] * 6
