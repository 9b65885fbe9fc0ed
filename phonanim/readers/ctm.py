"""CTM of NIST, Kaldi and NeMo: utterance, channel, start, duration, label and often a confidence."""

from __future__ import annotations

import re

from phonanim.readers._rows import LONGEST_ROW, all_match, lines, split
from phonanim.readers._words import spread_text
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import AlignmentFile

FORMAT = "CTM"
ROUNDING = 0.0101  # seconds: times are rounded to 10 ms each, so neighbours may be that far apart
LONGEST_BLANK = 0.25  # seconds of a blank that belong to the token before it

_NUMBER = r"\d+(?:\.\d*)?(?:[eE][-+]?\d{1,2})?"
# Behind the label stand a confidence or "NA", a kind and a speaker.
_REST = rf"({_NUMBER})\s+({_NUMBER})\s+(\S+)(?:\s+(?:-?{_NUMBER}|NA))?(?:\s+\S+){{0,3}}"
_ROW = re.compile(rf"(\S+)\s+(\w+)\s+{_REST}")
_ROW_WITHOUT_CHANNEL = re.compile(rf"(?=\S*[^\d.\s])(\S+)()\s+{_REST}")
_LABEL = re.compile(r"(?!-?[\d.]+$)(?!\".*\"$)\S+")
_NUMBERED = re.compile(rf"\S*[^\d.\s]\S*\s+[1A]\s+{_NUMBER}\s+{_NUMBER}\s+\d+(?:\s+{_NUMBER})?")
_OTHERWISE = re.compile(r"\S+\s+\S+\s+\*\s+\*\s+<(ALT_BEGIN|ALT|ALT_END)>")
WORD_STARTS = ("▁", "Ġ", "_")
BLANKS = ("<b>", "<blank>", "<blk>")
SPACE = "<space>"
SPACES = (SPACE, "▁", "Ġ", "|")


def recognizes(source: AlignmentFile) -> bool:
    """Whether all rows have these columns; comments begin with two semicolons."""
    return _layout(source) is not None or bool(_numbered(source))


def read(source: AlignmentFile) -> Recording:
    """One tier for each utterance and channel, which are used as speakers; tokens form words."""
    if _numbered(source):
        told = "has numbers for its labels; replace them by their names, as int2sym.pl of Kaldi does"
        raise source.error(f"{told} with phones.txt")
    tracks: dict[str, list[Interval]] = {}
    rows = split(source, _layout(source) or _ROW, _rows(source))
    for match in rows:
        start, length = float(match[3]), float(match[4])
        track = tracks.setdefault(f"{match[1]} {match[2]}".strip(), [])
        if track and abs(track[-1].end - start) < ROUNDING and start > track[-1].start:
            track[-1] = Interval(track[-1].label, track[-1].start, start)
        track.append(Interval(re.sub("_[BIES]$", "", match[5]), start, start + length))
    tiers = []
    for number, (name, track) in enumerate(tracks.items(), 1):
        kind, intervals = ("words", _words(track)) if _are_tokens(track) else ("labels", track)
        if any(SPACE in one.label for one in intervals):
            kind, intervals = "words", _apart(intervals)
        tiers.append(Tier(kind, tuple(intervals), number, name))
    return Recording(tuple(tiers), 0.0, max(track[-1].end for track in tracks.values()))


def _layout(source: AlignmentFile) -> re.Pattern[str] | None:
    """The columns of the first rows: some writers leave the channel out."""
    plain = AlignmentFile(source.name, source.stem, "\n".join(_rows(source)).encode())
    for pattern in (_ROW, _ROW_WITHOUT_CHANNEL):
        rows = all_match(plain, pattern)
        if rows and all(_LABEL.fullmatch(match[5]) for match in rows):
            return pattern
    return None


def _numbered(source: AlignmentFile) -> list[re.Match[str]]:
    """The first rows, if each has a number instead of a label."""
    return all_match(source, _NUMBERED)


def _rows(source: AlignmentFile) -> list[str]:
    """The rows that are no comments; of alternatives (NIST) the first."""
    kept: list[str] = []
    other = False
    for line in lines(source):
        if mark := _OTHERWISE.fullmatch(line[:LONGEST_ROW]):
            other = mark[1] == "ALT"
        elif not other and not line.startswith(";;"):
            kept.append(line)
    return kept


def _are_tokens(track: list[Interval]) -> bool:
    """Whether the labels are pieces of words, as recognizers with a vocabulary of pieces write them."""
    return any(one.label in (*BLANKS, SPACE) or one.label.startswith(WORD_STARTS[:2]) for one in track)


def _apart(lines_of_text: list[Interval]) -> list[Interval]:
    """The words of whole lines, whose blanks are written as a mark; they share the time of their line."""
    found: list[Interval] = []
    for one in lines_of_text:
        spread = spread_text(one.label.replace(SPACE, " "), one.start, one.end)
        found += [Interval(word.text, word.start, word.end) for word in spread]
    return found


def _words(track: list[Interval]) -> list[Interval]:
    """The words that tokens form.

    Such recognizers place a token at a point, so the blank after it is its own, up to a limit.
    """
    words: list[Interval] = []
    fresh = True
    for token in track:
        if token.label in BLANKS:
            if words and token.start - words[-1].end < ROUNDING:
                end = min(token.end, words[-1].end + LONGEST_BLANK)
                words[-1] = Interval(words[-1].label, words[-1].start, end)
            continue
        bare = "" if token.label in SPACES else token.label.lstrip("".join(WORD_STARTS))
        fresh = fresh or token.label.startswith(WORD_STARTS[:2]) or token.label in SPACES
        if bare and (fresh or not words):
            words.append(Interval(bare, token.start, token.end))
            fresh = False
        elif bare:
            words[-1] = Interval(words[-1].label + bare, words[-1].start, token.end)
    return words
