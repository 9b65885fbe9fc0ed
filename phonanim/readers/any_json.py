"""JSON of a program that no other reader knows: labels with times, found by how programs call them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

from phonanim.readers._columns import guess_unit
from phonanim.readers._json_found import Found
from phonanim.readers._json_lists import find_lists
from phonanim.readers._visemes import AZURE, NOTE, oculus_phone
from phonanim.readers._words import SPREAD, TimedWord, check_count, spread_text, word_recording
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "labels with times in a layout of JSON that is found by its names"
GUESSES = True
"""Whether this reader is tried after all that know their format."""

LAST_SHAPE = 0.1  # seconds of the last label where no end is given
SAME_START = 20  # labels that may start at once
SHOWN = 5  # labels that a note names
OCULUS = 14  # the largest number of a viseme of Oculus; those of Azure go to 21


def recognizes(source: AlignmentFile) -> bool:
    """Whether a place of the file has labels and times."""
    try:
        return bool(_lists(source))
    except DAMAGE:
        return True


def read(source: AlignmentFile) -> Recording:
    """The words and the phones, else the visemes or labels; a note says where they were found."""
    try:
        used = _used(_lists(source))
        _check_shapes(used, source)
        tiers: list[Tier] = []
        words: list[TimedWord] = []
        notes = []
        likely = ""
        for found in used:
            unit = _unit(found)
            if math.isnan(unit):
                unit, likely = 1.0, likely or _likely(found)
            shown = "frames" if likely else _shown(unit)
            notes.append(f"read by its names, check the times: {found.names}, in {shown}")
            if found.untimed:
                some = ", ".join(found.untimed[:SHOWN])
                notes.append(f"{len(found.untimed)} labels without times are left out: {some}")
            if found.kind == "words":
                words += _words(found, unit)
            else:
                tiers.append(Tier(_name(found), tuple(_intervals(found, unit)), len(tiers) + 2))
    except DAMAGE as error:
        raise source.error(f"has damaged times ({error}); export it again") from error
    shapes = any(found.kind == "visemes" for found in used)
    spread = any(_is_line(label) for found in used if found.kind == "words" for label, *_ in found.entries)
    notes += [SPREAD] * spread + [NOTE] * shapes
    end = max((one.end for tier in tiers for one in tier.intervals), default=0.0)
    whole = word_recording(words, end, (), unit)
    told = tuple(dict.fromkeys(notes))
    language = "english" if shapes else ""
    return Recording((*whole.tiers, *tiers), 0.0, whole.end, told, language, whole.unit, likely=likely)


@lru_cache(maxsize=1)  # for recognizes and read
def _lists(source: AlignmentFile) -> list[Found]:
    return find_lists(source.json_lines)


def _used(lists: Sequence[Found]) -> list[Found]:
    """The places to read: of phones and of words the one with the most entries, else visemes, else labels."""
    best: dict[str, Found] = {}
    for found in lists:
        kept = best.get(found.kind)
        if kept is None or _rank(found) > _rank(kept):
            best[found.kind] = found
    used = [best[kind] for kind in ("words", "phones") if kind in best]
    if "phones" not in best and "visemes" in best:
        used.append(best["visemes"])
    return used or [best["labels"]]


def _rank(found: Found) -> tuple[bool, int]:
    """Places with single words before others, then those with more entries."""
    return not any(_is_line(label) for label, *_ in found.entries), len(found.entries)


def _unit(found: Found) -> float:
    if found.unit is not None:
        return found.unit
    lengths = [end - start for _, start, end, _ in found.entries if math.isfinite(end)]
    if not any(math.isfinite(length) for length in lengths):
        starts = sorted(start for _, start, _, _ in found.entries if math.isfinite(start))
        lengths = [b - a for a, b in pairwise(starts)]
    labels = sum(max(len(label.split()), 1) for label, *_ in found.entries)
    return guess_unit(lengths, labels, found.kind == "words")


def _likely(found: Found) -> str:
    """The probable length of a frame: 20 ms in networks such as wav2vec 2.0, else 10 ms."""
    lengths = [end - start for _, start, end, _ in found.entries if math.isfinite(end)]
    mean = sum(lengths) / max(len(lengths), 1)
    letters = sum(len(label) for label, *_ in found.entries)
    words = found.kind == "words" or letters >= 3 * len(found.entries)
    of_network = "offset" in found.names.lower() or "token" in found.names.lower()
    return "samples@50" if of_network or mean < (28 if words else 8) else "samples@100"


def _shown(unit: float) -> str:
    named = {1.0: "seconds", 1e-3: "milliseconds", 1e-7: "ticks of 100 ns"}
    return named.get(unit, f"frames of {unit * 1000:.3g} ms")


def _name(found: Found) -> str:
    return "labels" if found.kind == "labels" else "phones"


def _words(found: Found, unit: float) -> list[TimedWord]:
    """The words; pieces of words, which begin with a blank, are joined."""
    words: list[TimedWord] = []
    labels = [label for label, *_ in found.entries]
    pieces = any(map(_opens, labels[1:])) and not all(map(_opens, labels[1:]))
    if len(labels) > SHOWN and all(map(_is_letter, labels)):
        raise ValueError("its labels are letters, not words or sounds")
    for n, (label, start, end, speaker) in enumerate(found.entries):
        text = label.replace("▁", " ")
        start, end = start * unit, end * unit
        if math.isnan(end) and n + 1 < len(found.entries) and pieces:
            end = found.entries[n + 1][1] * unit
        if pieces and words and not _opens(label):
            last = words[-1]
            words[-1] = TimedWord(last.text + text, last.start, end, last.speaker)
        elif _is_line(text) and math.isfinite(end - start):
            words += spread_text(text, start, end, speaker)
            check_count(words)
        elif any(c.isalnum() for c in text):
            words.append(TimedWord(text, start, end, speaker))
    return words


def _is_letter(label: str) -> bool:
    """Whether a label is one letter, or nothing: in English, where a letter is no word."""
    return label.isascii() and len(label.strip()) <= 1


def _is_line(label: str) -> bool:
    """Whether a label is more than a word."""
    return " " in label.strip()


def _opens(label: str) -> bool:
    return label[:1] in (" ", "▁")


def _intervals(found: Found, unit: float) -> list[Interval]:
    """The entries as intervals: one without an end lasts to the next, one without a start begins there."""
    shapes = _shapes(found) if found.kind == "visemes" else [entry[0] for entry in found.entries]
    intervals: list[Interval] = []
    time = 0.0
    for n, (_, start, end, _) in enumerate(found.entries):
        if math.isnan(start):
            start, end = time, time + end
        if math.isnan(end):
            later = (other for _, other, *_ in found.entries[n + 1 : n + 1 + SAME_START])
            end = next((other for other in later if other > start), start + LAST_SHAPE / unit)
        intervals.append(Interval(shapes[n].strip(), start * unit, end * unit))
        time = end
    return intervals


def _shapes(found: Found) -> list[str]:
    """Visemes of Oculus by name, or of Azure by number, as phones."""
    labels = [label for label, *_ in found.entries]
    return [AZURE[int(label)] if label.isdecimal() else oculus_phone(label) for label in labels]


def _check_shapes(used: Sequence[Found], source: AlignmentFile) -> None:
    """Raises AlignmentError for numbers of visemes that may be of Azure or of Oculus."""
    for found in used:
        numbers = [int(label) for label, *_ in found.entries if label.isdecimal()]
        if found.kind == "visemes" and numbers and max(numbers) <= OCULUS:
            told = f"has numbers of visemes up to {OCULUS}, which Azure and Oculus count differently"
            raise source.error(f"{told}; write the names of the visemes instead, such as PP")
