"""The clock of an alignment: its unit of time and its start, checked against sense and the recording."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from phonanim.errors import OptionError
from phonanim.speech.alignment_file import AlignmentFile
from phonanim.speech.intervals import ROUNDING, Interval, Recording, Tier
from phonanim.speech.labels import is_silent

LATE_START = 1.0
"""Seconds. A file that starts later was cut out of a longer recording, and so was its audio."""

SHORTEST, LONGEST = 0.012, 0.6
"""Seconds that phones last on average at least, and, where even the short ones are long, at most."""

SHORT_ONES = 0.3
"""Seconds. In song, vowels are held, but a quarter of the phones is shorter than this."""

LATE_LABEL = (
    0.3  # seconds of silence before the first label, from which a file without a header may be a part
)
FAR = 10.0  # seconds before the first phone, without a recording, that are worth a note
FEWEST = 3  # phones that tell an average
SURE, BEYOND = 5, 3.0  # phones, or seconds of a phone, from which long phones are no accident
LEAST, MOST = 0.025, 1.2  # seconds on average in the unit that times are likely in: speech, or slow song
USUAL = 0.1  # seconds of a phone
APART = 0.5  # seconds between the ends of a recording and its alignment that count as rounding
NEAR = 0.03  # share of a recording's length by which an alignment of the right unit may miss it

_SAMPLES = re.compile(r"(?:samples|frames)@(\d+(?:\.\d+)?)")
_NAMED = {"s": 1.0, "ms": 1e-3, "100ns": 1e-7}
RATES = (48_000, 44_100, 22_050, 16_000, 100, 50)
TIMIT = "samples@16000"  # of every file of that corpus
CANDIDATES = {**_NAMED, **{f"samples@{rate}": 1 / rate for rate in RATES}}


@dataclass(frozen=True, slots=True)
class Clock:
    """What is known of the times of a file.

    `unit` is the time of one of its numbers, as `parse_unit` reads it; `offset` is the time in seconds that
    is 0 of the animation; `audio` is the length of the recording in seconds. None is unknown.
    """

    unit: str | None = None
    offset: float | None = None
    audio: float | None = None


ANY = Clock()


def parse_unit(text: str) -> float:
    """Seconds of one number in a unit: s, ms, 100ns, or samples@RATE. Raises OptionError."""
    found = _SAMPLES.fullmatch(text.strip().lower())
    seconds = 1 / float(found[1]) if found and float(found[1]) else _NAMED.get(text.strip().lower())
    if seconds is None:
        raise OptionError(f"unit = {text!r}; give s, ms, 100ns or samples@RATE, such as samples@16000")
    return seconds


def parse_offset(text: str) -> float:
    """Seconds from 0 to a day. Raises OptionError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= 86_400:
        raise OptionError(f"offset = {text!r}; give seconds from 0 to 86400")
    return value


def settle_unit(
    recording: Recording, phones: Tier, clock: Clock, source: AlignmentFile
) -> tuple[float, tuple[str, ...]]:
    """The factor that takes the times of a recording to seconds, and a note where the recording decided.

    Raises AlignmentError where phones last too short or too long and nothing decides, with the likely unit.
    """
    if clock.unit is not None:
        return parse_unit(clock.unit) / recording.unit, ()
    mean = _mean([one for one in phones.intervals if not is_silent(one.label)])
    if mean is None:
        return 1.0, _guessed_rate(recording, clock, source)
    sensible = _is_sensible(phones.intervals) and not recording.likely
    end = phones.intervals[-1].end
    length = clock.audio
    if length is not None and (not sensible or abs(end - length) > max(APART, 0.1 * length)):
        fitting = {
            name: abs(end * unit / recording.unit - length)
            for name, unit in CANDIDATES.items()
            if abs(unit / recording.unit - 1) > NEAR and 0.02 <= mean * unit / recording.unit <= LONGEST
        }
        name = min(fitting, key=lambda name: fitting[name], default="")
        if name and fitting[name] <= max(NEAR * length, 0.05):
            factor = CANDIDATES[name] / recording.unit
            told = f"it lasts {length:.2f} s, and the alignment then {end * factor:.2f} s"
            return factor, (f"times were read as {name}, to match the recording: {told}",)
    if not sensible:
        raise source.error(_refusal(mean, recording, source.name))
    return 1.0, _guessed_rate(recording, clock, source)


def _guessed_rate(recording: Recording, clock: Clock, source: AlignmentFile) -> tuple[str, ...]:
    """A note where times are counted in samples at the rate of TIMIT though nothing names that corpus."""
    timit = abs(recording.unit * 16_000 - 1) < 1e-9
    if not timit or clock.audio is not None or source.name.lower().endswith((".phn", ".wrd")):
        return ()
    return ("times were read as samples at 16000 Hz, as in TIMIT; --unit samples@RATE sets another rate",)


def settle_offset(recording: Recording, phones: Tier, clock: Clock) -> tuple[float, tuple[str, ...]]:
    """The time that is 0 of the animation, in seconds, and a note where it is not 0."""
    if clock.offset is not None:
        return clock.offset, (f"times are counted from {clock.offset:g} s, as set by --offset",)
    start, audio = recording.start, clock.audio
    first = phones.intervals[0].start if phones.intervals else 0.0
    last = max([recording.end, *(one.end for one in phones.intervals[-1:])])
    for begin, least in ((start, 2 * ROUNDING), (first, LATE_LABEL)):
        cut = audio is not None and begin > least and audio < last - min(begin / 2, APART)
        if cut and audio is not None and abs(last - begin - audio) <= max(NEAR * audio, 0.05):
            told = f"the recording lasts {audio:.2f} s, as the part from there does"
            return begin, (f"times are counted from {begin:g} s, where the file starts: {told}",)
    if start >= LATE_START:
        return start, (f"times are counted from {start:g} s, where the file starts",)
    said = next((one.start for one in phones.intervals if not is_silent(one.label)), 0.0)
    if audio is None and said >= FAR:
        shown = f"there is no speech before {said:.2f} s"
        return 0.0, (f"{shown}; where the recording was cut out there, give --offset {math.floor(said):g}",)
    return 0.0, ()


def length_notes(recording: Recording, phones: Tier, offset: float, clock: Clock) -> tuple[str, ...]:
    """A note where an alignment goes on after its recording, or ends before the half of it."""
    last = max([recording.end, *(one.end for one in phones.intervals[-1:])]) - offset
    audio = clock.audio
    if audio is None or audio / 2 <= last <= audio + APART or audio > offset + last >= audio / 2:
        return ()
    lasts = f"the recording lasts {audio:.2f} s and the alignment {last:.2f} s"
    return (f"{lasts}; check that they belong together, or give --unit or --offset",)


def cut_before(tier: Tier, offset: float) -> Tier:
    """The tier without what lies before `offset` seconds."""
    later = (one for one in tier.intervals if not one.end <= offset)
    return replace(tier, intervals=tuple(replace(one, start=max(one.start, offset)) for one in later))


def scale_times(recording: Recording, tier: Tier, factor: float) -> tuple[Recording, Tier]:
    """A recording and one of its tiers with all times multiplied."""
    if factor == 1.0:
        return recording, tier
    scaled = {id(one): _scaled(one, factor) for one in recording.tiers}
    changed = replace(
        recording,
        tiers=tuple(scaled.values()),
        start=recording.start * factor,
        end=recording.end * factor,
        unit=recording.unit * factor,
    )
    return changed, scaled.get(id(tier)) or _scaled(tier, factor)


def _scaled(tier: Tier, factor: float) -> Tier:
    moved = (Interval(one.label, one.start * factor, one.end * factor) for one in tier.intervals)
    return replace(tier, intervals=tuple(moved))


def _lengths(intervals: Iterable[Interval]) -> list[float]:
    lengths = (one.end - one.start for one in intervals)
    return sorted(length for length in lengths if 0 < length < math.inf)


def _mean(intervals: Iterable[Interval]) -> float | None:
    lengths = _lengths(intervals)
    return sum(lengths) / len(lengths) if len(lengths) >= FEWEST else None


def _is_sensible(intervals: Iterable[Interval]) -> bool:
    """Whether spoken phones last as long as phones do."""
    lengths = _lengths(one for one in intervals if not is_silent(one.label))
    mean = sum(lengths) / len(lengths)
    enough = len(lengths) >= SURE or mean > BEYOND
    too_long = enough and mean > LONGEST and lengths[len(lengths) // 4] > SHORT_ONES
    return mean >= SHORTEST and not too_long


def _refusal(mean: float, recording: Recording, name: str) -> str:
    """One line that says how long a phone would last, and the unit that the times are likely in."""
    shown = f"{mean * 1000:.2g} ms" if mean < 1 else f"{mean:.3g} s"
    told = f"a phone lasts {shown} on average, which speech does not"
    unit = recording.unit
    lengths = {known: mean * seconds / unit for known, seconds in CANDIDATES.items()}
    others = {
        known: one for known, one in lengths.items() if abs(one / mean - 1) > NEAR and LEAST <= one <= MOST
    }
    if not others:
        return f"{told}; give --unit s, ms, 100ns or samples@RATE, even if its unit is correct"
    likely = recording.likely or min(others, key=lambda known: abs(math.log(others[known] / USUAL)))
    likely = TIMIT if name.lower().endswith((".phn", ".wrd")) and likely.startswith("samples") else likely
    counted = likely.startswith("samples") and not likely.endswith(("@100", "@50"))
    rate = " (with the recording's rate)" if counted else ""
    return (
        f"{told}; its times are likely {likely}: give --unit {likely}{rate}, or s, ms, 100ns or samples@RATE"
    )
