"""Languages: what an aligner's labels mean in the model's inventory. Nothing is dropped silently."""

from __future__ import annotations

import sys
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np

from phonanim.alignment import Alignment, Interval
from phonanim.errors import LabelError
from phonanim.inventory import INVENTORY, LEXICON
from phonanim.phones import PhoneTrack
from phonanim.readers import brief
from phonanim.segments import SILENT, Segment, filled, joined, to_track

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

FIRST_TRIED = ("english", "english_mfa", "spanish_mfa", "german")
"""`auto` takes the first language that knows every label, so the commonest stand first."""

Kind = Literal["phone", "closure", "silence", "noise"]
Unknown = Literal["error", "nearest", "silence"]
BRACKETS = "<>[]{}()*"
POSITIONS = ("_B", "_I", "_E", "_S")  # Kaldi marks where in the word a phone stands


@dataclass(frozen=True, slots=True)
class Sound:
    """What a label means: phone codes in order, sharing its time equally.

    A closure has one code for each release that may follow; the first is its own.
    """

    codes: tuple[int, ...]
    kind: Kind = "phone"


@dataclass(frozen=True)
class Language:
    """The labels of one language and aligner, as lexicon/languages/<name>.toml has them.

    `fold` says that case does not matter, `ignore` which characters carry nothing that is seen.
    """

    name: str
    title: str
    alphabet: str
    sounds: Mapping[str, Sound]
    ignore: str = ""
    fold: bool = False

    def resolve(self, label: str) -> Sound | None:
        """What a label means, None when the language does not know it."""
        for spelling in self._spellings(label):
            if spelling in self.sounds:
                return self.sounds[spelling]
        silences, label = _silences(), label.strip().lower()
        return silences.get(label) or silences.get(label.strip(BRACKETS))

    def nearest(self, label: str, n: int = 3) -> list[str]:
        """The known labels most like `label` in spelling, best first."""
        from difflib import get_close_matches

        return get_close_matches(label.lower() if self.fold else label, self.sounds, n, cutoff=0.0)

    def known(self, labels: Iterable[str]) -> float:
        """The share of labels that it knows as phones; 1 when there is nothing but silence."""
        found = [self.resolve(label) for label in labels]
        spoken = [sound for sound in found if sound is None or sound.kind in ("phone", "closure")]
        return 1.0 if not spoken else sum(sound is not None for sound in spoken) / len(spoken)

    def _spellings(self, label: str) -> Iterable[str]:
        """The label as written, then without what does not matter."""
        label = unicodedata.normalize("NFC", label.strip())
        label = label.lower() if self.fold else label
        yield label
        bare = label[:-2] if label.upper().endswith(POSITIONS) else label
        yield bare
        yield "".join(c for c in unicodedata.normalize("NFD", bare) if c not in self.ignore)


def to_phones(
    alignment: Alignment, language: str = "auto", unknown: Unknown = "error"
) -> tuple[PhoneTrack, tuple[str, ...]]:
    """The alignment in the model's inventory, and a note for every label that was not taken as written.

    Gaps are filled with silence, neighbouring silences become one, and a closure is joined to its
    release. `auto` chooses the language by the labels. Raises LabelError for a label that the language
    does not know, unless `unknown` says what to do instead.
    """
    chosen = _language_for(alignment, language)
    notes = _Notes(alignment)
    segments: list[Segment] = []
    for interval in alignment.intervals:
        sound = chosen.resolve(interval.label) or _replaced(interval, chosen, unknown, notes)
        if sound.kind == "noise":
            notes.add("sound that is no phone, shown as silence", interval)
        segments += _segments(interval, sound)
    if not any(segment.code != SILENT for segment in segments):
        notes.lines.append(f'no phone is spoken in tier "{brief(alignment.tier)}"')
    return to_track(joined(filled(segments, alignment.duration))), notes.all()


def language_names() -> tuple[str, ...]:
    """The languages there are."""
    return tuple(sorted(path.stem for path in (LEXICON / "languages").glob("*.toml")))


@cache
def load_language(name: str) -> Language:
    """The language of that name. Raises LabelError naming the nearest when there is none."""
    names = language_names()
    if name not in names:
        from difflib import get_close_matches

        near = ", ".join(get_close_matches(name.lower(), names, cutoff=0.0))
        raise LabelError(f'there is no language "{brief(name)}"; nearest: {near}, or auto')
    table = _toml(f"languages/{name}.toml")
    fold = bool(table.get("fold", False))
    return Language(
        name=name,
        title=table["title"],
        alphabet=table["alphabet"],
        sounds=_sounds(table["phones"], "phone", fold) | _sounds(table.get("closures", {}), "closure", fold),
        ignore=table.get("ignore", ""),
        fold=fold,
    )


def choose_language(labels: Iterable[str]) -> Language:
    """The first language that knows all labels, else the one that knows most of them."""
    counts = Counter(labels)
    best, best_share = load_language(FIRST_TRIED[0]), -1.0
    for name in dict.fromkeys((*FIRST_TRIED, *language_names())):
        language = load_language(name)
        share = language.known(counts.elements())
        if share == 1.0:
            return language
        if share > best_share:
            best, best_share = language, share
    return best


def recognized(labels: Iterable[str]) -> float:
    """The largest share of labels that any one language knows as phones; 0 when nothing is spoken."""
    spoken = [label for label in labels if not is_silent(label)]
    return choose_language(spoken).known(spoken) if spoken else 0.0


def is_silent(label: str) -> bool:
    """Whether a label says in every language that nobody speaks."""
    return label.strip().lower().strip(BRACKETS) in _silences()


_SILENT = Sound((SILENT,), "silence")


class _Notes:
    """What was not taken as written, one line for each label."""

    def __init__(self, alignment: Alignment) -> None:
        self.alignment = alignment
        self.lines: list[str] = []
        self._places: dict[tuple[str, str], list[float]] = {}

    def add(self, what: str, interval: Interval) -> None:
        place = interval.start + self.alignment.offset
        self._places.setdefault((interval.label, what), []).append(place)

    def all(self) -> tuple[str, ...]:
        times = f"times are counted from {self.alignment.offset:g} s, where the file starts"
        found = [
            f'"{brief(label)}" at {places[0]:.2f} s{f" and {len(places) - 1} more" * (len(places) > 1)}: {what}'
            for (label, what), places in self._places.items()
        ]
        return (*([times] if self.alignment.offset else []), *found, *self.lines)


def _language_for(alignment: Alignment, name: str) -> Language:
    if name != "auto":
        return load_language(name)
    return choose_language(interval.label for interval in alignment.intervals)


def _replaced(interval: Interval, language: Language, unknown: Unknown, notes: _Notes) -> Sound:
    """What stands for a label that the language lacks, if the caller consented to anything."""
    if unknown == "error":
        alignment = notes.alignment
        place = (
            f'{alignment.source}: tier "{brief(alignment.tier)}", {interval.start + alignment.offset:.3f} s'
        )
        near = ", ".join(language.nearest(interval.label))
        mend = "choose another --language, or --unknown nearest or silence"
        what = f'no phone "{brief(interval.label)}" in language {language.name} (nearest: {near})'
        raise LabelError(f"{place}: {what}; {mend}")
    if unknown == "silence":
        notes.add(f"unknown in language {language.name}, shown as silence", interval)
        return _SILENT
    near = language.nearest(interval.label, 1)[0]
    notes.add(f'unknown in language {language.name}, shown as "{near}"', interval)
    return language.sounds[near]


def _segments(interval: Interval, sound: Sound) -> list[Segment]:
    if sound.kind == "closure":
        return [Segment(sound.codes[0], interval.start, interval.end, interval.label, sound.codes)]
    bounds = np.linspace(interval.start, interval.end, len(sound.codes) + 1).tolist()
    return [
        Segment(code, start, end, interval.label)
        for code, start, end in zip(sound.codes, bounds, bounds[1:], strict=False)
    ]


@cache
def _silences() -> dict[str, Sound]:
    table = _toml("silences.toml")
    silent = (SILENT,)
    noises = {label: Sound(silent, "noise") for label in table["noise"]}
    return noises | {label: Sound(silent, "silence") for label in table["silent"]}


def _sounds(table: Mapping[str, str], kind: Kind, fold: bool) -> dict[str, Sound]:
    return {
        unicodedata.normalize("NFC", label.lower() if fold else label): Sound(
            tuple(INVENTORY.code(name) for name in names.split()), kind
        )
        for label, names in table.items()
    }


def _toml(name: str) -> dict[str, Any]:
    with (LEXICON / name).open("rb") as file:
        table: dict[str, Any] = tomllib.load(file)
    return table
