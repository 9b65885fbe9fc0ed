"""Lines of any length for tests of what follows prosody."""

from __future__ import annotations

from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

SENTENCE = tuple("DH AH0 K W IH1 K B R AW1 N F AA1 K S JH AH1 M P S OW1 V ER0 D AO1 G".split())  # noqa: SIM905
PAUSES = (0.25, 0.6, 1.5, 5.0)  # seconds after sentences, in turn


def sentences(seconds: float, phone: float = 0.09) -> tuple[Interval, ...]:
    """The same sentence again and again, vowels twice as long as consonants, with pauses in between."""
    found: list[Interval] = []
    time, number = 0.7, 0
    while time < seconds:
        for label in SENTENCE:
            lasts = 2 * phone if label[-1].isdigit() else phone
            found.append(Interval(label, time, time + lasts))
            time += lasts
        time += PAUSES[number % len(PAUSES)]
        number += 1
    return tuple(found)


def track_of(intervals: tuple[Interval, ...], duration: float) -> PhoneTrack:
    """English phones as a track."""
    return to_phones(Alignment(intervals, duration, "phones", "a test"), "english")[0]
