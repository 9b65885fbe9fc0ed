"""Phones corrected by hand are corrected in the next alignment of the line, too, or the note says why not."""

from dataclasses import replace

import pytest

from phonanim.errors import OptionError
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.phone_changes import PhoneChanges, check_phones, correct_phones

READ = tuple(
    Interval(label, start / 10, (start + 1) / 10)
    for start, label in enumerate(("", "B", "AA", "T", "IY", ""))
)


def aligned(phones):
    return Alignment(phones, phones[-1].end, "phones", "line.TextGrid")


def slower(phones, by=1.15, later=0.2):
    return tuple(Interval(p.label, p.start * by + later, p.end * by + later) for p in phones)


def corrected(*changes):
    """The phones with some replaced: {place: phones}."""
    found = list(READ)
    for place, phones in sorted(changes, key=lambda change: -change[0]):
        found[place : place + 1] = phones
    return PhoneChanges(READ, tuple(found))


MOVED = PhoneChanges(READ, (*READ[:1], Interval("B", 0.1, 0.25), Interval("AA", 0.25, 0.3), *READ[3:]))


@pytest.mark.parametrize(
    "changes",
    [
        MOVED,
        corrected((2, [Interval("EH", 0.2, 0.3)])),
        corrected((2, [Interval("AH", 0.2, 0.24), Interval("N", 0.24, 0.3)])),
        corrected((3, []), (4, [Interval("IY", 0.3, 0.5)])),
        corrected((0, [Interval("", 0.0, 0.05), Interval("HH", 0.05, 0.1)])),
    ],
)
def test_a_correction_is_kept_and_follows_a_slower_take(changes):
    same, notes = correct_phones(aligned(READ), changes)
    assert (same.intervals, notes) == (changes.after, ())
    take, notes = correct_phones(aligned(slower(READ)), changes)
    assert notes == ()
    wanted = slower(changes.after)
    assert [phone.label for phone in take.intervals] == [phone.label for phone in wanted]
    for phone, other in zip(take.intervals, wanted, strict=True):
        assert (phone.start, phone.end) == pytest.approx((other.start, other.end), abs=1e-6)


def test_phones_that_nobody_corrected_are_those_of_the_new_alignment():
    take = (*slower(READ)[:4], Interval("IY", 0.66, 0.9), Interval("", 0.9, 1.0))
    found, _ = correct_phones(aligned(take), MOVED)
    assert found.intervals[3:] == take[3:]
    assert found.intervals[1].end == pytest.approx(0.25 * 1.15 + 0.2)


def test_a_correction_of_phones_that_are_gone_is_left_out_and_told():
    take = tuple(replace(p, label="D") if p.label == "B" else p for p in READ)
    found, notes = correct_phones(aligned(take), MOVED)
    assert found.intervals == take
    assert notes == ("the correction of the phones B AA was left out: they are no longer spoken there",)


@pytest.mark.parametrize(
    ("phones", "message"),
    [
        ([Interval("B", 0.1, 0.102)], "a phone lasts at least 0.005 s"),
        ([Interval("B", 0.1, 0.3), Interval("AA", 0.2, 0.4)], "AA 0.200-0.400 s: phones follow one another"),
        ([Interval("B", 0.1, 0.9)], "from 0 to 0.600 s"),
        ([Interval("B", -0.1, 0.2)], "follow one another"),
    ],
)
def test_phones_that_cannot_be_are_refused(phones, message):
    with pytest.raises(OptionError, match=message):
        check_phones(tuple(phones), 0.6)
