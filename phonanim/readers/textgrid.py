"""Praat TextGrid as text: long, short and chronological, with any spacing and comments."""

from __future__ import annotations

import re
from collections.abc import Iterator

from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile, quote_label

FORMAT = "Praat TextGrid"

# Praat reads free-standing numbers, quoted strings and flags, in any layout, and ignores everything else:
# https://www.fon.hum.uva.nl/praat/manual/TextGrid_file_formats.html. So the long form is the short form with
# comments, and one reader handles both.
_TOKEN = re.compile(r'"([^"]*(?:""[^"]*)*)"|!.*|<(\w+)>|([^\s"=]+)')
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf(?:inity)?)", re.IGNORECASE)
_BEGINNINGS = frozenset("+-.0123456789nNiI")  # of numbers; most words of the long form are comments
_CLASS = re.compile(r"TextGrid(?: \d+)?")
_CHRONOLOGICAL = "Praat chronological TextGrid text file"


def recognizes(source: AlignmentFile) -> bool:
    """Whether the first text is that of Praat's text files."""
    head = source.text[:200].lstrip()
    if head.startswith("File type"):
        return "ooTextFile" in head
    return head.startswith((f'"{_CHRONOLOGICAL}"', '"ooTextFile'))


def read(source: AlignmentFile) -> Recording:
    """Every interval tier, in file order; point tiers are ignored."""
    recording = _read(source)
    if "\\" not in source.text:
        return recording
    from phonanim.readers._trigraphs import decode_trigraphs

    return decode_trigraphs(recording)


def _read(source: AlignmentFile) -> Recording:
    tokens = _Tokens(source)
    if (kind := tokens.string()) == _CHRONOLOGICAL:
        return _read_chronological(tokens)
    kind = tokens.string() if kind.startswith("ooTextFile") else ""
    if kind == "Collection":
        tokens.find_textgrid()
    elif kind == "IntervalTier":
        return _read_lone_tier(tokens)
    elif kind != "TextGrid":
        raise source.error(
            f'contains a Praat object of class "{quote_label(kind)}", not a TextGrid; save the TextGrid alone'
        )
    start, end = tokens.number(), tokens.number()
    tiers = [_read_tier(tokens, number) for number in range(1, tokens.tier_count() + 1)]
    return Recording(tuple(tier for tier in tiers if tier), start, end)


def _read_lone_tier(tokens: _Tokens) -> Recording:
    """An interval tier that was saved alone, without a name."""
    start, end = tokens.number(), tokens.number()
    intervals = [
        Interval(text.strip(), first, last)
        for first, last, text in (
            (tokens.number(), tokens.number(), tokens.string()) for _ in range(tokens.count())
        )
    ]
    return Recording((Tier("labels", tuple(intervals)),), start, end)


def _read_tier(tokens: _Tokens, number: int) -> Tier | None:
    tokens.place = f"tier {number}"
    kind, name = tokens.string(), tokens.string()
    tokens.number(), tokens.number()
    count = tokens.count()
    if kind == "IntervalTier" and (whole := tokens.intervals(count)):
        return Tier(name, whole, number)
    shown = quote_label(name)
    intervals = []
    for entry in range(1, count + 1):
        tokens.place = f'tier {number} "{shown}", entry {entry} of {count}'
        start = tokens.number()
        end = tokens.number() if kind == "IntervalTier" else start
        intervals.append(Interval(tokens.string().strip(), start, end))
    return Tier(name, tuple(intervals), number) if kind == "IntervalTier" else None


def _read_chronological(tokens: _Tokens) -> Recording:
    start, end = tokens.number(), tokens.number()
    headers = []
    for _ in range(tokens.count()):
        headers.append((tokens.string(), tokens.string()))
        tokens.number(), tokens.number()
    entries: list[list[Interval]] = [[] for _ in headers]
    while tokens.more():
        number = tokens.count()
        if not 1 <= number <= len(headers):
            raise tokens.source.error(f"is damaged: an entry belongs to tier {number} of {len(headers)}")
        first = tokens.number()
        last = tokens.number() if headers[number - 1][0] == "IntervalTier" else first
        entries[number - 1].append(Interval(tokens.string().strip(), first, last))
    tiers = [
        Tier(name, tuple(found), number)
        for number, ((kind, name), found) in enumerate(zip(headers, entries, strict=True), 1)
        if kind == "IntervalTier"
    ]
    return Recording(tuple(tiers), start, end)


class _Tokens:
    """The free-standing strings, numbers and flags of a Praat text file, in order."""

    def __init__(self, source: AlignmentFile) -> None:
        self.source = source
        self.place = "header"
        self._tokens = list(_scan(source.text))
        self._next = 0

    def more(self) -> bool:
        return self._next < len(self._tokens)

    def find_textgrid(self) -> None:
        """Go to the content of the one TextGrid of a collection, behind its class and its name."""
        places = [
            n for n, token in enumerate(self._tokens) if isinstance(token, str) and _CLASS.fullmatch(token)
        ]
        if len(places) != 1:
            told = f"is a collection of Praat with {len(places)} TextGrids"
            raise self.source.error(f"{told}; save the TextGrid of the line alone")
        self._next = places[0] + 2

    def intervals(self, count: int) -> tuple[Interval, ...]:
        """So many intervals at once; none where what comes next is anything else."""
        last = self._next + 3 * count
        starts, ends, texts = (self._tokens[self._next + part : last : 3] for part in range(3))
        if len(texts) != count or {*map(type, starts), *map(type, ends)} != {float}:
            return ()  # damaged, or empty: read one by one, which names the place
        if set(map(type, texts)) != {str}:
            return ()
        self._next = last
        entries = zip(texts, starts, ends, strict=True)
        return tuple(Interval(str(text).strip(), float(start), float(end)) for text, start, end in entries)

    def string(self) -> str:
        return str(self._take(str, "a text in quotes"))

    def number(self) -> float:
        return float(self._take(float, "a number"))

    def count(self) -> int:
        value = self.number()
        if not 0 <= value < 1e7 or value != int(value):
            raise self._damaged(f"the count is {value:g}")
        return int(value)

    def tier_count(self) -> int:
        """The number of tiers, which the flag <exists> precedes."""
        flag = self._take(_Flag, "<exists>")
        return self.count() if flag == "exists" else 0

    def _take(self, kind: type, expected: str) -> str | float:
        if not self.more():
            raise self._damaged(f"the file ends where {expected} is expected")
        token = self._tokens[self._next]
        if type(token) is not kind:
            raise self._damaged(f'"{quote_label(str(token))}" is found where {expected} is expected')
        self._next += 1
        return token

    def _damaged(self, what: str) -> Exception:
        return self.source.error(f"{self.place}: {what}; the file is truncated or damaged, save it again")


class _Flag(str):
    """A word in angle brackets."""

    __slots__ = ()


def _scan(text: str) -> Iterator[str | float]:
    for match in _TOKEN.finditer(text):
        quoted, flag, word = match.groups()
        if quoted is not None:
            yield quoted.replace('""', '"')
        elif flag is not None:
            yield _Flag(flag)
        elif word is not None and word[0] in _BEGINNINGS and _NUMBER.fullmatch(word):
            yield float(word)
