"""Lines of text that are shown once for each word, with that word marked: the marks time the words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise


@dataclass(frozen=True, slots=True)
class StyledCue:
    """A line from `start` to `end` seconds, as runs of a style ("" for none) and a text."""

    start: float
    end: float
    runs: tuple[tuple[str, str], ...]

    @property
    def text(self) -> str:
        """The text without its styles and with single blanks."""
        return " ".join("".join(text for _, text in self.runs).split())


def spoken_words(cues: Sequence[StyledCue]) -> list[StyledCue]:
    """The cues, where each group that marks one word after the other has the marked words alone."""
    found: list[StyledCue] = []
    for _, group in groupby(cues, lambda cue: cue.text):
        same = list(group)
        style = _marking(same)
        found += same if style is None else _marked(same, style)
    return found


def _marking(cues: list[StyledCue]) -> str | None:
    """The style of one run in every cue that has styles, which moves on; None where there is none."""
    styled = [cue for cue in cues if len(_spoken(cue)) > 1]
    if len(styled) < 2:
        return None
    for style in dict.fromkeys(style for cue in styled for style, _ in _spoken(cue)):
        places = [[place for kind, place in _spoken(cue) if kind == style] for cue in styled]
        firsts = [place[0] for place in places if len(place) == 1]
        if len(firsts) == len(styled) and all(a < b for a, b in pairwise(firsts)):
            return style
    return None


def _spoken(cue: StyledCue) -> list[tuple[str, int]]:
    """The styles of the runs that are not blank, each with the place at which its text begins."""
    found, place = [], 0
    for style, text in cue.runs:
        if text.strip():
            found.append((style, place))
        place += len(text)
    return found


def _marked(cues: list[StyledCue], style: str) -> Iterator[StyledCue]:
    """The marked words; a cue without a mark is a pause between them."""
    for cue in cues:
        texts = [text for kind, text in cue.runs if kind == style and text.strip()]
        if len(_spoken(cue)) > 1 and texts:
            yield StyledCue(cue.start, cue.end, (("", texts[0]),))
