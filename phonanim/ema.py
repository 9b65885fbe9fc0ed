"""Electromagnetic articulography: lip sensors beside labelled segments (SSFF and EMU bundles)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.alignment import Alignment, Interval, read_alignment
from phonanim.language import to_phones
from phonanim.phones import PhoneTrack

Array = NDArray[np.float64]
RUN_ON = 1.0  # seconds; a last segment longer than this runs on through the silence after the speech
LAST = 0.12  # seconds that such a segment is taken to last


@dataclass(frozen=True)
class Utterance:
    """`aperture` (samples,) mm is the vertical distance of the lip sensors at `times` (samples,) s.

    `speech` (samples,) says where something is said, `audio` is the recording.
    """

    name: str
    track: PhoneTrack
    times: Array
    fps: float
    aperture: Array
    speech: NDArray[np.bool_]
    audio: Path


def read_ssff(path: Path) -> tuple[dict[str, Array], float]:
    """Columns of an SSFF file by name, (samples,) each, and its rate in hertz."""
    raw = path.read_bytes()
    end = raw.index(b"-----------------\n") + 18
    lines = [line.split() for line in raw[:end].decode("ascii").splitlines()]
    rate = next(float(words[1]) for words in lines if words[0] == "Record_Freq")
    columns = [words[1] for words in lines if words[0] == "Column"]
    values = np.frombuffer(raw[end:], "<f4").reshape(-1, len(columns)).astype(np.float64)
    return {name: values[:, i] for i, name in enumerate(columns)}, rate


def load_utterances(folder: Path) -> list[Utterance]:
    """Every utterance of a folder of EMU bundles with lip sensors beside them."""
    return [_load(path, path.name.removesuffix("_bndl.json")) for path in sorted(folder.glob("*_bndl.json"))]


def _load(path: Path, name: str) -> Utterance:
    upper, rate = read_ssff(path.parent / f"{name}.upper_lip")
    lower, _ = read_ssff(path.parent / f"{name}.lower_lip")
    alignment = _without_run_on(read_alignment(path))
    track = to_phones(alignment, "german")[0]
    times = np.arange(len(upper["ul_posz"])) / rate
    spoken = [i for i in alignment.intervals if i.label and not i.label.startswith("&")]
    moving = np.abs(upper["ul_posz"]) + np.abs(lower["ll_posz"]) > 0  # the traces end in zeros
    speech = (times >= spoken[0].start) & (times < spoken[-1].end) & moving
    aperture = upper["ul_posz"] - lower["ll_posz"]
    return Utterance(name, track, times, rate, aperture, speech, path.parent / f"{name}.wav")


def _without_run_on(alignment: Alignment) -> Alignment:
    """End the last sound where speech ends; the labels let it run on through 1 to 2 s of silence."""
    kept = [
        Interval(i.label, i.start, i.start + LAST) if i.end - i.start > RUN_ON and i.label[:1] != "&" else i
        for i in alignment.intervals
    ]
    return Alignment(tuple(kept), alignment.duration, alignment.tier, alignment.source, alignment.words)
