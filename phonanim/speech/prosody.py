"""Prosody: the phrases, accents and questions of a line, from its phones, words and audio."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from phonanim.media.voice import FRAMES, Voice
from phonanim.speech.alignment import Interval
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack, pair_rows

Array = NDArray[np.float64]

AHEAD = 0.8  # seconds of look-ahead that decide a frame
PAUSE = 0.2  # seconds of silence that separate two phrases
LONG = 0.75  # seconds from which a phrase is an utterance; shorter ones are replies such as "yes"
APART, TOO_NEAR = 0.35, 0.18  # seconds after an accent in which a weaker one, or any other, is dropped
WEAKER = 0.8  # of the strength of the accent before
REDUCED, FULL = 0.05, 0.18  # seconds of a vowel with accent strength 0, and of one with full strength
LEAST = 0.25  # least strength of an accent
ROSE = 6.0  # semitones above the voice's mean pitch that make the strongest accent
STRESS = re.compile(r"^[A-Z]{2}([012])(?:_[BIES])?$")
PRIMARY, SECONDARY = 'ˈ"', "ˌ%"  # stress marks of IPA and of SAMPA
VOWELS = INVENTORY.where(kind="vowel")
SILENT = INVENTORY.code(SILENCE)
NONE: Array = np.zeros(0)


@dataclass(frozen=True)
class Prosody:
    """Events of a line in seconds.

    Phrases last from `starts` to `ends` (phrases,), inf while the end is unknown. `accents` (accents,) are
    the middles of accented vowels, `strengths` their strengths 0 to 1. `questions` (questions, 2) are the
    start and end of the words that end a question. `duration` is the end of the line, inf while it goes on.
    `ahead` is the look-ahead in seconds that may decide a frame: an event has no effect before its instant
    in `starts_from`, `ends_from`, `long_from` (phrases, inf for a short one) or `accents_from`, when it
    becomes known that far ahead. `voice` holds level and pitch if there is audio.
    """

    starts: Array
    ends: Array
    starts_from: Array
    ends_from: Array
    long_from: Array
    accents: Array
    strengths: Array
    accents_from: Array
    questions: Array
    duration: float
    ahead: float
    voice: Voice | None = None

    def speaking(self, times: Array, rise: float = 0.3, fall: float = 0.6) -> Array:
        """How much somebody speaks at instants, (frames,) -> (frames,) 0 to 1, with smooth transitions."""
        total = np.zeros(len(times))
        near, rows = pair_rows(*np.searchsorted(times, [self.starts_from, self.ends_from + fall]))
        begins, ends = self.starts_from[near], self.ends_from[near]
        going = eased((times[rows] - begins) / rise) - eased((times[rows] - ends) / fall)
        np.maximum.at(total, rows, going)
        return total

    def pauses(self) -> Array:
        """Seconds of silence before each phrase, (phrases,)."""
        return self.starts - np.append(0.0, self.ends)[: len(self.starts)]


def eased(share: Array) -> Array:
    """An ease curve from 0 to 1 with a smooth start and end."""
    share = np.minimum(np.maximum(share, 0.0), 1.0)  # a third of the time of np.clip
    return np.asarray(share**2 * (3 - 2 * share))


def read_prosody(
    track: PhoneTrack,
    words: tuple[Interval, ...] = (),
    ahead: float = AHEAD,
    ended: bool = True,
    voice: Voice | None = None,
) -> Prosody:
    """The prosody of phones, with the question marks of words and the pitch of a voice if they are given.

    In a line that goes on (`ended` False), the last phrase has no end until its end is certain.
    """
    first, last = _phrases(track.codes != SILENT, track.bounds)
    begins, finishes = track.bounds[first], track.bounds[last + 1]
    sure_end = np.minimum(finishes + PAUSE, track.duration)
    open_end = ~np.array(ended) & (finishes + PAUSE > track.duration)
    known = _known(track)
    long = [_long(track, known, a, b) for a, b in zip(first, last, strict=True)]
    accents, strengths, sure = _accents(track, known, voice)
    return Prosody(
        starts=begins,
        ends=np.where(open_end, np.inf, finishes),
        starts_from=known[first] - ahead,
        ends_from=np.where(open_end, np.inf, np.maximum(finishes, sure_end - ahead)),
        long_from=np.maximum(np.array(long, float) - ahead, begins),
        accents=accents,
        strengths=strengths,
        accents_from=sure - ahead,
        questions=_questions(words),
        duration=track.duration if ended else np.inf,
        ahead=ahead,
        voice=voice,
    )


def measure_prosody(voice: Voice, ahead: float = AHEAD, ended: bool = True) -> Prosody:
    """The prosody of a recording without phones: phrases by level, accents by peaks of level and pitch."""
    active = voice.active()
    times = voice.start + np.arange(len(active) + 1) / FRAMES
    first, last = _phrases(active, times)
    begins, finishes = times[first], times[last + 1]
    until = float(times[-1])
    open_end = ~np.array(ended) & (finishes + PAUSE > until)
    accents, strengths, sure = _apart(*voice.peaks())
    long = np.where(finishes - begins >= LONG, begins + LONG, np.inf)
    return Prosody(
        starts=begins,
        ends=np.where(open_end, np.inf, finishes),
        starts_from=begins + voice.settled - ahead,
        ends_from=np.where(open_end, np.inf, np.maximum(finishes, finishes + PAUSE + voice.settled - ahead)),
        long_from=np.maximum(long + voice.settled - ahead, begins),
        accents=accents,
        strengths=strengths,
        accents_from=sure - ahead,
        questions=np.zeros((0, 2)),
        duration=until if ended else np.inf,
        ahead=ahead,
        voice=voice,
    )


def _phrases(spoken: NDArray[np.bool_], bounds: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last segment of each phrase; shorter silences do not divide a phrase."""
    edges = np.diff(np.concatenate([[0], spoken.astype(np.int8), [0]]))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    apart = bounds[first[1:]] - bounds[last[:-1] + 1] >= PAUSE
    return first[np.append(True, apart)[: len(first)]], last[np.append(apart, True)[: len(last)]]


def _known(track: PhoneTrack) -> Array:
    """When each segment becomes known, (segments,): the end of its label, which may cover several."""
    other = np.array([a != b for a, b in zip(track.labels, track.labels[1:], strict=False)], bool)
    last = np.append(np.flatnonzero(other), len(track.codes) - 1)
    return track.bounds[1:][last[np.searchsorted(last, np.arange(len(track.codes)))]]


def _long(track: PhoneTrack, known: Array, first: int, last: int) -> float:
    """When a phrase is known to be long: the end of the label that makes it so; inf if it is short."""
    enough = np.flatnonzero(track.bounds[first + 1 : last + 2] >= track.bounds[first] + LONG)
    return float(known[first + enough[0]]) if len(enough) else np.inf


def _accents(track: PhoneTrack, known: Array, voice: Voice | None) -> tuple[Array, Array, Array]:
    """Middles, strengths and ends of accented vowels: by their stress marks, else by their length."""
    rows = np.flatnonzero(VOWELS[track.codes])
    middles = (track.bounds[rows] + track.bounds[rows + 1]) / 2
    length = np.clip((track.bounds[rows + 1] - track.bounds[rows] - REDUCED) / (FULL - REDUCED), 0.0, 1.0)
    marks = np.array([stress(track.labels[row]) for row in rows], float)
    strengths = np.where(np.isnan(marks), 0.8 * length, marks * (0.4 + 0.6 * length))
    if voice is not None:
        strengths *= 0.75 + 0.5 * np.clip(voice.melody_at(middles) / ROSE, -0.5, 1.0)
        strengths = np.minimum(strengths, 1.0)
    kept = strengths >= LEAST
    return _apart(middles[kept], strengths[kept], known[rows][kept])


def _apart(times: Array, strengths: Array, sure: Array) -> tuple[Array, Array, Array]:
    """Drop accents that follow a stronger one too soon."""
    before = np.searchsorted(times, times - APART)
    near = np.diff(times, prepend=-np.inf) < TOO_NEAR
    louder = [(WEAKER * strengths[a:i] > strengths[i]).any() for i, a in enumerate(before)]
    kept = ~(near | np.array(louder, bool))
    return times[kept], strengths[kept], sure[kept]


@lru_cache(maxsize=4096)
def stress(label: str) -> float:
    """The stress mark of a label: 1 primary, 0.5 secondary, 0 none, NaN when it has no mark."""
    if digit := STRESS.match(label):
        return (0.0, 1.0, 0.5)[int(digit[1])]
    if any(mark in label for mark in PRIMARY):
        return 1.0
    return 0.5 if any(mark in label for mark in SECONDARY) else np.nan


def _questions(words: tuple[Interval, ...]) -> Array:
    spans = [(word.start, word.end) for word in words if word.label.rstrip("\"')”»").endswith(("?", "？"))]
    return np.array(spans, float).reshape(-1, 2)
