"""Videos of a speaking face -> a folder of recordings for `build_corpus`."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.aligners.pocketsphinx import align_sound
from phonanim.core.decode import MAX_TEXT, DecodeError, read_utf8
from phonanim.core.files import atomic_path, make_folder_within, write_text
from phonanim.corpus.tracking import Quality, Track, Tracker, measure_quality, track_film
from phonanim.errors import AlignmentError, CorpusError, OptionError, PhonanimError
from phonanim.face.model import OUTER_LIPS, SUBNASALE
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import Sound
from phonanim.media.video import (
    SOUND_RATE,
    Film,
    conversion_hint,
    open_film,
    read_frames,
    read_sound,
    write_film,
    write_sound,
)
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

Array = NDArray[np.float64]
Progress = Callable[[float], None]

SCALE = 0.125  # pixels per unit of the stored landmarks
MARGIN = 0.15  # of the size of the lower face, around it in the mouth video
SAME_RATE = 1e-3  # relative difference
LENGTH_TOLERANCE = 0.25  # seconds by which an alignment may be longer or shorter than its video


@dataclass(frozen=True)
class Clip:
    """One usable video: the position of its mouth, and the quality of its track."""

    name: str
    film: Film
    track: Track
    quality: Quality
    corner: tuple[int, int]
    phones: int


@dataclass(frozen=True)
class Rejected:
    """One unusable video, and the reason in one line."""

    film: Path
    why: str


@dataclass(frozen=True)
class FilmReport:
    """The result for every video."""

    clips: tuple[Clip, ...]
    rejected: tuple[Rejected, ...]


def make_recordings(
    films: Sequence[Path],
    destination: Path,
    tracker: Tracker,
    test: float = 0.1,
    progress: Progress = lambda done: None,
) -> FilmReport:
    """Track videos, align their speech, and write a recordings folder.

    Next to each video is its alignment (.TextGrid) or its text (.txt). `test` is the share of the test
    clips. The folder gets clips.csv, landmarks.npz, textgrid/, audio/, mouth/ (the videos for
    `corpus appearance`), quality.json and quality.txt. An unusable video is left out and listed in the
    report. Raises CorpusError when no video is usable, or two have one name.
    """
    names = [film.stem for film in films]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise CorpusError(f"{twice[0]}: two videos have this name; rename one, because clips are named by it")
    clips: list[Clip] = []
    rejected: list[Rejected] = []
    for number, path in enumerate(films):
        try:
            share = _part(progress, number, len(films))
            clips.append(process_film(path, destination, tracker, clips[0].film if clips else None, share))
        except PhonanimError as error:
            rejected.append(Rejected(path, str(error)))
    if not clips:
        raise CorpusError(f"none of the {len(films)} videos can be used; the first: {rejected[0].why}")
    report = FilmReport(tuple(clips), tuple(rejected))
    write_tables(report, tracker, destination, test)
    return report


def process_film(
    path: Path,
    destination: Path,
    tracker: Tracker,
    first: Film | None = None,
    progress: Progress = lambda done: None,
) -> Clip:
    """Track and align one video; then write its audio, its TextGrid and its mouth video.

    Raises a PhonanimError with the reason when the video cannot be used; then nothing is written.
    """
    film = open_film(path)
    if first and abs(float(film.rate / first.rate) - 1) > SAME_RATE:
        raise CorpusError(
            f"{path}: has {float(film.rate):g} frames per second and {first.path.name} "
            f"{float(first.rate):g}; {conversion_hint(path, first.rate)}"
        )
    sound = read_sound(path)
    words, phones = transcribe(find_text(path), film, sound)
    track = track_film(film, tracker, progress)
    for folder in ("audio", "textgrid", "mouth"):
        make_folder_within(destination / folder, destination)
    write_sound(sound, destination / "audio" / f"{path.stem}.flac")
    duration = max(len(track.landmarks) / float(film.rate), len(sound) / SOUND_RATE, phones[-1].end)
    write_textgrid(
        destination / "textgrid" / f"{path.stem}.TextGrid", {"words": words, "phones": phones}, duration
    )
    corner = film_mouth(film, track, tracker, destination / "mouth" / f"{path.stem}.mp4")
    worth = measure_quality(track.landmarks, tracker.indices)
    return Clip(path.stem, film, track, worth, corner, len(phones))


def find_text(film: Path) -> Path:
    """The speech of a video: the TextGrid next to it, else the text. Raises CorpusError."""
    for suffix in (".TextGrid", ".txt"):
        if film.with_suffix(suffix).is_file():
            return film.with_suffix(suffix)
    raise CorpusError(
        f"{film}: no text; write the spoken words to {film.with_suffix('.txt').name} next to it, "
        f"or put its alignment there ({film.with_suffix('.TextGrid').name})"
    )


def transcribe(
    spoken: Path, film: Film, sound: NDArray[np.float32]
) -> tuple[Sequence[Interval], Sequence[Interval]]:
    """Words and phones of a video, from its TextGrid, or aligned from its audio and text."""
    if spoken.suffix == ".txt":
        return find_phones(spoken, film, sound)
    alignment = read_alignment(spoken)
    length = film.frames / float(film.rate)
    if abs(alignment.duration - length) > LENGTH_TOLERANCE:
        raise CorpusError(
            f"{spoken}: lasts {alignment.duration:.2f} s and the video {length:.2f} s; align it again"
        )
    return alignment.words, alignment.intervals


def find_phones(
    spoken: Path, film: Film, sound: NDArray[np.float32]
) -> tuple[Sequence[Interval], Sequence[Interval]]:
    """Words and phones by `phonanim align`. Raises CorpusError with the name of the video."""
    try:
        text = read_utf8(spoken, MAX_TEXT).removeprefix("\ufeff")
    except (OSError, DecodeError) as error:
        raise CorpusError(f"{spoken}: cannot be read: {error}; save it as UTF-8") from error
    try:
        found = align_sound(Sound(sound, SOUND_RATE), text, str(spoken))
    except (AlignmentError, OptionError) as error:
        raise CorpusError(f"{spoken}: {str(error).removeprefix(f'{spoken}: ')}") from error
    return found.words, found.phones


def film_mouth(film: Film, track: Track, tracker: Tracker, target: Path) -> tuple[int, int]:
    """Write the video of the lower face, cropped at a fixed place; returns its corner (right, down) in px."""
    low, high = mouth_box(track.landmarks, tracker.indices)
    frames = (frame[low[1] : high[1], low[0] : high[0]] for frame in read_frames(film.path))
    write_film(_evened(frames), target, film.rate)
    return int(low[0]), int(low[1])


def mouth_box(landmarks: Array, indices: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The corners of a box around the lower face in all frames, from the top left (right, down)."""
    mean = landmarks.mean(axis=0)
    nose, mouth = (mean[np.isin(indices, n), 1].mean() for n in ((SUBNASALE,), OUTER_LIPS))
    lower = landmarks[:, mean[:, 1] > nose - (mouth - nose) * 2, :2].reshape(-1, 2)
    low, high = lower.min(axis=0), lower.max(axis=0)
    room = MARGIN * (high - low)
    return np.maximum(low - room, 0).astype(np.int64), np.ceil(high + room).astype(np.int64)


def _evened(frames: Iterator[NDArray[np.uint8]]) -> Iterator[NDArray[np.uint8]]:
    """Frames without an odd last row or column, which H.264 cannot encode."""
    return (frame[: len(frame) // 2 * 2, : frame.shape[1] // 2 * 2] for frame in frames)


def write_tables(report: FilmReport, tracker: Tracker, destination: Path, test: float) -> None:
    """Write the tables of all clips: quality.json, quality.txt, landmarks.npz and, last, clips.csv."""
    splits = choose_test_clips(len(report.clips), test)
    facts = [_facts(clip, kind) for clip, kind in zip(report.clips, splits, strict=True)]
    rejected = [{"film": str(film.film), "why": film.why} for film in report.rejected]
    document = {
        "tracker": tracker.name,
        "fps": float(report.clips[0].film.rate),
        "clips": facts,
        "rejected": rejected,
    }
    write_text(destination / "quality.json", json.dumps(document, indent=1) + "\n")
    write_text(destination / "quality.txt", "".join(line + "\n" for line in report_text(report)))
    write_landmarks(report.clips, tracker.indices, destination / "landmarks.npz")
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(["clip", "frames", "crop_x", "crop_y", "split"])
    for clip, kind in zip(report.clips, splits, strict=True):
        writer.writerow([clip.name, len(clip.track.landmarks), *clip.corner, kind])
    write_text(destination / "clips.csv", table.getvalue())


def choose_test_clips(n_clips: int, test: float) -> list[str]:
    """Choose the split of each clip: a share of test clips, evenly spread, never the only clip."""
    n_test = min(round(test * n_clips), n_clips - 1)
    chosen = {int((k + 0.5) * n_clips / n_test) for k in range(n_test)}
    return ["test" if number in chosen else "train" for number in range(n_clips)]


def write_landmarks(clips: Sequence[Clip], indices: NDArray[np.int64], path: Path) -> None:
    """Write concatenated tracks as differences in units of SCALE pixels."""
    units = np.rint(np.concatenate([clip.track.landmarks for clip in clips]) / SCALE).astype(np.int32)
    with atomic_path(path) as partial:
        np.savez_compressed(
            partial,
            delta=np.diff(units, axis=0, prepend=np.zeros_like(units[:1])),
            scale=np.float32(SCALE),
            fps=np.float64(float(clips[0].film.rate)),
            indices=indices.astype(np.int32),
            clips=np.array([clip.name for clip in clips]),
            frames=np.array([len(clip.track.landmarks) for clip in clips], np.int32),
        )


def report_text(report: FilmReport) -> list[str]:
    """The report as text: a line per clip with its warnings, and the videos that were left out."""
    lines = ["clip                     frames  bridged  pupils px  jitter mm  turn deg  phones"]
    for clip in report.clips:
        worth, n_frames, n_bridged = clip.quality, len(clip.track.landmarks), len(clip.track.rejected)
        lines.append(
            f"{clip.name:24} {n_frames:6} {n_bridged:8} {worth.pupils_px:10.1f} "
            f"{worth.jitter_mm:10.2f} {worth.turn_deg:9.1f} {clip.phones:7}"
        )
        lines += [f"  {warning}" for warning in worth.warnings()]
        lines += [f"  frame {number}: {why}, bridged" for number, why in clip.track.rejected.items()]
    return lines + [f"rejected: {film.why}" for film in report.rejected]


def _facts(clip: Clip, kind: str) -> dict[str, Any]:
    worth = {name: round(value, 3) for name, value in asdict(clip.quality).items()}
    return {
        "clip": clip.name,
        "film": str(clip.film.path),
        "frames": len(clip.track.landmarks),
        "split": kind,
        "phones": clip.phones,
        **worth,
        "warnings": clip.quality.warnings(),
        "bridged": {str(number): why for number, why in clip.track.rejected.items()},
    }


def _part(progress: Progress, number: int, count: int) -> Progress:
    return lambda done: progress((number + done) / count)
