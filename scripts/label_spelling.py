"""Words of East Asian languages as the labels of aligners, by the packages of each language."""

from __future__ import annotations

import re
from functools import cache
from itertools import chain
from typing import Any

from phonanim.speech.letters import spell_hangul

CONSONANTS = "ㄱㄲㄴㄷㄸㄹㅁㅂㅃㅅㅆㅇㅈㅉㅊㅋㅌㅍㅎ"
VOWELS = "ㅏㅐㅑㅒㅓㅔㅕㅖㅗㅘㅙㅚㅛㅜㅝㅞㅟㅠㅡㅢㅣ"
ROMANIZED = """
g kk n d tt r m b pp s ss ng j jj ch k t p h
a ae ya yae eo e yeo ye o wa wae oe yo u wo we wi yu eu ui i
"""
KOREAN = dict(zip(CONSONANTS + VOWELS, ROMANIZED.split(), strict=True))
"""The Revised Romanization of the letters of Hangul."""


def pinyin(word: str, apical: bool) -> list[str]:
    """Initials and finals with tones; `apical` writes the vowels of "si" and "shi" as ii and iii."""
    from pypinyin import Style, lazy_pinyin

    starts = lazy_pinyin(word, Style.INITIALS, strict=False, errors="ignore")
    ends = lazy_pinyin(word, Style.FINALS_TONE3, strict=False, neutral_tone_with_five=True, errors="ignore")
    if apical:
        kinds = {"z": "ii", "c": "ii", "s": "ii", "zh": "iii", "ch": "iii", "sh": "iii", "r": "iii"}
        ends = [
            kinds[start] + end[1:] if start in kinds and end[:1] == "i" and not end[1:2].isalpha() else end
            for start, end in zip(starts, ends, strict=False)
        ]
    return [label for label in chain.from_iterable(zip(starts, ends, strict=False)) if label]


def jyutping(word: str) -> list[str]:
    """Initials and finals with tones."""
    import ToJyutping

    found: list[str] = []
    for _, syllable in ToJyutping.get_jyutping_list(word):
        parts = re.fullmatch(r"(ng|gw|kw|[bpmfdtnlgkhwzcsj])?([a-z]+)(\d)", syllable or "")
        if parts:
            found += [part for part in (parts[1], parts[2] + parts[3]) if part]
        elif syllable:
            found.append(syllable)
    return found


@cache
def japanese_tagger() -> Any:
    import fugashi

    return fugashi.Tagger()


@cache
def kana(text: str) -> str:
    """The pronunciation of Japanese text in katakana."""
    words = [
        getattr(word.feature, "pron", None) or word.feature.kana or "" for word in japanese_tagger()(text)
    ]
    return "".join(words) or text


def julius(word: str) -> list[str]:
    """The labels of Julius."""
    import jaconv

    spelled: str = jaconv.hiragana2julius(jaconv.kata2hira(kana(word)))
    return [label for label in spelled.split() if re.fullmatch(r"[a-zN]+:?", label)]


def openjtalk(word: str) -> list[str]:
    """The labels of OpenJTalk: cl, long vowels twice, devoiced I and U between voiceless consonants."""
    labels = list(chain.from_iterable([x[0], x[0]] if x.endswith(":") else [x] for x in julius(word)))
    labels = ["cl" if label == "q" else label for label in labels]
    voiceless = {"k", "ky", "s", "sh", "t", "ch", "ts", "h", "hy", "f", "p", "py", "cl"}
    for n, label in enumerate(labels[1:-1], 1):
        if label in "iu" and labels[n - 1] in voiceless and labels[n + 1] in voiceless:
            labels[n] = label.upper()
    return labels


def jamo(word: str) -> list[str]:
    """The letters of Hangul, without the silent initial."""
    return list(spell_hangul(word))


def korean_romanized(word: str) -> list[str]:
    """The letters of Hangul in the Revised Romanization."""
    return [KOREAN[letter] for letter in jamo(word)]
