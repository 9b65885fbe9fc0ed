"""Which visemes can be read from the lips alone: a small reader of lips, learned from captured ones.

The reader sees lip curves at seven instants around the middle of a phone, to half a millimetre, and knows no
language: it takes every viseme as equally likely. It is linear (Fisher 1936), so that it can be written down
in a table. Curves are scaled by their own deviation in speech, as one gets used to a talker; the error of
what is seen is not, so that a mouth that hardly moves is not read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import write_text
from phonanim.core.lexicon import LEXICON
from phonanim.core.tables import parse_cell, read_rows
from phonanim.errors import EvaluationError
from phonanim.metrics import speech_mask
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

READER_FILE = LEXICON / "viseme_reader.csv"
VISEMES = {
    "closed": "p b m",
    "lip on teeth": "f v",
    "rounded": "w uw uh ow ao oy",
    "open": "aa ae ah ay aw",
    "spread": "ih iy eh ey y",
    "teeth together": "s z sh zh ch jh",
}
"""What is judged. Of the other phones, which the tongue makes (t d n l th dh k g ng r), lips say little."""
LIPS = ("aperture", "width", "protrusion", "upper_lip")
OFFSETS = np.array([-0.12, -0.08, -0.04, 0.0, 0.04, 0.08, 0.12])  # seconds from the middle of a phone
BLUR = 0.5  # mm, sd of the error with which lips are seen: a minute of arc at 1.7 m
RIDGE = 0.01  # share of the mean variance that is added to each, where there are few examples
DRAWS, SEED = 8, 0  # of that error, so that the same motion always scores the same


@dataclass(frozen=True)
class Reader:
    """Scores of visemes: `weights` (visemes, lips x offsets) and `bias` (visemes,) of seen lips.

    `lips` are the names of the curves.
    """

    lips: tuple[str, ...]
    weights: Array
    bias: Array

    def log_probability(self, seen: Array) -> Array:
        """Of each viseme, (phones, lips x offsets) -> (phones, visemes)."""
        score = seen @ self.weights.T + self.bias
        score -= score.max(axis=1, keepdims=True)
        return np.asarray(score - np.log(np.exp(score).sum(axis=1, keepdims=True)))


@dataclass(frozen=True)
class Sight:
    """What is seen of the lips at phones: `values` (phones, lips x offsets), without error and scaled.

    `blur` (lips x offsets,) is the sd of the error in the same scale, `said` (phones,) the viseme of each.
    """

    values: Array
    blur: Array
    said: Numbers


@dataclass(frozen=True)
class Reading:
    """`right` (phones,) is how often each phone was read as its viseme, from 0 to 1.

    `log_p` (phones,) is the mean log probability of that viseme, `said` (phones,) the viseme itself.
    """

    right: Array
    log_p: Array
    said: Numbers

    def share(self) -> float:
        """The share that is read right, a mean over visemes, so that frequent ones count no more."""
        return _mean_over(self.right, self.said)

    def log_probability(self) -> float:
        """Mean natural logarithm of the probability of what was said, a mean over visemes."""
        return _mean_over(self.log_p, self.said)


@dataclass(frozen=True)
class VisemeRow:
    """How often the phones of a viseme were read right, from 0 to 1, in the prediction and in the capture."""

    name: str
    read: float
    captured: float
    sounds: int


def viseme_scores(
    ours: Mapping[str, Array], theirs: Mapping[str, Array], times: Array, track: PhoneTrack
) -> tuple[dict[str, float], tuple[VisemeRow, ...]]:
    """What the shipped reader reads from predicted and captured lips, (frames,) mm each; and by viseme.

    Nothing where a curve that it looks at is unknown, or where no phone is judged.
    """
    reader = load_reader()
    if (
        not all(set(reader.lips) <= set(side) for side in (ours, theirs))
        or not speech_mask(track, times).any()
    ):
        return {}, ()
    mine, captured = (read_visemes(see_lips(side, times, track), reader) for side in (ours, theirs))
    if not len(mine.said):
        return {}, ()
    measures = {
        "visemes_legible": mine.share(),
        "captured_visemes_legible": captured.share(),
        "viseme_log_p": mine.log_probability(),
        "captured_viseme_log_p": captured.log_probability(),
    }
    return measures, tuple(viseme_rows(mine, captured))


def viseme_rows(mine: Reading, captured: Reading) -> Iterator[VisemeRow]:
    """The rows of the visemes that were said, in the order of VISEMES."""
    for number, name in enumerate(VISEMES):
        chosen = mine.said == number
        if chosen.any():
            shares = float(mine.right[chosen].mean()), float(captured.right[chosen].mean())
            yield VisemeRow(name, *shares, int(chosen.sum()))


def merge_visemes(tables: Iterable[Iterable[VisemeRow]]) -> list[VisemeRow]:
    """The tables of several lines as one, weighted by sounds, in the order of VISEMES."""
    rows = [row for table in tables for row in table]
    found = []
    for name in VISEMES:
        mine = [row for row in rows if row.name == name]
        if mine:
            count = sum(row.sounds for row in mine)
            read, captured = (
                sum(getattr(row, side) * row.sounds for row in mine) / count for side in ("read", "captured")
            )
            found.append(VisemeRow(name, read, captured, count))
    return found


def see_lips(
    curves: Mapping[str, Array],
    times: Array,
    track: PhoneTrack,
    lips: tuple[str, ...] = LIPS,
    speech: NDArray[np.bool_] | None = None,
) -> Sight:
    """Lip curves, (frames,) mm each at rising seconds, as they are seen at the phones that are judged.

    `speech` (frames,) are the frames by which curves are scaled; those of the track's phones by default.
    Phones whose middle lies outside the frames are left out. Raises EvaluationError without speech.
    """
    speech = speech_mask(track, times) if speech is None else speech
    if not speech.any():
        raise EvaluationError("there is no speech in the frames, so no viseme can be read")
    middles, said = judged_phones(track)
    within = (middles >= times[0]) & (middles <= times[-1])
    at = middles[within, None] + OFFSETS
    values, blur = [], []
    for name in lips:
        spread = float(np.hypot(curves[name][speech].std(), BLUR))
        values.append((np.interp(at, times, curves[name]) - curves[name][speech].mean()) / spread)
        blur += [BLUR / spread] * len(OFFSETS)
    return Sight(np.concatenate(values, axis=1), np.array(blur), said[within])


def judged_phones(track: PhoneTrack) -> tuple[Array, Numbers]:
    """Middles in seconds and viseme numbers of the phones of a track that are judged, (phones,) each."""
    of = np.full(len(INVENTORY.phones), -1)
    for number, phones in enumerate(VISEMES.values()):
        of[INVENTORY.codes(phones.split())] = number
    said = of[track.codes]
    middles = (track.bounds[:-1] + track.bounds[1:]) / 2
    return np.asarray(middles[said >= 0]), said[said >= 0]


def read_visemes(sight: Sight, reader: Reader) -> Reading:
    """Read seen lips DRAWS times, each time with another error of what is seen."""
    rng = np.random.default_rng(SEED)
    right, log_p = np.zeros(len(sight.said)), np.zeros(len(sight.said))
    rows = np.arange(len(sight.said))
    for _ in range(DRAWS):
        seen = sight.values + sight.blur * rng.normal(size=sight.values.shape)
        found = reader.log_probability(seen)
        right += (found.argmax(axis=1) == sight.said) / DRAWS
        log_p += found[rows, sight.said] / DRAWS
    return Reading(right, log_p, sight.said)


def fit_reader(sights: Iterable[Sight], lips: tuple[str, ...] = LIPS, ridge: float = RIDGE) -> Reader:
    """Fisher's linear discriminant of seen lips, every viseme as likely as another.

    Raises EvaluationError when a viseme was never said.
    """
    seen = list(sights)
    values, said = (np.concatenate([getattr(one, name) for one in seen]) for name in ("values", "said"))
    if absent := [name for number, name in enumerate(VISEMES) if not (said == number).any()]:
        raise EvaluationError(f"the recordings contain no phone that is {absent[0]!r}; add recordings")
    means = np.array([values[said == number].mean(axis=0) for number in range(len(VISEMES))])
    within = np.cov((values - means[said]).T, bias=True)
    within += np.diag(np.mean([one.blur**2 for one in seen for _ in one.said], axis=0))
    within += ridge * np.trace(within) / len(within) * np.eye(len(within))
    weights = np.linalg.solve(within, means.T).T
    return Reader(lips, weights, -0.5 * (weights * means).sum(axis=1))


@lru_cache(maxsize=2)
def load_reader(path: Path = READER_FILE) -> Reader:
    """Read a table of weights. Raises EvaluationError when it is damaged."""
    try:
        header, *rows = read_rows(path)
        table = np.array([[parse_cell(cell, "a weight") for cell in row[1:]] for row in rows])
        lips = tuple(dict.fromkeys(column.partition(" ")[0] for column in header[2:]))
    except (OSError, ValueError) as error:
        raise EvaluationError(f"{path}: cannot be read as a reader of visemes ({error})") from error
    if [row[0] for row in rows] != list(VISEMES) or table.shape[1:] != (1 + len(lips) * len(OFFSETS),):
        raise EvaluationError(f"{path}: needs a row for each of {', '.join(VISEMES)}; fetch it again")
    return Reader(lips, table[:, 1:], table[:, 0])


def save_reader(reader: Reader, path: Path) -> None:
    """Write a table of weights: a row for each viseme, a column for each curve and offset."""
    columns = [f"{name} {1000 * offset:+.0f} ms" for name in reader.lips for offset in OFFSETS]
    lines = [",".join(["viseme", "bias", *columns])]
    for name, bias, weights in zip(VISEMES, reader.bias, reader.weights, strict=True):
        lines.append(",".join([name, *(f"{round(value, 4) + 0.0:g}" for value in (bias, *weights))]))
    write_text(path, "\n".join(lines) + "\n")


def _mean_over(values: Array, groups: Numbers) -> float:
    return float(np.mean([values[groups == group].mean() for group in np.unique(groups)]))
