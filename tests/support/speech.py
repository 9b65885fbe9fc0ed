"""Small made-up speech for tests: tracks from phones and seconds, a face that opens and spreads."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np

from phonanim.corpus.corpus import Corpus
from phonanim.face.fit import fit_face
from phonanim.face.model import INNER_LIPS, OUTER_LIPS, FaceModel
from phonanim.media.audio import Sound
from phonanim.regressors import Examples
from phonanim.speech.alignment import Interval
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

NUMBERS = (2, 13, 14, 61, 291, 0, 17, 80, 88, 81, 178, 82, 87, 312, 317, 311, 402, 310, 318, 6, 168)


def track_of(text: str) -> PhoneTrack:
    """'sil 0.3 m 0.1 aa 0.2' as a track."""
    words = text.split()
    lengths = [float(word) for word in words[1::2]]
    bounds = np.concatenate([[0.0], np.cumsum(lengths)])
    return PhoneTrack(INVENTORY.codes(words[::2]), bounds, tuple(words[::2]))


def random_track(rng: np.random.Generator, segments: int = 20) -> PhoneTrack:
    """Phones and durations drawn at random, silence at both ends."""
    codes = rng.integers(0, 41, segments).astype(np.uint8)
    codes[[0, -1]] = 0
    bounds = np.concatenate([[0.0], np.cumsum(rng.uniform(0.03, 0.2, segments))])
    return PhoneTrack(codes, bounds, tuple(INVENTORY.phones[c] for c in codes))


def made_up_face(rng: np.random.Generator) -> FaceModel:
    """A face of 21 landmarks whose modes open the lips, spread the corners and push the lips forward."""
    rows = {number: row for row, number in enumerate(NUMBERS)}
    mean = np.zeros((len(NUMBERS), 3))
    mean[:, 1] = -60
    mean[[rows[6], rows[168], rows[2]], 1] = (0, 5, -40)
    uppers = [rows[n] for n in (13, 0, 80, 81, 82, 312, 311, 310)]
    lowers = [rows[n] for n in (14, 17, 88, 178, 87, 317, 402, 318)]
    mean[uppers, 1], mean[lowers, 1] = -57, -60
    mean[[rows[61], rows[291]], 0] = (-25, 25)
    shapes = np.tile(mean, (400, 1, 1))
    opening, spread, forward = rng.normal(0, [[3.0], [1.5], [0.7]], (3, 400))
    shapes[:, lowers, 1] -= opening[:, None]
    shapes[:, uppers, 1] += 0.2 * opening[:, None]
    shapes[:, rows[61], 0] -= spread
    shapes[:, rows[291], 0] += spread
    shapes[:, uppers + lowers, 2] += forward[:, None]
    return fit_face(shapes, np.array(NUMBERS), variance=0.999)


def sound_of(track: PhoneTrack, rate: int = 8000) -> Sound:
    """A recording in which every phone is a tone of its own, and silence is silent."""
    codes = track.sample(np.arange(round(track.duration * rate)) / rate)
    phase = 2 * np.pi * np.cumsum((100 + 90 * codes) / rate)
    return Sound(np.where(codes > 0, 0.3 * np.sin(phase), 0).astype(np.float32), rate)


def write_wav(path: Path, sound: Sound) -> None:
    """A recording as 16-bit WAV."""
    with wave.open(str(path), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(sound.rate)
        stream.writeframes((np.clip(sound.samples, -1, 1) * 32767).astype("<i2").tobytes())


def made_up_examples(rng: np.random.Generator, clips: int = 12, modes: int = 3) -> Examples:
    """Clips whose modes are a smoothed function of the phones, so that a regressor can learn them."""
    levels = rng.normal(0, 5, (41, modes))
    tracks = tuple(random_track(rng) for _ in range(clips))
    times = tuple((np.arange(int(track.duration * 25)) + 0.5) / 25 for track in tracks)
    targets = tuple(levels[t.sample(at)].astype(np.float32) for t, at in zip(tracks, times, strict=True))
    return Examples(tracks, times, targets, (1.0,) * clips, tuple(map(sound_of, tracks)))


def made_up_corpus(rng: np.random.Generator, clips: int = 24) -> Corpus:
    """Clips of a mouth that opens as far as each phone says; the last quarter are test clips."""
    numbers = tuple(sorted({*NUMBERS, *OUTER_LIPS, *INNER_LIPS}))
    rows = {number: row for row, number in enumerate(numbers)}
    mean = np.zeros((len(numbers), 3))
    mean[:, 1] = -58
    mean[[rows[6], rows[168], rows[2]], 1] = (0, 5, -40)
    mean[:, 0] = rng.normal(0, 10, len(numbers))
    lower = [rows[n] for n in (14, 17, 87, 88, 178, 317, 318, 402)]
    wide = [rows[n] for n in (61, 291)]
    opening, spread = rng.uniform(0, 10, 41), rng.normal(0, 2, 41)
    tracks = tuple(random_track(rng) for _ in range(clips))
    frames = np.array([int(track.duration * 25) for track in tracks])
    codes = np.concatenate([t.sample((np.arange(n) + 0.5) / 25) for t, n in zip(tracks, frames, strict=True)])
    landmarks = np.tile(mean, (len(codes), 1, 1)) + rng.normal(0, 0.1, (len(codes), *mean.shape))
    landmarks[:, lower, 1] -= opening[codes][:, None]
    landmarks[:, wide, 0] += spread[codes][:, None] * np.array([-1, 1])
    return Corpus(
        landmarks=landmarks.astype(np.float32),
        indices=np.array(numbers),
        fps=25.0,
        clips=tuple(f"clip{number:02}" for number in range(clips)),
        frames=frames,
        tracks=tracks,
        words=tuple((Interval(f"w{n % 4}", 0.1, t.duration),) for n, t in enumerate(tracks)),
        split=tuple("test" if number >= 0.75 * clips else "train" for number in range(clips)),
        audio=tuple(Path(f"clip{number:02}.wav") for number in range(clips)),
        provenance={"source": "made up"},
    )
