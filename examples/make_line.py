"""Make examples/line.wav and examples/line.TextGrid: a sentence spoken by espeak-ng and aligned.

    python examples/make_line.py

Needs the library of espeak-ng (libespeak-ng.so.1, Debian: espeak-ng) and phonanim[align]. It prints how
far the phone onsets of the alignment are from those that the synthesizer itself reports.
"""

from __future__ import annotations

import ctypes
import wave
from pathlib import Path

import numpy as np

from phonanim.aligners.pocketsphinx import align
from phonanim.media.audio import resample
from phonanim.speech.textgrid import write_textgrid

HERE = Path(__file__).resolve().parent
TEXT = "My father watched Bob move a cheap blue lamp from the wash room."
VOICE, WORDS_PER_MINUTE = b"en-us", 150
RATE = 16000
PAUSE = 0.3  # seconds of silence before and after
SYNCHRONOUS, PHONEME_EVENTS, PHONEME = 2, 1, 7  # numbers of speak_lib.h


class EventId(ctypes.Union):
    _fields_ = [("number", ctypes.c_int), ("name", ctypes.c_char_p), ("string", ctypes.c_char * 8)]


class Event(ctypes.Structure):
    _fields_ = [
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", EventId),
    ]


def speak(text: str) -> tuple[np.ndarray, int, list[tuple[str, float]]]:
    """Samples (samples,) in -1..1, their rate, and each phone of espeak-ng with its onset in seconds."""
    library = ctypes.CDLL("libespeak-ng.so.1")
    sound, onsets = bytearray(), []

    def collect(wave_data: object, count: int, events: object) -> int:
        if wave_data and count > 0:
            sound.extend(ctypes.string_at(wave_data, 2 * count))
        index = 0
        while events[index].type:
            if events[index].type == PHONEME:
                onsets.append((events[index].id.string.decode(), events[index].audio_position / 1000))
            index += 1
        return 0

    callback = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(Event)
    )(collect)
    rate = library.espeak_Initialize(SYNCHRONOUS, 0, None, PHONEME_EVENTS)
    library.espeak_SetSynthCallback(callback)
    library.espeak_SetVoiceByName(VOICE)
    library.espeak_SetParameter(1, WORDS_PER_MINUTE, 0)
    encoded = text.encode()
    library.espeak_Synth(encoded, len(encoded) + 1, 0, 1, 0, 1, None, None)
    library.espeak_Synchronize()
    return np.frombuffer(bytes(sound), "<i2").astype(np.float32) / 32768, rate, onsets


def write_wav(path: Path, samples: np.ndarray) -> None:
    """Write mono 16-bit samples at RATE."""
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(RATE)
        stream.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def main() -> None:
    samples, rate, onsets = speak(TEXT)
    silence = np.zeros(round(PAUSE * RATE), np.float32)
    write_wav(HERE / "line.wav", np.concatenate([silence, resample(samples, rate, RATE), silence]))
    found = align(HERE / "line.wav", TEXT)
    tiers = {"words": found.words, "phones": found.phones}
    write_textgrid(HERE / "line.TextGrid", tiers, found.duration)
    spoken = [onset + PAUSE for label, onset in onsets if not label.startswith("_")]
    compare(spoken, [phone.start for phone in found.phones])


def compare(spoken: list[float], aligned: list[float]) -> None:
    """Print how far the aligned onsets are from the nearest that the synthesizer reported."""
    errors = np.abs(np.subtract.outer(aligned, spoken)).min(axis=1) * 1000
    print(
        f"{len(aligned)} phones: onset error {np.median(errors):.0f} ms median, {errors.max():.0f} ms at most"
    )


if __name__ == "__main__":
    main()
