"""Two takes of a line are matched by their phones."""

import pytest

from phonanim.speech.alignment import Interval
from phonanim.speech.anchors import match_phones, match_takes


def take(labels, by=1.0):
    return tuple(Interval(label, by * n, by * (n + 1)) for n, label in enumerate(labels.split()))


@pytest.mark.parametrize(
    ("before", "after", "found"),
    [
        ("B AA T", "B AA T", {0: 0, 1: 1, 2: 2}),
        ("B AA T", "HH B AA T", {0: 1, 1: 2, 2: 3}),
        ("B AA T", "B AA T S", {0: 0, 1: 1, 2: 2}),
        ("B AA T", "B IY T", {0: 0, 2: 2}),
        ("M AA M AA", "M AA", {0: 0, 1: 1}),
        ("AA AA AA", "AA AA AA AA", {0: 0, 1: 1, 2: 2}),
        ("B L AA K", "B AA P L AA K", {0: 0, 1: 3, 2: 4, 3: 5}),
        ("B", "", {}),
    ],
)
def test_phones_are_found_in_order(before, after, found):
    anchors = match_phones(take(before), take(after))
    assert anchors.found == found


def test_times_move_with_the_phones():
    anchors = match_phones(take("B AA T"), take("HH B AA T", 2.0))
    assert anchors.moved([0.5, 1.5, 10.0]).tolist() == [3.0, 5.0, 15.0]


def test_a_take_of_before_a_correction_is_found_by_the_phones_that_were_read():
    read, spoken = take("B AA T IY"), take("B AA D IY")
    assert match_takes(take("B AA T IY"), read, spoken).found == {0: 0, 1: 1, 2: 2, 3: 3}
    assert match_takes(take("B AA D IY"), read, spoken).found == {0: 0, 1: 1, 2: 2, 3: 3}
    assert match_takes(take("B AA T IY"), (), spoken).found == {0: 0, 1: 1, 3: 3}


def test_an_hour_of_phones_is_matched_at_once():
    labels = "B AA T IY M " * 8000
    anchors = match_phones(take(labels), take(labels.replace("B", "P", 1), 1.1))
    assert len(anchors.found) == 39_999
