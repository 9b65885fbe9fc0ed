"""Phoneme times of the synthesizers Piper and piper-plus, as JSON: seconds, milliseconds, or samples."""

from __future__ import annotations

from typing import Any

from phonanim.readers._words import first_value
from phonanim.speech.alignment import Interval, Recording, Tier
from phonanim.speech.alignment_file import DAMAGE, AlignmentFile

FORMAT = "phoneme times of Piper (JSON)"
RATE = 22_050.0
"""Samples per second of most voices; used where the file gives samples and no rate."""

LABEL = ("phoneme", "symbol", "ipa")
UNITS = {"start": 1.0, "start_ms": 1e-3, "start_time": 1.0}
ENDS = {"start": "end", "start_ms": "end_ms", "start_time": "end_time"}
RATES = ("sample_rate", "sampleRate")
BOUNDS = ("^", "$", "_", "<pad>")


def recognizes(source: AlignmentFile) -> bool:
    """Whether it is JSON with phonemes that have times or numbers of samples."""
    return bool(_timed(source.json)) or any(_sampled(one)[0] for one in source.json_lines)


def read(source: AlignmentFile) -> Recording:
    """The phonemes; the marks of beginning, end and padding are silence."""
    notes: tuple[str, ...] = ()
    try:
        if items := _timed(source.json):
            name = next(name for name in UNITS if name in items[0])
            unit = UNITS[name]
            phones = [_interval(item, name, unit) for item in items]
        else:
            phones, unit, notes = _from_samples(source.json_lines)
        end = max(one.end for one in phones)
    except DAMAGE as error:
        raise source.error(f"has a damaged phoneme ({error!r}); synthesize it again") from error
    spoken = [Interval("" if one.label in BOUNDS else one.label, one.start, one.end) for one in phones]
    return Recording((Tier("phones", tuple(spoken)),), 0.0, end, notes, unit=unit)


def _timed(content: Any) -> list[dict[str, Any]]:
    """The phonemes of a file that have times of their own."""
    items = content
    if isinstance(content, dict):
        items = first_value(content, ("phonemes", "timings", "phoneme_timings", "alignments"))
    if not isinstance(items, list) or not items:
        return []
    fine = all(isinstance(item, dict) and first_value(item, LABEL) is not None for item in items)
    return items if fine and any(name in items[0] for name in UNITS) else []


def _interval(item: dict[str, Any], name: str, unit: float) -> Interval:
    label = str(first_value(item, LABEL)).strip()
    return Interval(label, float(item[name]) * unit, float(item[ENDS[name]]) * unit)


def _sampled(content: Any) -> tuple[list[Any], list[Any]]:
    """The phonemes and numbers of samples of a value that has these, in two lists or in pairs."""
    pairs = content
    if isinstance(content, dict):
        pairs = first_value(content, ("phoneme_alignments", "alignments"))
    if isinstance(pairs, list) and all(isinstance(pair, dict) and "num_samples" in pair for pair in pairs):
        return [pair.get("phoneme") for pair in pairs], [pair["num_samples"] for pair in pairs]
    if not isinstance(content, dict):
        return [], []
    phonemes, counts = content.get("phonemes"), content.get("phoneme_id_samples")
    fine = isinstance(phonemes, list) and isinstance(counts, list) and len(phonemes) == len(counts)
    return (list(phonemes or ()), list(counts or ())) if fine else ([], [])


def _from_samples(pieces: list[Any]) -> tuple[list[Interval], float, tuple[str, ...]]:
    """The phonemes of the pieces of speech, one after the other."""
    told = next(filter(None, (first_value(one, RATES) for one in pieces if isinstance(one, dict))), None)
    rate = RATE if told is None else float(told)
    notes = () if told is not None else (f"the file has no sample rate; {RATE:g} per second assumed",)
    phones, time = [], 0.0
    for piece in pieces:
        for phoneme, count in zip(*_sampled(piece), strict=True):
            last = time + float(count) / rate
            phones.append(Interval(str(phoneme).strip(), time, last))
            time = last
    return phones, 1 / rate, notes
