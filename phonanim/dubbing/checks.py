"""Checks of an animated line: each check is one function and gives at most one flag."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.dubbing.align_lines import SPOKEN
from phonanim.errors import AudioError, MissingExtraError
from phonanim.face.contacts import lip_part
from phonanim.face.model import lip_aperture
from phonanim.media.audio import audio_duration, read_audio
from phonanim.pipeline import AnimationResult
from phonanim.speech.alignment_file import quote_label
from phonanim.speech.bilabials import shut_segments
from phonanim.speech.language import NOISE_NOTE
from phonanim.speech.phones import PhoneTrack, pair_rows

OPEN_MM = 1.0  # a gap between the lips that is visibly open
FASTEST = 22.0  # phones per second; fluent speech has 10 to 16
WINDOW = 1.0  # seconds over which the rate is measured
LENGTH_TOLERANCE = 0.15  # seconds between the ends of recording and alignment
STEP = 0.01  # seconds, for the loudness of the recording
MARGIN = 5  # steps on each side of a boundary that do not count, because boundaries are not that exact
CONTRAST_DB = 20.0  # least range of loudness in which silence and speech can be separated
LONG_NOISE = 0.5  # seconds; a longer `spn` may be a word that the dictionary lacks, a longer breath is rare
MISPLACED = 0.3  # seconds of sound in silence, or of silence in speech, that make a flag


@dataclass(frozen=True, slots=True)
class Flag:
    """One possible problem; `severity` is 0 to 1 and sorts the report."""

    check: str
    severity: float
    text: str


def line_facts(result: AnimationResult, audio: Path | None) -> dict[str, Any]:
    """The data of a line in the report: its size and its flags, the worst first."""
    flags = [flag for check in CHECKS if (flag := check(result, audio))]
    flags.sort(key=lambda flag: -flag.severity)
    return {
        "frames": len(result.animation.values),
        "seconds": round(result.track.duration, 6),
        "phones": int(np.count_nonzero(result.track.codes)),
        "language": result.language.facts() if result.language else None,
        "flags": [asdict(flag) for flag in flags],
    }


def replaced_labels(result: AnimationResult, audio: Path | None) -> Flag | None:
    """Labels that were not used as written."""
    doubts = result.language.doubt() if result.language else ()
    notes = [
        note
        for note in result.notes
        if note not in doubts and not note.startswith(SPOKEN) and not _is_usual_noise(note, result)
    ]
    return Flag("labels", _severity(len(notes), 5), "; ".join(notes)) if notes else None


def _is_usual_noise(note: str, result: AnimationResult) -> bool:
    """Whether a note is of breaths and other noises, none of them long enough to hide speech."""
    if not note.endswith(NOISE_NOTE):
        return False
    named = [
        phone for phone in result.animation.phones if note.startswith(f'"{quote_label(phone.label)}" at ')
    ]
    return max((phone.end - phone.start for phone in named), default=0.0) <= LONG_NOISE


def unsure_language(result: AnimationResult, audio: Path | None) -> Flag | None:
    """A language that the labels do not tell, where others read them as other phones."""
    doubt = result.language.doubt() if result.language else ()
    if result.language is None or not doubt:
        return None
    return Flag("language", _severity(1 - result.language.certainty, 1), doubt[0])


def missed_closures(result: AnimationResult, audio: Path | None) -> Flag | None:
    """p, b and m, by phone or by the letters of the label, without closed lips in or next to them."""
    track, fps = result.track, result.animation.fps
    language = result.language.language if result.language else None
    numbers = np.array(shut_segments(track, language), np.int64)
    if len(numbers) == 0 or result.modes is None or result.face is None:
        return None
    first = np.floor(track.bounds[numbers] * fps).astype(int)
    last = np.minimum(np.ceil(track.bounds[numbers + 1] * fps).astype(int), len(result.modes) - 1)
    numbered, frames = pair_rows(np.minimum(first, last), last + 1)
    gaps = np.full(len(numbers), np.inf)
    lips, _ = lip_part(result.face)
    np.minimum.at(gaps, numbered, lip_aperture(lips.instance(result.modes[frames]), lips))
    missed = numbers[gaps > OPEN_MM]
    if len(missed) == 0:
        return None
    when = track.bounds[missed[0]]
    label = quote_label(track.labels[missed[0]])
    text = f'{len(missed)} of {len(numbers)} p b m show no closed lips, the first "{label}" at {when:.2f} s'
    return Flag("closures", _severity(len(missed), len(numbers)), text)


def fast_speech(result: AnimationResult, audio: Path | None) -> Flag | None:
    """More phones per second than anybody speaks: often a failed alignment."""
    track = result.track
    onsets = track.bounds[:-1][track.codes != 0]
    if len(onsets) == 0:
        return None
    counts = np.searchsorted(onsets, onsets + WINDOW) - np.arange(len(onsets))
    worst = int(np.argmax(counts))
    rate = counts[worst] / WINDOW
    if rate <= FASTEST:
        return None
    text = f"{rate:.0f} phones in the second after {onsets[worst]:.2f} s; check the alignment"
    return Flag("speed", _severity(rate - FASTEST, FASTEST), text)


def other_length(result: AnimationResult, audio: Path | None) -> Flag | None:
    """A recording that is longer or shorter than its alignment."""
    if audio is None:
        return None
    try:
        seconds = audio_duration(audio)
    except (AudioError, MissingExtraError) as error:
        return Flag("length", 0.1, str(error))
    off = seconds - result.track.duration
    if abs(off) <= LENGTH_TOLERANCE:
        return None
    text = f"the recording has {seconds:.2f} s, the alignment {result.track.duration:.2f} s"
    return Flag("length", _severity(abs(off), 1.0), text)


def misplaced_silence(result: AnimationResult, audio: Path | None) -> Flag | None:
    """Sound where the alignment has silence, or silence where it has phones."""
    levels = _levels(audio) if audio else None
    if levels is None:
        return None
    soft, loud = np.percentile(levels, [10, 95])
    if loud - soft < CONTRAST_DB:
        return None
    middle = (soft + loud) / 2
    silent, spoken = _certain(result.track, len(levels))
    noise = STEP * np.count_nonzero(levels[silent] > middle)
    quiet = STEP * np.count_nonzero(levels[spoken] < soft + 3.0)
    if max(noise, quiet) <= MISPLACED:
        return None
    text = f"{noise:.2f} s of sound in silence, {quiet:.2f} s of silence in speech; check the alignment"
    return Flag("silence", _severity(noise + quiet, 0.5 * result.track.duration), text)


CHECKS: tuple[Callable[[AnimationResult, Path | None], Flag | None], ...] = (
    replaced_labels,
    unsure_language,
    missed_closures,
    fast_speech,
    other_length,
    misplaced_silence,
)


def _severity(count: float, most: float) -> float:
    return round(min(count / most, 1.0), 3)


def _levels(audio: Path) -> NDArray[np.float64] | None:
    """Loudness of each 10 ms in decibels; None when the recording cannot be read on this machine."""
    try:
        samples, rate = read_audio(audio)
    except (AudioError, MissingExtraError):
        return None
    length = round(rate * STEP)
    frames = samples[: len(samples) // length * length].reshape(-1, length).astype(np.float64)
    return 10 * np.log10((frames**2).mean(axis=1) + 1e-10) if len(frames) else None


def _certain(track: PhoneTrack, steps: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of silent and of spoken steps, without those near a boundary, (steps,) each."""
    times = np.asarray((np.arange(steps) + 0.5) * STEP, np.float64)
    silent = (track.sample(times) == 0).astype(int)
    count = np.convolve(silent, np.ones(2 * MARGIN + 1, int), mode="same")
    inside = times < track.duration
    return inside & (count == 2 * MARGIN + 1), inside & (count == 0)
