"""The voices that benchmarks/audio_alone.py judges by: sound, phones, and curves that were measured."""

from __future__ import annotations

import html
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners.espeak import speak, write_speech
from phonanim.corpus.corpus import load_corpus
from phonanim.ema import load_utterances
from phonanim.ema.channels import sensor_channels
from phonanim.face.model import lip_aperture, lip_width
from phonanim.media.audio import Sound, read_sound
from phonanim.media.voice import FRAMES, analyze_voice
from phonanim.pipeline import load_model
from phonanim.speech.textgrid import write_textgrid

Array = NDArray[np.float64]
PIECE = 15.0  # seconds of a take
SHIFTS = (0.85, 1.18)  # lengths of another vocal tract: formants divided by them
SPOKEN = 3  # phrases of each language
VOICES = {  # languages and variants of voices that took no part in training
    "fr": ("fra", "f4"),
    "ru": ("rus", "m6"),
    "cmn": ("cmn_hans", "Annie"),
    "ko": ("kor", "michel"),
    "hi": ("hin", "belinda"),
}
LABELLED = (
    ("001_en_LJ001-0012", "english"),
    ("002_en_LJ006-0114", "english"),
    ("004_en_LJ030-0031", "english"),
    ("059_en_mary", "auto"),
    ("061_en_damon_set_test", "auto"),
)


@dataclass
class Judged:
    """A recording of a set, with curves (frames,) and their rate by channel, that begin at `begin` seconds.

    Without `measured`, motion from its phones is the measure. `channels` names ours where theirs differ.
    `kept` (frames,) is where somebody speaks, if it is known. `in_mm` is whether curves are in millimetres.
    """

    set: str
    recording: Path
    sound: Sound
    alignment: Path | None = None
    language: str = "auto"
    measured: dict[str, tuple[Array, float]] = field(default_factory=dict)
    channels: dict[str, str] = field(default_factory=dict)
    begin: float = 0.0
    kept: NDArray[np.bool_] | None = None
    in_mm: bool = True

    def speech(self, times: Array) -> NDArray[np.bool_]:
        """Where somebody speaks, by the level: within 30 dB of the loud parts."""
        level = analyze_voice(self.sound.samples, self.sound.rate).level
        loud = level > np.quantile(level, 0.95) - 30
        return loud[np.clip((times * FRAMES).astype(int), 0, len(loud) - 1)]


@cache
def scratch() -> Path:
    """A folder that is kept until the program ends."""
    folder = tempfile.TemporaryDirectory(prefix="audio-alone-")
    KEPT.append(folder)
    return Path(folder.name)


KEPT: list[tempfile.TemporaryDirectory[str]] = []


def written(name: str, samples: NDArray[np.floating], rate: int) -> Path:
    """A WAV of samples."""
    import wave

    path = scratch() / f"{name}.wav"
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(rate)
        stream.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())
    return path


def rig_takes(recordings: Path, corpus: Path | None, udhr: Path | None) -> Iterator[Judged]:
    """Takes of a Mandarin speaker, with curves of a rig that artists solved from film."""
    folder = recordings / "facegood"
    if not folder.is_dir():
        return
    stored = np.load(folder / "curves.npz", allow_pickle=False)
    names, fps = stored["names"].tolist(), float(stored["fps"])
    for take in sorted(set(stored.files) - {"fps", "names"}):
        sound, curves = read_sound(folder / f"{take}.flac"), stored[take].astype(np.float64)
        piece = int(PIECE * fps)
        for number, first in enumerate(range(0, len(curves) - piece, piece)):
            rows = curves[first : first + piece]
            begin, end = (round(at / fps * sound.rate) for at in (first, first + piece))
            own = Sound(sound.samples[begin:end], sound.rate)
            yield Judged(
                "rig takes, Mandarin",
                written(f"{take}-{number}", own.samples, own.rate),
                own,
                measured={
                    "jaw": (columns(rows, names, "mouth_stretch_c"), fps),
                    "lips apart": (
                        columns(
                            rows, names, "mouth_stretch_c", "mouth_lowerLipDepress", "mouth_upperLipRaise"
                        )
                        - columns(rows, names, "mouth_press", "mouth_suck"),
                        fps,
                    ),
                    "rounding": (
                        columns(rows, names, "mouth_oh", "mouth_oo", "mouth_funnel", "mouth_pucker"),
                        fps,
                    ),
                },
                channels={"lips apart": "lip_gap", "rounding": "protrusion"},
                in_mm=False,
            )


def columns(rows: Array, names: list[str], *heads: str) -> Array:
    """The sum over control families of the mean of each, (frames,)."""
    return np.sum([rows[:, [n.startswith(head) for n in names]].mean(axis=1) for head in heads], axis=0)


def sensors(recordings: Path, corpus: Path | None, udhr: Path | None) -> Iterator[Judged]:
    """German sentences with sensors on jaw and lips."""
    folder = recordings / "ema_de"
    for utterance in load_utterances(folder) if folder.is_dir() else []:
        curves = sensor_channels(utterance.articulation)
        yield Judged(
            "sensors, German",
            utterance.audio,
            read_sound(utterance.audio),
            utterance.audio.with_name(f"{utterance.audio.stem}_bndl.json"),
            "german",
            {name: (curves[name], utterance.fps) for name in ("jaw", "lip_gap")},
            begin=float(utterance.times[0]),
            kept=utterance.speech,
        )


def camera(recordings: Path, corpus: Path | None, udhr: Path | None) -> Iterator[Judged]:
    """The test clips of GRID, whose voice was learned from, as they are and with another vocal tract."""
    if corpus is None:
        return
    known, face = load_corpus(corpus), load_model("default").face
    for clip in known.clips_of("test"):
        shapes = known.landmarks[known.rows([clip])].astype(np.float64)
        times, name = known.times(clip), known.clips[clip]
        sound = read_sound(known.audio[clip])
        measured = {
            "lip_gap": (lip_aperture(shapes, face), known.fps),
            "lip_width": (lip_width(shapes, face), known.fps),
        }
        alignment = recordings / "grid_s1" / "textgrid" / f"{name}.TextGrid"
        yield Judged(
            "GRID test clips", known.audio[clip], sound, alignment, "english", measured, begin=float(times[0])
        )
        shift = SHIFTS[clip % 2]
        moved = moved_formants(sound, shift)
        path = written(f"{name}-moved", moved.samples, moved.rate)
        yield Judged(
            "GRID, formants moved", path, moved, alignment, "english", measured, begin=float(times[0])
        )


def moved_formants(sound: Sound, shift: float) -> Sound:
    """The sound by a voice with another vocal tract and another pitch (Praat's "Change gender")."""
    import parselmouth

    made = parselmouth.Sound(sound.samples.astype(np.float64), sound.rate)
    changed = parselmouth.praat.call(
        made, "Change gender", 75, 600, shift, 180.0 if shift > 1 else 90.0, 1, 1
    )
    samples = np.asarray(changed.values[0], np.float32)
    return Sound(
        np.pad(samples, (0, max(len(sound.samples) - len(samples), 0)))[: len(sound.samples)], sound.rate
    )


def spoken_languages(recordings: Path, corpus: Path | None, udhr: Path | None) -> Iterator[Judged]:
    """Phrases in five languages that took no part in training, by eSpeak NG."""
    for code, (text, variant) in VOICES.items() if udhr is not None else ():
        assert udhr is not None
        for number, phrase in enumerate(phrases_of(udhr / f"{text}.html")[:SPOKEN]):
            spoken = speak(phrase, f"{code}+{variant}")
            path = scratch() / f"{code}-{number}.wav"
            write_speech(path, spoken)
            write_textgrid(path.with_suffix(".TextGrid"), {"phones": spoken.phones}, spoken.duration)
            yield Judged(f"eSpeak NG, {code}", path, read_sound(path), path.with_suffix(".TextGrid"), "ipa")


def phrases_of(path: Path) -> list[str]:
    """Phrases of a text, in its order."""
    text = html.unescape(re.sub(r"<[^>]*>", "\n", path.read_text("utf-8").split("<body>")[1]))
    found = [part.strip() for part in re.split(r"[\n.;:；。]+", text)]
    return [part for part in found if 30 <= len(part.encode()) <= 200][2:]


def labelled(recordings: Path, corpus: Path | None, udhr: Path | None) -> Iterator[Judged]:
    """Recordings of three others with phones, by hand or by the Montreal Forced Aligner."""
    folder = recordings / "textgrids"
    for stem, language in LABELLED if folder.is_dir() else ():
        path = folder / f"{stem}.wav"
        if path.is_file():
            yield Judged(
                "three others, English", path, read_sound(path), path.with_suffix(".TextGrid"), language
            )


JUDGES: dict[str, Callable[[Path, Path | None, Path | None], Iterator[Judged]]] = {
    "takes": rig_takes,
    "sensors": sensors,
    "camera": camera,
    "labelled": labelled,
    "languages": spoken_languages,
}
