"""A video of the speaking head, with the sound, as a preview."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.animation.animation import Animation
from phonanim.core.files import atomic_path
from phonanim.errors import AudioError, MissingExtraError, OutputError
from phonanim.exporters._head import RIG as RIG
from phonanim.exporters._head import fits as fits
from phonanim.media.pixels import Image, draw_text
from phonanim.media.video import H264, LOCAL, local_file
from phonanim.rig.head import SHIPPED, Head, load_dressed_head
from phonanim.rig.neck import turned, turns_of
from phonanim.rig.portrait import load_portrait
from phonanim.rig.render import View, render, whole_head
from phonanim.speech.alignment import Interval
from phonanim.speech.labels import is_silent

SUMMARY = "film of the head speaking, H.264 with the sound (needs the extra video)"
FASTEST = 30.0  # frames per second of the film; an animation with more is sampled
MOST_PICTURES = 27_000  # 15 minutes; each takes 25 ms
THREADS = 1  # so that the bytes do not depend on scheduling
SOUND_RATE = 48000  # hertz
INK, FAINT = (236, 238, 242), (170, 176, 186)


def write(
    animation: Animation,
    path: Path,
    character: Path = SHIPPED,
    size: int = 512,
    samples: int = 1,
    yaw: float = -12.0,
    most_pictures: int = MOST_PICTURES,
) -> None:
    """Render the head at `size` x `size` pixels, with words and phones below, and mux the recording.

    `samples` 2 is finer and four times as slow; `yaw` in degrees turns the head. A film of more than
    `most_pictures` is refused. Raises RigError when the head has none of the channels, AudioError when the
    recording cannot be decoded, OutputError for such a film and when the destination cannot be written,
    MissingExtraError without the extra `video`.
    """
    av = library()
    rate = _film_rate(animation.fps)
    if (pictures := _count(animation, rate)) > most_pictures:
        minutes = most_pictures / float(rate) / 60
        raise OutputError(
            f"{path}: would have {pictures:,} pictures, more than {most_pictures:,} ({minutes:.0f} minutes); "
            "cut the line, or give most_pictures in Python"
        )
    if size < 64 or size % 2:
        raise OutputError(f"{path}: a video of {size} pixels cannot be made; choose an even size from 64")
    if character == SHIPPED:
        head = load_dressed_head()
        view = whole_head(head, size, size, yaw)
    else:
        portrait = load_portrait(character, animation.channels, size, size, yaw)
        head, view = portrait.head, portrait.view
    view = replace(view, samples=samples)
    with atomic_path(path) as partial:
        try:
            with av.open(str(partial), "w") as film:
                _mux(av, film, animation, _pictures(animation, head, rate, view), rate, size)
        except av.error.FFmpegError as error:
            raise OSError(error.errno, error.strerror) from error


def library() -> Any:
    """The `av` package. Raises MissingExtraError."""
    try:
        import av
    except ImportError as error:
        raise MissingExtraError("video needs the video library: pip install 'phonanim[video]'") from error
    return av


def _film_rate(fps: float) -> Fraction:
    """The animation's rate, or an integer fraction of it when it is fast."""
    rate = Fraction(fps).limit_denominator(1001)
    return rate / max(1, -(-round(rate) // round(FASTEST)))


def _count(animation: Animation, rate: Fraction) -> int:
    """The number of pictures."""
    return int(float(animation.times[-1]) * rate + 1e-6) + 1


def _pictures(animation: Animation, head: Head, rate: Fraction, view: View) -> Iterator[Image]:
    """One picture per video frame, from time zero to the end of the animation."""
    weights = head.weights(animation.values, animation.channels)
    turns = turns_of(animation.values, animation.channels)
    for time in np.arange(_count(animation, rate)) / float(rate):
        now = _between(time, animation, weights)
        turn = None if turns is None else _between(time, animation, turns)
        picture = render(turned(head.shape(now), head.neck, turn), head, view)
        _caption(picture, animation, float(time))
        yield picture


def _between(time: float, animation: Animation, curves: NDArray[np.float64]) -> NDArray[np.float64]:
    """The values of curves at an instant, (frames, n) -> (n,)."""
    place = int(np.clip((time - animation.start) * animation.fps, 0, len(curves) - 1))
    near = np.arange(max(place - 1, 0), min(place + 3, len(curves)))
    times = animation.start + near / animation.fps
    return np.array([np.interp(time, times, curve) for curve in curves[near].T])


def _caption(picture: Image, animation: Animation, time: float) -> None:
    height, width = picture.shape[:2]
    for intervals, y, color, face in (
        (animation.words, height - 52, INK, "large"),
        (animation.phones, height - 26, FAINT, "small"),
    ):
        draw_text(picture, _label(intervals, time), width / 2, y, color, face, align=0.5)


def _label(intervals: tuple[Interval, ...], time: float) -> str:
    label = next((i.label for i in intervals if i.start <= time < i.end), "")
    return "" if is_silent(label) else label


def _mux(
    av: Any,
    film: Any,
    animation: Animation,
    pictures: Iterator[Image],
    rate: Fraction,
    size: int,
) -> None:
    """Encode pictures and sound into an open video."""
    stream = film.add_stream("libx264", rate=rate, options=H264 | {"crf": "18"})
    stream.width = stream.height = size
    stream.pix_fmt = "yuv420p"
    stream.codec_context.thread_count = THREADS
    sound = film.add_stream("aac", rate=SOUND_RATE, layout="mono") if animation.audio else None
    for picture in pictures:
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
        film.mux(stream.encode(frame.reformat(format="yuv420p")))
    film.mux(stream.encode(None))
    if sound and animation.audio:
        for frame in _sound(av, animation.audio):
            film.mux(sound.encode(frame))
        film.mux(sound.encode(None))


def _sound(av: Any, path: Path) -> Iterator[Any]:
    """Frames of a recording, resampled for the video."""
    resampler = av.AudioResampler(format="fltp", layout="mono", rate=SOUND_RATE)
    try:
        with av.open(local_file(path), options=LOCAL) as recording:
            for frame in recording.decode(audio=0):
                yield from resampler.resample(frame)
            yield from resampler.resample(None)
    except (av.error.FFmpegError, IndexError) as error:
        raise AudioError(f"{path}: cannot be decoded: {error}") from error
