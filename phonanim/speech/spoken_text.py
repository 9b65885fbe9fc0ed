"""A text as a voice should say it: without marks, directions, names of speakers and emoji."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

from phonanim.core.lexicon import LEXICON
from phonanim.errors import OptionError
from phonanim.speech.kana import can_read, read_japanese
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import find_language
from phonanim.speech.numbers import spell_number
from phonanim.speech.written_forms import in_english_words

MOST_SHOWN = 3
UNVOWELLED = ("ar", "fa", "ur", "he", "sd", "ug")
"""Voices of languages whose writing leaves vowels out."""

ROUGH = ("th",)
"""Voices that read their own script wrongly: eSpeak NG names letters and marks instead."""

_TAG = re.compile(r"</?[A-Za-z!][^<>]{0,200}>|\{\\[^{}]{0,200}\}")
_WHOLE_TAG = re.compile(r"<[^<>]*(?:>|$)|^[^<>]*>")
_BRACKETS = re.compile(r"\[[^\[\]\n]{0,80}\]|[♪♫♬]+")
_ASIDE = re.compile(r"\(([^()\n]{1,60})\)|\*([^*\n]{1,60})\*")
_MARKUP = re.compile(r"[*_~`#]{1,3}(?=\w)|(?<=[\w.,!?])[*_~`]{1,3}(?!\w)")
_EMOJI = re.compile(
    "[\U0001f000-\U0001faff\u2600-\u27bf\u2b00-\u2bff\ufe0f\u20e3\U000e0020-\U000e007f]+"
    "(?:\u200d[\U0001f000-\U0001faff\u2600-\u27bf\ufe0f]+)*"
)
_STUTTER = re.compile(r"\b([bcdfghjklmnpqrstvwyz]|th|sh|ch|wh)-(?=\1)", re.IGNORECASE)
_AMOUNT = re.compile(r"\b\d{1,3}(?:,\d{3})+(?:\.\d+)?\b")
_DATE = re.compile(r"\b(\d{1,2})/(\d{1,2})/(\d{2,4})\b")
_TIMES = re.compile(r"^(?:\d+[ \t]*\n)?[ \t]*[\d:.,]+[ \t]*-->.*$|^WEBVTT.*$", re.MULTILINE)
_SPEAKER = re.compile(
    r"^[ \t]*(?:>>[ \t]*)?(\w[\w .'\u2019-]{0,30}?)([ \t]*\([^()\n]{1,60}\))?[ \t]*[:\uff1a](?!\d)",
    re.MULTILINE,
)
_NIQQUD = re.compile("[\u0591-\u05bd\u05bf-\u05c7]")


@dataclass(frozen=True, slots=True)
class SpokenForm:
    """What a voice is given. `written` has words of it as the text writes them, where it is another way."""

    text: str
    is_ssml: bool = False
    notes: tuple[str, ...] = ()
    written: dict[str, str] = field(default_factory=dict)


def prepare_text(text: str, voice: str) -> SpokenForm:
    """A text as a voice should say it. Raises OptionError for letters that the voice cannot read."""
    text = unicodedata.normalize(
        "NFC", text
    )  # signs that are composed of two are spelled one after the other
    code = voice_code(voice)
    if "<speak" in text:
        _check_letters(_TAG.sub(" ", text), voice, code)
        return SpokenForm(text, is_ssml=True, notes=_doubts(text, code))
    plain, notes = plain_text(text, voice)
    if code.startswith("he"):
        plain = _NIQQUD.sub("", plain)
    written: dict[str, str] = {}
    if code == "ja" and can_read(plain):
        plain, written = read_japanese(plain)
    _check_letters(plain, voice, code)
    plain, sounds = _with_interjections(plain, code)
    return SpokenForm(plain, notes=(*notes, *_doubts(plain, code)), written=written | sounds)


def plain_text(text: str, voice: str) -> tuple[str, tuple[str, ...]]:
    """What is spoken of a text, and notes on what is not: marks, directions, names of speakers.

    In English, amounts, dates and signs become words. Raises OptionError for a text without words, and for
    letters that an English voice cannot read.
    """
    code = voice_code(voice)
    plain, notes = _without_marks(unicodedata.normalize("NFC", text))
    if not any(sign.isalnum() for sign in plain):
        told = f" ({'; '.join(notes)})" if notes else ""
        raise OptionError(f"the text has no words{told}; give the words that are spoken")
    if code.startswith("en"):
        plain = _in_english_words(plain)
        _check_letters(plain, voice, code)
    return plain, notes


def voice_code(voice: str) -> str:
    """The code of a voice: "de" of de+f2 and of german. A voice that is no language is its own code."""
    name = voice.partition("+")[0].strip().lower()
    if re.fullmatch(r"[a-z]{2,3}(?:-.*)?", name):
        return name
    stem = find_language(name)
    return (load_language(stem).code if stem else "") or name


def espeak_voice(voice: str) -> str:
    """A voice by its code where it is named as a language that eSpeak NG may call otherwise: mandarin."""
    name, plus, variant = voice.partition("+")
    code = voice_code(name)
    return voice if code.startswith("en") else f"{code}{plus}{variant}"


def readable_word(word: str, voice: str) -> str:
    """A word in letters that a voice reads, "" where it reads some of them wrongly."""
    code = voice_code(voice)
    plain = read_japanese(word)[0] if code == "ja" and can_read(word) else word
    try:
        _check_letters(plain, voice, code)
    except OptionError:
        return ""
    return plain


def _without_marks(text: str) -> tuple[str, tuple[str, ...]]:
    """The text without what is not spoken, and a note for each kind of it."""
    kinds: dict[str, list[str]] = {}

    def drop(kind: str) -> Callable[[re.Match[str]], str]:
        def drop_one(match: re.Match[str]) -> str:
            kinds.setdefault(kind, []).append(" ".join(match[0].split()))
            return " "

        return drop_one

    def aside(match: re.Match[str]) -> str:
        words = re.findall(r"\w+", (match[1] or match[2]).lower())
        if words and any(word in _directions() for word in words):
            kinds.setdefault("directions, not spoken", []).append(match[0])
            return " "
        return match[0]

    text = _TIMES.sub(drop("times, not spoken"), text)
    text = _TAG.sub(drop("marks, not spoken"), text)
    names, dropped = _speakers(text), drop("speakers, not spoken")
    text = _SPEAKER.sub(lambda match: dropped(match) if match[1] in names else match[0], text)
    text = _BRACKETS.sub(drop("directions, not spoken"), text)
    text = _ASIDE.sub(aside, text)
    text = _EMOJI.sub(drop("signs, not spoken"), text)
    notes = []
    for kind, found in kinds.items():
        more = f" and {len(found) - MOST_SHOWN} more" if len(found) > MOST_SHOWN else ""
        notes.append(f"{kind}: {' '.join(found[:MOST_SHOWN])}{more}")
    return _MARKUP.sub("", text), tuple(notes)


def _speakers(text: str) -> set[str]:
    """Names before a colon: in capitals, with a direction, or at the begin of all of several lines."""
    found = list(_SPEAKER.finditer(text))
    sure = {match[1] for match in found if match[2] or (match[1].isupper() and len(match[1]) > 1)}
    lines = sum(bool(line.strip()) for line in text.splitlines())
    return sure | ({match[1] for match in found} if 1 < len(found) == lines else set())


def plain_label(form: SpokenForm, word: str) -> str:
    """A word that was said as the text writes it, without tags."""
    return form.written.get(word, _WHOLE_TAG.sub(" ", word).strip() if form.is_ssml else word)


def _in_english_words(text: str) -> str:
    """Large numbers, dates, written forms and stuttered letters as English voices should read them."""

    def amount(match: re.Match[str]) -> str:
        return " ".join(spell_number(match[0])) or match[0]

    text = in_english_words(text)
    text = _DATE.sub(r"\1 \2 \3", text)
    text = re.sub(r"(?<=\d)\s*[*×]\s*(?=\d)", " times ", text)
    text = re.sub(r"(?<=\d)\s*%", " percent", re.sub(r"(?<=\s)&(?=\s)", "and", text))
    text = _AMOUNT.sub(amount, text)
    return _STUTTER.sub(lambda match: f"{match[1]}uh ", text)


def _with_interjections(text: str, code: str) -> tuple[str, dict[str, str]]:
    """Sounds such as "shh" as phonemes of eSpeak NG in double brackets, and how the text writes them.

    Other scripts, and languages in which such letters may be a word, keep them.
    """
    if not code.startswith("en"):
        return text, {}
    written: dict[str, str] = {}

    def sound(match: re.Match[str]) -> str:
        for pattern, phonemes in _interjections():
            if re.fullmatch(pattern, match[0].lower()):
                written[phonemes.strip(":")] = match[0]
                return f"[[{phonemes}]]"
        return match[0]

    return re.sub(r"\b[bfghmprstzBFGHMPRSTZ]{2,12}\b", sound, text), written


def _check_letters(text: str, voice: str, code: str) -> None:
    """Raises OptionError for words in a script that the voice would name letter by letter."""
    family = code.partition("-")[0]
    for word in re.findall(r"[^\W\d_]+", text):
        for script, voices in _scripts().items():
            letters = [letter for letter in word if unicodedata.name(letter, "").startswith(script)]
            if not letters or family in voices or (len(letters) < 2 and script != "CJK"):
                continue
            told = f"the voice {voice} cannot read {word[:40]}"
            if script == "CJK" and family == "ja":
                raise OptionError(f"{told}; pip install 'phonanim[ja]' reads kanji, or write it in kana")
            others = "ja" if script == "CJK" else ""
            named = " or ".join(filter(None, (voices[0], others)))
            raise OptionError(f"{told}; name its language, such as --voice {named}, or write it otherwise")


def _doubts(text: str, code: str) -> tuple[str, ...]:
    """Notes on what a voice does not know of a language."""
    family = code.partition("-")[0]
    if family in ROUGH and any(unicodedata.name(letter, "").startswith("THAI") for letter in text):
        return ("eSpeak NG reads Thai letters wrongly: most sounds are not those of the text; give phones",)
    marks = sum("\u064b" <= letter <= "\u0652" for letter in text)
    letters = sum(letter.isalpha() for letter in text)
    if family in UNVOWELLED and 4 * marks < letters:
        return ("vowels that the text does not write are guessed, and some are missing",)
    return ()


@cache
def _directions() -> frozenset[str]:
    lines = (LEXICON / "directions.txt").read_text("utf-8").splitlines()
    return frozenset(word for line in lines if not line.startswith("#") for word in line.split())


@cache
def _interjections() -> tuple[tuple[str, str], ...]:
    rows = (LEXICON / "interjections.tsv").read_text("utf-8").splitlines()[1:]
    return tuple((row.split("\t")[0], row.split("\t")[1]) for row in rows)


@cache
def _scripts() -> dict[str, tuple[str, ...]]:
    """The voices that read each script."""
    rows = (LEXICON / "voice_scripts.tsv").read_text("utf-8").splitlines()[1:]
    return {script: tuple(voices.split()) for script, voices in (row.split("\t") for row in rows)}
