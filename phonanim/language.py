"""Languages: what an aligner's labels mean in the model's inventory. Nothing is dropped silently."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import Any, Literal
from unicodedata import normalize

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

FIRST_TRIED = ("english", "ipa", "sampa", "mandarin", "japanese")
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


@dataclass(frozen=True, eq=False)
class Language:
    """The labels of one language, as lexicon/languages/<name>.toml has them.

    `phones` gives labels as phones of the inventory, `ipa` as IPA, `closures` the releases that may
    follow; labels in none of them are read in the `alphabets` (IPA, SAMPA). `fold` says that case does
    not matter, `ignore` which characters carry nothing that is seen. `labels` lists what aligners of
    the language write, by aligner.
    """

    name: str
    title: str
    code: str
    alphabets: tuple[str, ...] = ()
    phones: Mapping[str, str] = field(default_factory=dict)
    ipa: Mapping[str, str] = field(default_factory=dict)
    closures: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    ignore: str = ""
    fold: bool = False

    @lru_cache(maxsize=4096)  # noqa: B019 - the few languages live as long as the program
    def resolve(self, label: str) -> Sound | None:
        """What a label means, None when the language does not know it."""
        return self.listed(label) or _silences().get(_bare(label)) or self._in_alphabets(label)

    def listed(self, label: str) -> Sound | None:
        """What a label means that the language itself lists."""
        for spelling in self._spellings(label):
            if spelling in self.phones:
                return Sound(_codes(self.phones[spelling]))
            if spelling in self.ipa:
                return Sound(_codes_of_ipa(self.ipa[spelling]))
            if spelling in self.closures:
                return Sound(_codes(self.closures[spelling]), "closure")
        return None

    def nearest(self, label: str, n: int = 3) -> list[str]:
        """The known labels most like `label` in spelling, best first."""
        from difflib import get_close_matches

        known = [
            *self.phones,
            *self.ipa,
            *self.closures,
            *(x for group in self.labels.values() for x in group),
        ]
        return get_close_matches(label.lower() if self.fold else label, dict.fromkeys(known), n, cutoff=0.01)

    def _spellings(self, label: str) -> Iterator[str]:
        """The label as written, then without what does not matter."""
        label = normalize("NFC", label.strip())
        label = label.lower() if self.fold else label
        yield label
        bare = label[:-2] if label.upper().endswith(POSITIONS) else label
        yield bare
        yield "".join(c for c in bare if c not in self.ignore)

    def _in_alphabets(self, label: str) -> Sound | None:
        found = (_READ[alphabet](label) for alphabet in self.alphabets)
        names = next(filter(None, found), ())
        return Sound(tuple(map(INVENTORY.code, names))) if names else None


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
    """The language of a name, a code ("de", "de-AT") or a model ("german_mfa").

    Raises LabelError naming the nearest when there is none.
    """
    for stem in (name, name.lower(), *re.split("[_-]", name.lower())[:1]):
        if stem in language_names():
            return _read_language(stem)
        for candidate in language_names() if len(stem) == 2 else ():
            if _read_language(candidate).code == stem:
                return _read_language(candidate)
    from difflib import get_close_matches

    near = ", ".join(get_close_matches(name.lower(), language_names(), cutoff=0.0))
    raise LabelError(f'there is no language "{brief(name)}"; nearest: {near}, or auto')


def choose_language(labels: Iterable[str]) -> Language:
    """The first language that lists all labels or whose alphabet has them, else the one that has most.

    A language with a list of its own is judged by that list: else every IPA label would be English.
    """
    counts = Counter(label for label in labels if not is_silent(label))
    best, best_share = load_language(FIRST_TRIED[0]), -1.0
    for name in dict.fromkeys((*FIRST_TRIED, *language_names())):
        language = load_language(name)
        share = _share(language, counts)
        if share == 1.0:
            return language
        if share > best_share:
            best, best_share = language, share
    return best


def recognized(labels: Iterable[str]) -> float:
    """The largest share of labels that any one language knows as phones; 0 when nothing is spoken."""
    spoken = Counter(label for label in labels if not is_silent(label))
    return _share(choose_language(spoken.elements()), spoken) if spoken else 0.0


def is_silent(label: str) -> bool:
    """Whether a label says in every language that nobody speaks."""
    return _bare(label) in _silences()


def _share(language: Language, counts: Counter[str]) -> float:
    own = language.listed if language.phones or language.ipa else language.resolve
    known = sum(count for label, count in counts.items() if own(label))
    return known / counts.total() if counts else 1.0


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
        shifted = f"times are counted from {self.alignment.offset:g} s, where the file starts"
        found = [
            f'"{brief(label)}" at {_places(times)}: {what}' for (label, what), times in self._places.items()
        ]
        return (*([shifted] if self.alignment.offset else []), *found, *self.lines)


def _places(times: list[float]) -> str:
    more = f" and {len(times) - 1} more" if len(times) > 1 else ""
    return f"{times[0]:.2f} s{more}"


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
        near = ", ".join(language.nearest(interval.label)) or "none"
        mend = "choose another --language, or --unknown nearest or silence"
        what = f'no phone "{brief(interval.label)}" in language {language.name} (nearest: {near})'
        raise LabelError(f"{place}: {what}; {mend}")
    if unknown == "silence":
        notes.add(f"unknown in language {language.name}, shown as silence", interval)
        return _SILENT
    near = next(iter(language.nearest(interval.label, 1)), "")
    shown = f'"{near}"' if near else "silence: no label is like it"
    notes.add(f"unknown in language {language.name}, shown as {shown}", interval)
    return language.resolve(near) or _SILENT


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
    noises = {label: Sound((SILENT,), "noise") for label in table["noise"]}
    return noises | dict.fromkeys(table["silent"], _SILENT)


def _bare(label: str) -> str:
    """The label in lower case without brackets, unless it is itself known or nothing but a bracket."""
    label = label.strip().lower()
    return label if label in _silences() else label.strip(BRACKETS) or label


@cache
def _read_language(name: str) -> Language:
    table = _toml(f"languages/{name}.toml")
    fold = bool(table.get("fold", False))

    def entries(key: str) -> dict[str, str]:
        pairs = table.get(key, {}).items()
        return {normalize("NFC", label.lower() if fold else label): text for label, text in pairs}

    return Language(
        name=name,
        title=table["title"],
        code=table["code"],
        alphabets=tuple(table.get("alphabets", ())),
        phones=entries("phones"),
        ipa=entries("ipa"),
        closures=entries("closures"),
        labels={aligner: tuple(text.split()) for aligner, text in table.get("labels", {}).items()},
        ignore=table.get("ignore", ""),
        fold=fold,
    )


def _codes(names: str) -> tuple[int, ...]:
    return tuple(map(INVENTORY.code, names.split()))


def _codes_of_ipa(sounds: str) -> tuple[int, ...]:
    """Codes of IPA sounds with spaces between them. Raises ValueError where one is not IPA."""
    names = [_read_ipa(sound) for sound in sounds.split()]
    if not all(names):
        raise ValueError(f"not IPA: {sounds}")
    return tuple(INVENTORY.code(name) for group in names for name in group)


def _read_ipa(label: str) -> tuple[str, ...]:
    from phonanim.looks import seen

    return seen(label)


def _read_sampa(label: str) -> tuple[str, ...]:
    from phonanim.sampa import to_ipa

    return _read_ipa(to_ipa(label))


_READ = {"IPA": _read_ipa, "SAMPA": _read_sampa}


def _toml(name: str) -> dict[str, Any]:
    with (LEXICON / name).open("rb") as file:
        table: dict[str, Any] = tomllib.load(file)
    return table
