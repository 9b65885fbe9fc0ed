"""What a model costs: size, training, speed, memory, and how much of what is still to come it must know."""

from __future__ import annotations

import json
import multiprocessing
import os
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from phonanim import regressors
from phonanim.comparison.fit import Job
from phonanim.corpus.corpus import Corpus
from phonanim.encoders._cache import FOLDER
from phonanim.errors import ModelError
from phonanim.features.context import EDGES
from phonanim.features.indicators import WIDTH
from phonanim.features.inputs import CONTEXT, STEP
from phonanim.media.audio import Sound, read_sound
from phonanim.regressors._procedural_config import REACH
from phonanim.speech.phones import PhoneTrack
from phonanim.training.recipes import predict_clip

SPEED_FRAMES = 4000  # frames that the speed of a model is measured on
RUNS = 5  # of a line, of which the median counts
LINE = "line"  # a model that may look at all of what is said


def frames_per_second(model: regressors.Model, corpus: Corpus, clips: Sequence[int]) -> float:
    """Frames per processor second on some clips, whatever sound it hears read beforehand."""
    predict_clip(model.regressor, corpus, clips[0])  # what is read once is read
    frames, begin = 0, time.process_time()
    for clip in clips:
        frames += len(predict_clip(model.regressor, corpus, clip))
        if frames > SPEED_FRAMES:
            break
    return frames / (time.process_time() - begin)


def line_cost(folder: Path, corpus: Corpus, clip: int) -> dict[str, float]:
    """`line_ms` of the processor and `memory_mb` that a model needs for one clip, in a process of its own.

    From the phones and the samples to the modes of every frame, the encoder included, nothing kept from
    before. Memory is the most that was held beyond the interpreter with NumPy, the model among it.
    """
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        times = corpus.times(clip)
        return pool.submit(_line_cost, folder, corpus.tracks[clip], times, corpus.audio[clip]).result()


def _line_cost(folder: Path, track: PhoneTrack, times: Any, audio: Path) -> dict[str, float]:
    os.environ[FOLDER] = ""
    before = peak_memory()
    model = regressors.load(folder)
    sound = None if model.regressor.input_modality == "phones" else read_sound(audio)
    model.regressor.predict(track, times, sound)
    memory = peak_memory() - before
    taken = [_processor_ms(model, track, times, sound) for _ in range(RUNS)]
    return {"line_ms": round(statistics.median(taken), 2), "memory_mb": round(memory, 1)}


def _processor_ms(model: regressors.Model, track: PhoneTrack, times: Any, sound: Sound | None) -> float:
    begin = time.process_time()
    model.regressor.predict(track, times, sound)
    return 1000 * (time.process_time() - begin)


def peak_memory() -> float:
    """The most memory that this process has held, in MB."""
    status = Path("/proc/self/status")
    if status.is_file():  # what getrusage says on Linux includes that of the process which started this one
        lines = status.read_text(encoding="ascii").splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024
    import resource  # Windows has none

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 1024)


def look_ahead(regressor: regressors.Regressor) -> str:
    """What a frame needs to know beyond its instant: milliseconds, so many phones, or the line.

    For windows and convolutions it is exact; a kind that is not told of here may look at all of a line.
    """
    found = _AHEAD.get(regressors.kind_of(regressor))
    return found(regressor) if found else LINE


def _windows_ahead(regressor: regressors.Regressor) -> str:
    """The window in and half the window out; the timing of context features counts phones as well."""
    config = regressor.config
    beyond = config.width // 2 * STEP
    if config.features in CONTEXT:
        return f"{_ms(beyond + float(EDGES[-1]))} and 3 phones"
    reach = getattr(config, "reach", WIDTH) if config.features == "raw" else WIDTH
    return _ms(beyond + reach // 2 * STEP)


def _steps_ahead(regressor: Any) -> str:
    try:
        return _ms(regressor.look_ahead)
    except ModelError:  # its encoder hears a whole recording
        return LINE


def _ms(seconds: float) -> str:
    return f"{1000 * seconds:.0f}"


_AHEAD: dict[str, Callable[[Any], str]] = {
    "dnn": _windows_ahead,
    "tree": _windows_ahead,
    "cnn": _steps_ahead,
    "tcn": _steps_ahead,
    "phone_mean": lambda regressor: _ms(regressor.config.smoothing / 2),
    "procedural": lambda regressor: f"{REACH} gestures",
}


def training_cost(jobs: Sequence[Job]) -> dict[str, float]:
    """Processor seconds of all trainings of a comparison, of the longest one, and how many there are."""
    seconds = [
        float(json.loads((job.folder / "job.json").read_text(encoding="utf-8"))["seconds"])
        for job in {job.folder: job for job in jobs}.values()
    ]
    return {"jobs": len(seconds), "training_s": sum(seconds), "longest_s": max(seconds, default=0.0)}
