"""The document of a corpus (corpus.json), checked against its landmarks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import (
    DecodeError,
    decode_list,
    decode_number,
    decode_part,
    decode_rate,
    decode_table,
    decode_text,
    decode_whole,
)
from phonanim.speech.alignment import Interval
from phonanim.speech.inventory import N_PHONES
from phonanim.speech.phones import PhoneTrack


def decode_corpus(document: Any, arrays: Mapping[str, NDArray[Any]], folder: Path) -> dict[str, Any]:
    """The fields of a corpus, by name. Raises the exceptions of DAMAGE where the parts do not fit."""
    clips = [decode_table(clip, "a clip") for clip in decode_list(document["clips"], "clips")]
    landmarks, indices = arrays["landmarks"], arrays["indices"]
    frames = [decode_whole(clip["frames"], "frames", 0, len(landmarks)) for clip in clips]
    if landmarks.shape != (sum(frames), len(indices), 3):
        raise DecodeError(f"it has landmarks of {landmarks.shape} for {sum(frames)} frames")
    if not np.isfinite(landmarks).all():
        raise DecodeError("it has landmarks that are not finite")
    return {
        "landmarks": landmarks,
        "indices": indices,
        "fps": decode_rate(document["fps"]),
        "clips": tuple(decode_part(clip["clip"], "clip") for clip in clips),
        "frames": np.array(frames, np.int64),
        "tracks": tuple(map(decode_track, clips)),
        "words": tuple(tuple(map(decode_word, decode_list(clip["words"], "words"))) for clip in clips),
        "split": tuple(decode_text(clip["split"], "split") for clip in clips),
        "audio": tuple(folder / decode_text(clip["audio"], "audio") for clip in clips),
        "provenance": decode_table(document["provenance"], "provenance"),
    }


def decode_track(clip: Mapping[str, Any]) -> PhoneTrack:
    """The phones of a clip. Raises the exceptions of DAMAGE."""
    codes = [decode_whole(code, "a phone", 0, N_PHONES - 1) for code in clip["codes"]]
    bounds = np.array([decode_number(bound, "a bound") for bound in clip["bounds"]])
    labels = tuple(decode_text(label, "a label") for label in clip["labels"])
    if not len(codes) == len(labels) == len(bounds) - 1 > 0 or not (np.diff(bounds) > 0).all():
        raise DecodeError(f"clip {clip['clip']}: its phones do not follow each other")
    return PhoneTrack(np.array(codes, np.uint8), bounds, labels)


def decode_word(word: Any) -> Interval:
    """A word of a clip. Raises the exceptions of DAMAGE."""
    label, start, end = word
    return Interval(decode_text(label, "a word"), decode_number(start, "start"), decode_number(end, "end"))
