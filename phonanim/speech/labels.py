"""Labels: the inventory phones that the labels of each language and aligner stand for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache
from typing import Literal
from unicodedata import normalize

from phonanim.core.decode import read_toml
from phonanim.core.lexicon import LEXICON
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.segments import SILENT

Kind = Literal["phone", "closure", "silence", "noise"]
ALPHABETS = ("IPA", "SAMPA")
BRACKETS = "<>[]{}()*"
IPA = "ipa"
IPA_BLOCKS = (("\u0250", "\u02ff"), ("\ua700", "\ua71f"))
"""Unicode's IPA letters, marks of length, tone and articulation, and further marks of tone."""

POSITIONS = ("_B", "_I", "_E", "_S")  # Kaldi's marks for the position of a phone in its word


@dataclass(frozen=True, slots=True)
class Sound:
    """The meaning of a label: phone codes in order, which share its time equally.

    A closure has one code for each release that may follow; the first is the default. `alphabet` is the
    alphabet that a label was read in which is none of its language's own.
    """

    codes: tuple[int, ...]
    kind: Kind = "phone"
    alphabet: str = ""


SILENCE_SOUND = Sound((SILENT,), "silence")
NOISE_SOUND = Sound((SILENT,), "noise")


LONGEST = 200
"""Characters of a label. Text of any length costs no time, then."""

MARKS = (":", '"', "%", "~", "=", "_", "'", "_=", "_h", "_0", "`", "-")
"""Marks of SAMPA that may stand on a label that a language lists."""


@dataclass(frozen=True, eq=False)
class Language:
    """The labels of one language, from lexicon/languages/<name>.toml.

    `phones` maps labels to phones of the inventory, `ipa` maps labels to IPA, `closures` lists the releases
    that may follow. Labels in none of them are parsed in the `alphabets` (IPA, SAMPA); where `labels` are
    listed, a capital that is none of them is its small letter before it is SAMPA. `fold` makes labels
    case-insensitive, `ignore` lists characters without a visible effect. `labels` lists what aligners of the
    language write, by aligner. `in_ipa` maps letters that romanizations use for another sound to that of IPA,
    for alignments in IPA: see `for_labels`. `notation` is "ipa" in the language for those. `rounding` is how
    far lips are rounded, against English; in IPA without a language, where there are `front` rounded vowels.
    """

    name: str
    title: str
    code: str
    alphabets: tuple[str, ...] = ()
    phones: Mapping[str, str] = field(default_factory=dict)
    ipa: Mapping[str, str] = field(default_factory=dict)
    closures: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    in_ipa: Mapping[str, str] = field(default_factory=dict)
    ignore: str = ""
    fold: bool = False
    notation: str = ""
    rounding: float = 1.0
    front: str = ""

    @property
    def full_name(self) -> str:
        """The name by which `load_language` gives this language in its notation."""
        return f"{self.name}:{self.notation}" if self.notation else self.name

    def for_labels(self, labels: Iterable[str]) -> Language:
        """The language for an alignment with these labels: in IPA, some letters have the sound of IPA.

        Japanese j is an affricate in romanized labels, and a glide beside ɕ or ɯ.
        """
        return self.written_in_ipa() if any(map(_is_ipa, labels)) else self

    def rounding_of(self, labels: Iterable[str]) -> float:
        """How far lips are rounded in an alignment with these labels, against English."""
        return (
            self.rounding if not self.front or any(set(self.front) & set(label) for label in labels) else 1.0
        )

    def written_in_ipa(self) -> Language:
        """The language for alignments in IPA."""
        return self if not self.in_ipa or self.notation else in_notation_of_ipa(self)

    @lru_cache(maxsize=4096)  # noqa: B019 - the few languages live as long as the program
    def resolve(self, label: str) -> Sound | None:
        """The meaning of a label, None when it is unknown in this language, or longer than any label."""
        if len(label) > LONGEST:
            return None
        known = self.resolve_listed(label) or _silences().get(_bare(label)) or self._in_alphabets(label)
        return known or (None if label.isascii() else self._in_letters(label))

    @lru_cache(maxsize=4096)  # noqa: B019 - as above
    def resolve_listed(self, label: str) -> Sound | None:
        """The meaning of a label that the language itself lists, else None."""
        for spelling in self._spellings(label):
            if spelling in self.phones:
                return Sound(_codes(self.phones[spelling]))
            if spelling in self.ipa:
                return Sound(codes_of_ipa(self.ipa[spelling]))
            if spelling in self.closures:
                return Sound(_codes(self.closures[spelling]), "closure")
        return None

    @lru_cache(maxsize=4096)  # noqa: B019 - as above
    def nearest(self, label: str, n: int = 3) -> list[str]:
        """The known labels with the most similar spelling, best first."""
        from difflib import get_close_matches

        label = label[:LONGEST]
        known = [
            *self.phones,
            *self.ipa,
            *self.closures,
            *(x for group in self.labels.values() for x in group),
        ]
        return get_close_matches(label.lower() if self.fold else label, dict.fromkeys(known), n, cutoff=0.01)

    def _spellings(self, label: str) -> Iterator[str]:
        """The label as written, then without the parts that have no effect."""
        label = normalize("NFC", label.strip())
        label = label.lower() if self.fold else label
        yield label
        bare = label[:-2] if label.upper().endswith(POSITIONS) else label
        yield bare
        yield "".join(c for c in bare if c not in self.ignore)

    @cached_property
    def own_labels(self) -> frozenset[str]:
        """Every label that the language lists."""
        labels = (label for group in self.labels.values() for label in group)
        return frozenset((*self.phones, *self.ipa, *self.closures, *labels))

    def _in_alphabets(self, label: str) -> Sound | None:
        label = normalize("NFC", label.strip())
        if "IPA" in self.alphabets and (names := _read_ipa(label)):
            return _sound(names)
        if "SAMPA" not in self.alphabets or not (names := _read_sampa(label)):
            return None
        if not self.labels or self.alphabets == ("SAMPA",) or self._lists(label):
            return _sound(names)
        small = label.lower()
        if small != label and self._lists(small):
            return self.resolve_listed(small) or _sound(_read_ipa(small) or _read_sampa(small))
        return _sound(names, "X-SAMPA")

    def _in_letters(self, label: str) -> Sound | None:
        """The meaning of a label in the letters of a script."""
        from phonanim.speech.letters import spell_letters

        parts = spell_letters(normalize("NFC", label.strip()), self.name)
        sounds = [self.resolve_listed(part) or self._in_alphabets(part) for part in parts]
        if not sounds or not all(sounds):
            return None
        if len(sounds) == 1:
            return sounds[0]
        return Sound(tuple(code for sound in sounds if sound for code in sound.codes))

    def _lists(self, label: str) -> bool:
        """Whether a label is listed, or consists of listed ones and marks of SAMPA."""
        if label in self.own_labels:
            return True
        from phonanim.speech.sampa import split_sampa

        parts = split_sampa(label)
        return bool(parts) and all(part in self.own_labels or part in MARKS for part in parts)


def _sound(names: tuple[str, ...], alphabet: str = "") -> Sound:
    return Sound(tuple(map(INVENTORY.code, names)), alphabet=alphabet)


@cache
def in_notation_of_ipa(language: Language) -> Language:
    """The same language with the letters that stand for other sounds in IPA than in its romanization."""
    kept = {label: sound for label, sound in language.ipa.items() if label not in language.in_ipa}
    return replace(language, ipa=kept | dict(language.in_ipa), notation=IPA)


@lru_cache(maxsize=4096)
def _is_ipa(label: str) -> bool:
    """Whether a label has a letter or mark that only IPA has."""
    return any(
        first <= letter <= last for letter in normalize("NFC", label[:LONGEST]) for first, last in IPA_BLOCKS
    )


@lru_cache(maxsize=4096)
def is_silent(label: str) -> bool:
    """Whether a label means silence in every language."""
    return _bare(label) in _silences()


@cache
def _silences() -> dict[str, Sound]:
    table = read_toml(LEXICON / "silences.toml")
    return dict.fromkeys(table["noise"], NOISE_SOUND) | dict.fromkeys(table["silent"], SILENCE_SOUND)


def _bare(label: str) -> str:
    """The label as silences.toml lists it: lower case, without brackets and word position."""
    label = label.strip().lower()
    if label.upper().endswith(POSITIONS) and label[:-2] in _silences():
        return label[:-2]
    return label if label in _silences() else label.strip(BRACKETS) or label


def _codes(names: str) -> tuple[int, ...]:
    return tuple(map(INVENTORY.code, names.split()))


def codes_of_ipa(sounds: str) -> tuple[int, ...]:
    """Codes of IPA sounds that are separated by spaces. Raises ValueError when one is not IPA."""
    names = [_read_ipa(sound) for sound in sounds.split()]
    if not all(names):
        raise ValueError(f"not IPA: {sounds}")
    return tuple(INVENTORY.code(name) for group in names for name in group)


def _read_ipa(label: str) -> tuple[str, ...]:
    from phonanim.speech.visible_phones import to_visible_phones

    return to_visible_phones(label)


def _read_sampa(label: str) -> tuple[str, ...]:
    from phonanim.speech.sampa import to_ipa

    return _read_ipa(to_ipa(label))
