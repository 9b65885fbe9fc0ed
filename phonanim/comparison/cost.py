"""The cost of a model: size, training, speed, memory and look-ahead."""

from __future__ import annotations

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
from phonanim.comparison.fit import Job, read_job
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

SPEED_FRAMES = 4000  # frames on which the speed of a model is measured
RUNS = 5  # of a line; the median is used
LINE = "line"  # a model that may use the whole line


def frames_per_second(model: regressors.Model, corpus: Corpus, clips: Sequence[int]) -> float:
    """Frames per processor second on some clips, with their audio read beforehand."""
    predict_clip(model.regressor, corpus, clips[0])  # fills the caches
    frames, begin = 0, time.process_time()
    for clip in clips:
        frames += len(predict_clip(model.regressor, corpus, clip))
        if frames > SPEED_FRAMES:
            break
    return frames / (time.process_time() - begin)


def line_cost(folder: Path, corpus: Corpus, clip: int) -> dict[str, float]:
    """Processor time `line_ms` and memory `memory_mb` that a model needs for one clip, in a new process.

    From the phones and the samples to the modes of every frame, with the encoder and without a cache. Memory
    is the peak use, including the model, beyond that of the interpreter with NumPy.
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
    """The peak memory of this process, in MB."""
    status = Path("/proc/self/status")
    if status.is_file():  # on Linux, getrusage includes the parent process
        lines = status.read_text(encoding="ascii").splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024
    import resource  # not on Windows

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 1024)


def look_ahead(regressor: regressors.Regressor) -> str:
    """Look-ahead of a frame: milliseconds, a number of phones, or the line.

    It is exact for windows and convolutions; a kind that is not listed here may use the whole line.
    """
    found = _AHEAD.get(regressors.kind_of(regressor))
    return found(regressor) if found else LINE


def _windows_ahead(regressor: regressors.Regressor) -> str:
    """The input window plus half of the output window; the timing of context features counts phones too."""
    config = regressor.config
    beyond = config.width // 2 * STEP
    if config.features in CONTEXT:
        return f"{_ms(beyond + float(EDGES[-1]))} and 3 phones"
    return _ms(beyond + getattr(config, "reach", WIDTH) // 2 * STEP)


def _steps_ahead(regressor: Any) -> str:
    try:
        return _ms(regressor.look_ahead)
    except ModelError:  # its encoder needs a whole recording
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
    """Processor seconds of all trainings of a comparison, of the longest one, and their number."""
    seconds = [float(read_job(job.folder)["seconds"]) for job in {job.folder: job for job in jobs}.values()]
    return {"jobs": len(seconds), "training_s": sum(seconds), "longest_s": max(seconds, default=0.0)}
