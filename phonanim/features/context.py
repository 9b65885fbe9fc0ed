"""Continuous-time context: the phones around an instant, independent of the frame rate.

Phones in frame windows give the symbol of each frame. These features instead average numbers that describe
articulation over boxes of time around the instant, narrow near it and wide far away, and add the timing of
the current segment. They change smoothly over time, mean the same at any frame rate, and generalize to
words, phones and speakers that are not in the recordings.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from phonanim.speech.gestures import GESTURES, split_parts
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack

Array = NDArray[np.float64]

# Box edges in seconds: 40 ms at the instant, wider with distance, about like the memory of ear and lips.
_HALF = (0.02, 0.05, 0.08, 0.12, 0.17, 0.24, 0.34, 0.5, 0.8)
EDGES = np.array([-edge for edge in reversed(_HALF)] + list(_HALF))
N_BOXES = len(EDGES) - 1
N_TIMING = 12  # columns of `segment_timing`
LONGEST = 0.5  # seconds; longer segments count as this long
FAR = 10.0  # seconds of silence before the start and after the end, so that the cut of a file has no effect
BLOCK = 32  # instants per block, so that their data fit in the cache
SILENT = INVENTORY.code(SILENCE)
DECAYS = (0.04, 0.12)  # seconds


@cache
def part_table(kind: str = "all") -> NDArray[np.float32]:
    """Numbers of each gesture part, (parts, columns).

    "gestures": the articulation of the part; "classes": the attribute classes (Taylor 2017, supplement
    Table 1) of its phone, without equal and empty columns; "all": both.
    """
    gestures = GESTURES.articulation[GESTURES.part_gesture]
    columns = INVENTORY.attributes[GESTURES.part_phone].astype(np.float32).T
    # As np.unique does it, which imports numpy.ma for it.
    classes = np.array(sorted({tuple(column) for column in columns.tolist()}), np.float32).T
    classes = classes[:, classes.std(axis=0) > 0]
    return {"gestures": gestures, "classes": classes, "all": np.hstack([gestures, classes])}[kind]


def context_features(track: PhoneTrack, times: Array, kind: str = "all") -> NDArray[np.float32]:
    """Box averages and segment timing at instants, (times,) seconds -> (times, features).

    Columns: box by box (17), each with the columns of `part_table(kind)`; then the 12 of `segment_timing`.
    """
    table = part_table(kind)
    local = crop_track(track, times)
    parts = split_parts(local)
    bounds, rows = parts.bounds, table[parts.parts].astype(np.float64)
    running = np.concatenate(
        [np.zeros((1, table.shape[1])), np.cumsum(rows * np.diff(bounds)[:, None], axis=0)]
    )
    features = np.empty((len(times), N_BOXES * table.shape[1] + N_TIMING), np.float32)
    for start in range(0, len(times), BLOCK):
        near = times[start : start + BLOCK, None] + EDGES
        boxes = _box_means(near, bounds, rows, running)
        features[start : start + BLOCK, :-N_TIMING] = boxes.reshape(len(near), -1)
    features[:, -N_TIMING:] = segment_timing(local, times)
    return features


def _box_means(edges: Array, bounds: Array, rows: Array, running: Array) -> Array:
    """Means between neighbouring edges, (times, edges) seconds -> (times, edges - 1, columns).

    `rows` (segments, columns) last from `bounds` to `bounds`; `running` is their integral up to each bound.
    """
    asked = edges.ravel()
    segment = np.clip(np.searchsorted(bounds, asked, side="right") - 1, 0, len(rows) - 1)
    integral = rows.take(segment, axis=0)
    integral *= (asked - bounds[segment])[:, None]
    integral += running.take(segment, axis=0)
    integral = integral.reshape(*edges.shape, -1)
    means: Array = integral[:, 1:] - integral[:, :-1]
    means /= np.diff(EDGES)[:, None]
    return means


def crop_track(track: PhoneTrack, times: Array) -> PhoneTrack:
    """The segments that affect instants (times,), so that the cost per frame does not grow with the track."""
    track = with_silence_beyond(track)
    if len(times) == 0:
        return track
    ends = np.array([times.min() + EDGES[0], times.max() + EDGES[-1]])
    first, last = track.segment_at(ends) + np.array([-2, 3])  # the timing uses two segments further
    kept = slice(max(int(first), 0), int(last))
    stop = min(kept.stop, len(track.codes))
    return PhoneTrack(track.codes[kept], track.bounds[kept.start : stop + 1], track.labels[kept])


def with_silence_beyond(track: PhoneTrack) -> PhoneTrack:
    """A track whose silence at either end is extended by FAR seconds, or added if there is none.

    Its `bounds` begin before 0 s and end after the duration of the given track.
    """
    before, after = (int(code != SILENT) for code in track.codes[[0, -1]])
    silence = np.array([SILENT], np.uint8)
    inner = track.bounds[1 - before : len(track.codes) + after]
    return PhoneTrack(
        np.concatenate([silence[:before], track.codes, silence[:after]]),
        np.concatenate([track.bounds[:1] - FAR, inner, track.bounds[-1:] + FAR]),
        ("",) * before + track.labels + ("",) * after,
    )


def segment_timing(track: PhoneTrack, times: Array) -> Array:
    """Position of an instant in its phone and durations of the phones around it, (times,) -> (times, 12)."""
    lengths = np.minimum(np.diff(track.bounds), LONGEST)
    segment = track.segment_at(times)
    since, until = times - track.bounds[segment], track.bounds[segment + 1] - times
    share = since / (since + until)
    neighbours = [lengths[np.clip(segment + k, 0, len(lengths) - 1)] for k in (0, -1, 1, -2, 2)]
    memories = [np.exp(-np.maximum(side, 0) / decay) for decay in DECAYS for side in (since, until)]
    return np.stack(
        [np.minimum(since, LONGEST), np.minimum(until, LONGEST), share, *neighbours, *memories], axis=1
    )
