"""Visemes of synthesizers and avatars, as the phones that each of them stands for."""

from __future__ import annotations

from collections.abc import Iterable

from phonanim.speech.alignment import Interval

NOTE = "mouth shapes are used as phones, because the file does not contain the sounds"

# https://learn.microsoft.com/azure/ai-services/speech-service/how-to-speech-synthesis-viseme
AZURE = (
    *(
        "sil",
        "ah",
        "aa",
        "ao",
        "eh",
        "er",
        "iy",
        "uw",
        "ow",
        "aw",
        "oy",
        "ay",
        "hh",
        "r",
        "l",
        "s",
        "sh",
        "th",
    ),
    *("f", "t", "k", "p"),
)

# https://docs.aws.amazon.com/polly/latest/dg/ref-phoneme-tables-shell.html
POLLY = {
    **{
        "p": "p",
        "t": "t",
        "S": "sh",
        "T": "th",
        "f": "f",
        "k": "k",
        "i": "iy",
        "r": "r",
        "s": "s",
        "u": "uw",
    },
    **{"@": "ah", "a": "aa", "e": "ey", "E": "eh", "o": "ow", "O": "ao", "sil": "sil", "J": "n", "B": "p"},
}

# The visemes of Oculus, with the spellings of TalkingHead and Ready Player Me.
OCULUS = {
    **{
        "sil": "sil",
        "pp": "p",
        "ff": "f",
        "th": "th",
        "dd": "d",
        "kk": "k",
        "ch": "ch",
        "ss": "s",
        "nn": "n",
    },
    **{"rr": "r", "aa": "aa", "e": "eh", "i": "ih", "ih": "ih", "o": "ao", "oh": "ao", "u": "uw", "ou": "uw"},
}


def oculus_phone(name: str) -> str:
    """The phone of a viseme of Oculus; a name that is none stays as it is."""
    bare = name.lower().removeprefix("viseme_")
    return OCULUS.get(bare, name)


def merge_repeats(shapes: Iterable[Interval]) -> tuple[Interval, ...]:
    """Visemes without the entries that repeat the one before them or last no time."""
    merged: list[Interval] = []
    for shape in shapes:
        if merged and merged[-1].label == shape.label and merged[-1].end == shape.start:
            merged[-1] = Interval(shape.label, merged[-1].start, shape.end)
        elif shape.end != shape.start:
            merged.append(shape)
    return tuple(merged)
