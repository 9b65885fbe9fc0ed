"""What articulation is fitted to: channels of sensors, and of the recorded lips."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.blend import lip_channels
from phonanim.articulation.fitting import Observation
from phonanim.corpus.corpus import load_corpus
from phonanim.ema.channels import Recording
from phonanim.face.fit import fit_face
from phonanim.metrics import speech_mask

Array = NDArray[np.float64]
CLIPS = 200  # of the training clips; more changes nothing
SHARE = 0.15  # of what a frame of articulography counts: one quiet speaker who says 51 words
# What is taken from the recorded lips. Their gap is this speaker's, who spells letters (IY as open as AA),
# and a single camera hardly sees protrusion; both reach a blend by the learned face.
FILMED = ("lip_width", "upper_lip")
STEP = 0.01  # seconds between frames that a fit sees


def observations(recordings: list[Recording], channel: str) -> list[Observation]:
    """The speech of all recordings that have a channel."""
    found = []
    for one in recordings:
        if channel in one.curves:
            spacing = float(np.diff(one.times).mean())
            every = max(round(STEP / spacing), 1)
            rows = np.flatnonzero(one.speech)[::every]
            found.append(
                Observation(
                    one.speaker, one.name, one.track, one.times[rows], one.curves[channel][rows],
                    every * spacing, one.in_mm,
                )
            )  # fmt: skip
    return found


@lru_cache(maxsize=1)
def lips(corpus: Path) -> list[tuple[int, dict[str, Array]]]:
    """Channels of the recorded lips in training clips, by clip."""
    stored = load_corpus(corpus)
    clips = stored.clips_of("train")
    face = fit_face(stored.landmarks[stored.rows(clips)], stored.indices)
    shapes = {int(clip): stored.landmarks[stored.rows([clip])].astype(np.float64) for clip in clips[:CLIPS]}
    return [(clip, lip_channels(one, face)) for clip, one in shapes.items()]


def lip_observations(corpus: Path, channel: str) -> list[Observation]:
    """The speech of training clips, if the channel is taken from them."""
    if channel not in FILMED:
        return []
    stored, found = load_corpus(corpus), []
    for clip, channels in lips(corpus):
        times, track = stored.times(clip), stored.tracks[clip]
        said = speech_mask(track, times)
        values = channels[channel][said]
        found.append(
            Observation("camera", stored.clips[clip], track, times[said], values, 1 / stored.fps, True, SHARE)
        )
    return found
