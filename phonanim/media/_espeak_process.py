"""The process that speaks: a request as JSON on its input, samples and events, or phonemes, on its output.

eSpeak NG keeps the state of its noise and pitch from one text to the next, so that only the first text of a
process always gives the same samples. It speaks one text and ends.
"""

from __future__ import annotations

import base64
import ctypes
import json
import sys
from difflib import get_close_matches
from typing import Any

# Numbers of speak_lib.h.
SYNCHRONOUS, PHONEME_EVENTS, IPA, DO_NOT_EXIT = 2, 1, 2, 0x8000
LAST = 0
CHARACTERS, UTF8, SSML, PHONEMES = 1, 1, 0x10, 0x100
SPEED = 1
DEFAULT = "en-us"  # the voice of "english", which many voices are named


class _EventId(ctypes.Union):
    _fields_ = [("number", ctypes.c_int), ("name", ctypes.c_char_p), ("string", ctypes.c_char * 8)]


class _Event(ctypes.Structure):
    _fields_ = [
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", _EventId),
    ]


class _Voice(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("languages", ctypes.c_void_p), ("identifier", ctypes.c_char_p)]


_Callback = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(_Event)
)


def speak(
    text: str, voice: str, words_per_minute: int | None = None, is_ssml: bool = False
) -> dict[str, Any]:
    """The rate, the samples (16 bit, base64) and the events of a text, or an error.

    An event is its type, its sample, its position and length in the text, and the phone.
    """
    library, rate, error = _open(voice)
    if error:
        return {"error": error}
    if words_per_minute is not None:
        library.espeak_SetParameter(SPEED, words_per_minute, 0)
    sound, events = _synthesize(library, text, UTF8 | (SSML if is_ssml else PHONEMES))
    return {"rate": rate, "samples": base64.b64encode(sound).decode(), "events": events}


def spell(words: list[str], voice: str) -> dict[str, Any]:
    """The phonemes of each word in IPA, parted by underscores, or an error."""
    library, _, error = _open(voice)
    if error:
        return {"error": error}
    library.espeak_TextToPhonemes.restype = ctypes.c_char_p
    found = []
    for word in words:
        rest = ctypes.c_char_p(word.encode("utf-8"))
        parts = []
        while rest.value:
            spelled = library.espeak_TextToPhonemes(ctypes.byref(rest), UTF8, IPA | ord("_") << 8)
            parts.append((spelled or b"").decode("utf-8", "ignore"))
        found.append(" ".join(parts))
    return {"phonemes": found}


def _open(voice: str) -> tuple[Any, int, str]:
    """The library with a voice, the rate of its samples, and what is wrong, if anything is."""
    import espeakng_loader

    library = ctypes.CDLL(espeakng_loader.get_library_path())
    library.espeak_ListVoices.restype = ctypes.POINTER(ctypes.POINTER(_Voice))
    data = espeakng_loader.get_data_path().encode()
    rate = library.espeak_Initialize(SYNCHRONOUS, 0, data, PHONEME_EVENTS | IPA | DO_NOT_EXIT)
    if rate <= 0:
        return library, 0, "eSpeak NG does not start; install it again: pip install 'phonanim[espeak]'"
    files = {key: file for code, name, file in reversed(_voices(library)) for key in (name, code)}
    name, plus, variant = voice.partition("+")
    file = files.get(DEFAULT if name.lower() == "english" else name.lower(), "")
    if not file or library.espeak_SetVoiceByName(f"{file}{plus}{variant}".encode()) != 0:
        near = get_close_matches(voice.lower(), files, n=1)
        hint = f"did you mean {near[0]!r}?" if near else "voices are language codes, such as de or pt-br"
        return library, 0, f"eSpeak NG has no voice {voice!r}; {hint}"
    return library, rate, ""


def _synthesize(library: Any, text: str, flags: int) -> tuple[bytes, list[tuple[int, int, int, int, str]]]:
    sound, events = bytearray(), list[tuple[int, int, int, int, str]]()

    def collect(samples: Any, count: int, given: Any) -> int:
        if samples and count > 0:
            sound.extend(ctypes.string_at(samples, 2 * count))
        index = 0
        while given[index].type != LAST:
            event = given[index]
            label = bytes(event.id.string).split(b"\0")[0].decode("utf-8", "ignore")
            events.append((event.type, event.sample, event.text_position, event.length, label))
            index += 1
        return 0

    callback = _Callback(collect)
    library.espeak_SetSynthCallback(callback)
    encoded = text.encode("utf-8")
    library.espeak_Synth(encoded, len(encoded) + 1, 0, CHARACTERS, 0, flags, None, None)
    library.espeak_Synchronize()
    return bytes(sound), events


def _voices(library: Any) -> list[tuple[str, str, str]]:
    """Language codes, each with a voice: its name in lower case without what is in brackets, and its file."""
    found = []
    listed, index = library.espeak_ListVoices(None), 0
    while listed[index]:
        voice = listed[index].contents
        place = voice.languages  # each a byte of priority and a text that ends with 0; the last is empty
        while ctypes.string_at(place, 1) != b"\0":
            code = ctypes.string_at(place + 1)
            name = voice.name.decode().lower().split(" (")[0]
            found.append((code.decode(), name, voice.identifier.decode()))
            place += len(code) + 2
        index += 1
    return found


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    json.dump(spell(**asked) if "words" in asked else speak(**asked), sys.stdout)
