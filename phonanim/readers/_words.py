"""Words with their times, as speech recognizers and synthesizers give them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sized
from dataclasses import dataclass
from itertools import islice
from typing import Any

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import TooManyWordsError

MOST_NESTED = 12
MOST_WORDS = 200_000
"""Words of a file: two hours of fast speech have about 40,000."""

UNTIMED = math.nan
UNNAMED = "unnamed"  # the speaker of words that name none, in a file where others do
_SPEAKER = re.compile(
    r"\s*(?:\[((?:[A-Z]{1,20}|[Ss]peaker)[_ ]?\d{1,3})\]:?|([A-Z][A-Z0-9 .'_-]{1,30}):)\s+(?=\S)"
)
_WORD = re.compile(r"[\[(][^\])]{0,200}[\])]|\S+")
SPREAD = "the words of a line of text share its time by their letters"


@dataclass(frozen=True, slots=True)
class TimedWord:
    """A word with its start and end in seconds, NaN where unknown, and its speaker if the file names one."""

    text: str
    start: float
    end: float
    speaker: str = ""


def word_recording(
    words: Iterable[TimedWord],
    end: float = 0.0,
    notes: tuple[str, ...] = (),
    unit: float = 1.0,
    spoken: str = "",
) -> Recording:
    """One tier of words for each speaker; `spoken` is the language that the file names."""
    tracks: dict[str, list[Interval]] = {}
    for word in words:
        if word.text.strip():
            track = tracks.setdefault(word.speaker, [])
            track.append(Interval(word.text.strip(), word.start, word.end))
    if len(tracks) > 1 and "" in tracks:
        tracks = {speaker or UNNAMED: track for speaker, track in tracks.items()}
    tiers = [Tier("words", tuple(track), n, speaker) for n, (speaker, track) in enumerate(tracks.items(), 1)]
    ends = [one.end for track in tracks.values() for one in track if math.isfinite(one.end)]
    return Recording(tuple(tiers), 0.0, max([end, *ends]), notes, unit=unit, spoken=spoken)


def spread_text(text: str, start: float, end: float, speaker: str = "") -> list[TimedWord]:
    """The words of a text, which share the time from `start` to `end` by their letters.

    A sound in brackets, such as (door slams), is one word. Raises TooManyWordsError.
    """
    words = [found[0] for found in islice(_WORD.finditer(text), MOST_WORDS + 1)]
    check_count(words)
    weights = [len(re.sub(r"\W", "", word)) + 1 for word in words]
    total = sum(weights)
    spread = []
    time = start
    for word, weight in zip(words, weights, strict=True):
        last = time + (end - start) * weight / total
        spread.append(TimedWord(word, time, last, speaker))
        time = last
    return spread


def check_count(words: Sized) -> None:
    """Raise TooManyWordsError when there are more words than a recording has."""
    if len(words) > MOST_WORDS:
        raise TooManyWordsError(f"has more than {MOST_WORDS:,} words")


def split_speaker(text: str) -> tuple[str, str]:
    """The speaker that a line names in capitals or in brackets before a colon, "" for none, and the rest."""
    found = _SPEAKER.match(text)
    return (found[1] or found[2], text[found.end() :]) if found else ("", text)


def spread_lines(lines: Iterable[Interval]) -> list[TimedWord]:
    """The words of labelled lines of text, each with the speaker that its line names."""
    words: list[TimedWord] = []
    for line in lines:
        speaker, text = split_speaker(line.label)
        words += spread_text(text, line.start, line.end, speaker)
        check_count(words)
    return words


def are_lines(labels: Iterable[str]) -> bool:
    """Whether most labels are lines of text: of several words."""
    spoken = [label for label in labels if label.strip()]
    return 2 * sum(" " in label.strip() for label in spoken) > len(spoken)


def first_value(item: Mapping[str, Any], names: Iterable[str]) -> Any:
    """The value of the first of these keys that an item has and that is not null; None without any."""
    return next((item[name] for name in names if item.get(name) is not None), None)


def seconds(value: Any, unit: float = 1.0) -> float:
    """A time in seconds, NaN for null. Raises TypeError or ValueError for what is no number."""
    if isinstance(value, bool):
        raise TypeError("a time is true or false")
    return UNTIMED if value is None else float(value) * unit


def tables(content: Any) -> Iterator[dict[str, Any]]:
    """Every table of a JSON value, from the outside in."""
    waiting = [(content, 0)]
    while waiting:
        value, depth = waiting.pop()
        if isinstance(value, dict):
            yield value
            inner = list(value.values())
        else:
            inner = value if isinstance(value, list) else []
        if depth < MOST_NESTED:
            waiting += [(one, depth + 1) for one in reversed(inner) if isinstance(one, (dict, list))]
