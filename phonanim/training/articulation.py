"""What a training learns of articulation beside the motion itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from phonanim.articulation import CHANNELS, articulate
from phonanim.articulation.from_audio import can_predict_articulation, fit_audio_articulation
from phonanim.corpus.motion import MotionCorpus
from phonanim.metrics import speech_mask
from phonanim.regressors import Examples, Regressor, Tensors
from phonanim.targets.sensors import Sensors


def learn_articulation(regressor: Regressor, recordings: Examples) -> Tensors | None:
    """The articulation that an audio-driven model predicts without phones; None for other models."""
    encoder = getattr(regressor.config, "encoder", "")
    if regressor.input_modality != "audio" or not can_predict_articulation(encoder):
        return None
    clips = zip(recordings.tracks, recordings.times, recordings.sounds, strict=True)
    return fit_audio_articulation(encoder, clips).tensors()


def with_zeros(target: Sensors, corpus: MotionCorpus, clips: Iterable[int]) -> Sensors:
    """The target with the zeros of its channels: in speech, their means are those of the phone targets.

    Sensors sit where they were glued, so that only differences are known of them.
    """
    apart: dict[str, list[np.ndarray]] = {}
    for clip in map(int, clips):
        one, times = corpus.clips[clip], corpus.times(clip)
        said = speech_mask(one.track, times)
        if not said.any():
            continue
        rows = target.encode(corpus.frames(clip), corpus.rest(clip))
        wanted = articulate(one.track, times).values
        for name, curve in replace(target, zeros={}).channels(target.decode(rows)).items():
            apart.setdefault(name, []).append((wanted[:, CHANNELS.index(name)] - curve)[said])
    zeros = {name: round(float(np.concatenate(parts).mean()), 3) for name, parts in apart.items()}
    return replace(target, zeros=zeros)
