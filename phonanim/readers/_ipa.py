"""Strings of IPA without spaces, as speech synthesizers write the sounds of a word."""

from __future__ import annotations

import unicodedata

STRESS = "ˈˌ'"
TIES = "\u0361\u035c"

# What Misaki, the phonemizer of Kokoro and HeadTTS, writes in one letter.
MISAKI = {
    **{"A": "eɪ", "I": "aɪ", "O": "oʊ", "Q": "əʊ", "W": "aʊ", "Y": "ɔɪ", "T": "ɾ", "ᵊ": "ə", "ᵻ": "ɪ"},
    **{"ʤ": "dʒ", "ʧ": "tʃ"},
}


def split_sounds(text: str) -> list[str]:
    """The sounds of a string of IPA: each letter with its marks; stress and punctuation are left out."""
    sounds: list[str] = []
    tied = False
    for character in unicodedata.normalize("NFC", text):
        kind = unicodedata.category(character)
        if character in MISAKI:
            sounds.append(MISAKI[character])
        elif kind in ("Mn", "Lm", "Sk") or character == ":":
            tied = character in TIES
            if sounds and character not in STRESS:
                sounds[-1] += character
            continue
        elif kind.startswith("L") and tied:
            sounds[-1] += character
        elif kind.startswith("L"):
            sounds.append(character)
        tied = False
    return sounds
