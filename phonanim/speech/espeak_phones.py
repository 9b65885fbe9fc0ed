"""Pronunciations by the rules of eSpeak NG: words, numbers and abbreviations of its languages, in IPA."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache, lru_cache

from phonanim.core.lexicon import LEXICON
from phonanim.media.espeak import ask_espeak
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import find_language
from phonanim.speech.spoken_text import espeak_voice, readable_word

IPA = "IPA"
STRESS = "ˈˌ"
_TONE = re.compile(r"(?<=.)[0-9ɜ]$")  # its names of tones; the third is written ɜ
_SWITCH = re.compile(r"\([a-z-]+\)")  # "(en)": the word is spoken as one of another language


def reading_language(voice: str) -> str:
    """The language that the phones of a voice are read as: that of the voice, or IPA where there is none."""
    stem = find_language(voice)
    if stem is None or IPA not in load_language(stem).alphabets:
        return "ipa"
    return load_language(stem).written_in_ipa().full_name


def plain_ipa(label: str) -> str:
    """A phone of eSpeak NG in IPA, "" for the mark of a change of language, such as `(en)`.

    Some of its sounds have names of its own (lexicon/espeak_labels.tsv), and `-` or `"` after a phone
    distinguishes variants of it.
    """
    if label.startswith("(") and label.endswith(")"):
        return ""
    bare = label.lstrip(STRESS)
    stress = label[: len(label) - len(bare)]
    bare = bare.rstrip('-"')
    return stress + _own_labels().get(bare, bare)


def pronounce_words(words: Iterable[str], voice: str) -> dict[str, tuple[str, ...]]:
    """The phones of each word in IPA, () for one with nothing to say or in letters that are not read.

    Raises OptionError for a voice that eSpeak NG does not have, MissingExtraError without the extra.
    """
    return dict(_pronounced(tuple(dict.fromkeys(words)), voice))


@lru_cache(maxsize=64)
def _pronounced(words: tuple[str, ...], voice: str) -> tuple[tuple[str, tuple[str, ...]], ...]:
    readable = [readable_word(word, voice) for word in words]
    answer = ask_espeak({"words": readable, "voice": espeak_voice(voice)})
    spelled = zip(words, readable, answer["phonemes"], strict=True)
    return tuple((word, _phones(text, voice) if given else ()) for word, given, text in spelled)


def _phones(text: str, voice: str) -> tuple[str, ...]:
    """The phones of a text in which they are parted by underscores, words by blanks."""
    parts = [part for part in re.split(r"[_\s]+", _SWITCH.sub(" ", text)) if part]
    if find_language(voice) in ("mandarin", "cantonese"):
        parts = [_TONE.sub("", part) for part in parts]
    return tuple(label for part in parts for label in plain_ipa(part).split())


@cache
def _own_labels() -> dict[str, str]:
    rows = (LEXICON / "espeak_labels.tsv").read_text("utf-8").splitlines()[1:]
    return {label: ipa for label, ipa, *_ in (row.split("\t") for row in rows)}
