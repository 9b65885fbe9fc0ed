"""Projects of OpenUtau (.ustx), as YAML: notes with their lyrics, in ticks of the tempo."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable
from typing import Any

from phonanim.errors import MissingExtraError
from phonanim.readers._times import share
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "OpenUtau project (.ustx)"
HINTED = "the phones of a lyric share its note equally"

_ANCHOR = re.compile(r"(?m)(?:^[ \t]*-|:)\s+[&*]\w|^[&*]\w|[\[,{]\s*[&*]\w")
_HINT = re.compile(r"([^\[]*)\[(.*)\]\s*")
_EXTENDED = re.compile(r"\+[~*\d.]*|[-ー~]")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is YAML with the version of such a project, or with its parts of voices and its tempo."""
    head = source.text[:100_000]
    if re.search(r"^ustx_version:", head, re.MULTILINE):
        return True
    return bool(
        re.search(r"^voice_parts:", source.text, re.MULTILINE) and re.search(r"^tempos:|^bpm:", head, re.M)
    )


def read(source: AlignmentFile) -> Recording:
    """A tier of lyrics for each part, and of the phones that lyrics such as "read[r eh d]" give.

    The project does not keep the phones that its phonemizer makes, so lyrics without a hint are words.
    Raises MissingExtraError without PyYAML.
    """
    content = _load(source)
    try:
        seconds = _clock(content)
        tiers: list[Tier] = []
        for part in content.get("voice_parts") or ():
            name = str(part.get("name") or "")
            for kind, intervals in _tiers(part, seconds):
                tiers.append(Tier(kind, intervals, len(tiers) + 1, name))
        end = max((one.end for tier in tiers for one in tier.intervals), default=0.0)
    except DAMAGE as error:
        raise source.error(f"is a damaged project ({error!r}); save it again") from error
    if not tiers:
        raise source.error("has no notes; save it with a part that is sung")
    notes = (HINTED,) if any(tier.name == "phones" for tier in tiers) else ()
    return Recording(tuple(tiers), 0.0, end, notes)


def _load(source: AlignmentFile) -> dict[str, Any]:
    try:
        import yaml
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name}: reading .ustx needs pip install 'phonanim[singing]'"
        ) from error
    if re.search(r"(?m)(^|[\s\[{,:-])[&*][A-Za-z]", source.text[:64]) or re.search(
        r":\s+[&*]\w+", source.text
    ):
        raise source.error("has anchors, which a project does not need; save it again")
    try:
        content = yaml.load(source.text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        line = str(error).split("\n")[0]
        raise source.error(f"is a damaged project ({line}); save it again") from error
    if not isinstance(content, dict):
        raise source.error("is a damaged project; save it again")
    return content


def _clock(project: dict[str, Any]) -> Callable[[float], float]:
    """A function from ticks to seconds, through every change of tempo."""
    resolution = float(project.get("resolution") or 480)
    told = [(float(one["position"]), float(one["bpm"])) for one in project.get("tempos") or ()]
    tempos = sorted(told) or [(0.0, float(project["bpm"]))]
    rates = [60.0 / bpm / resolution for _, bpm in tempos]  # seconds per tick
    ticks = [0.0, *(tick for tick, _ in tempos[1:])]
    starts = [0.0]
    for n in range(1, len(ticks)):
        starts.append(starts[-1] + (ticks[n] - ticks[n - 1]) * rates[n - 1])

    def seconds(tick: float) -> float:
        n = max(bisect_right(ticks, tick) - 1, 0)
        return starts[n] + (tick - ticks[n]) * rates[n]

    return seconds


def _tiers(part: dict[str, Any], seconds: Callable[[float], float]) -> list[tuple[str, tuple[Interval, ...]]]:
    """The words of a part; and its phones, if every lyric has a hint."""
    first = float(part.get("position") or 0.0)
    words: list[Interval] = []
    for note in part.get("notes") or ():
        start = first + float(note["position"])
        begin, end = seconds(start), seconds(start + float(note["duration"]))
        lyric = str(note.get("lyric") or "").strip()
        if _EXTENDED.fullmatch(lyric) and words:
            words[-1] = Interval(words[-1].label, words[-1].start, end)
        else:
            words.append(Interval(lyric, begin, end))
    hints = [_HINT.fullmatch(word.label) for word in words]
    plain = tuple(
        Interval(hint[1] or hint[2] if hint else word.label, word.start, word.end)
        for word, hint in zip(words, hints, strict=True)
    )
    tiers = [("words", plain)] if plain else []
    if words and all(hints):
        phones = [
            p
            for word, hint in zip(words, hints, strict=True)
            if hint
            for p in share(hint[2].split(), word.start, word.end)
        ]
        tiers.append(("phones", tuple(phones)))
    return tiers
