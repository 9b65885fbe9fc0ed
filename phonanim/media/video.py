"""Videos: their frames as arrays, their rate, their sound."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.files import atomic_path
from phonanim.errors import CorpusError, MissingExtraError

Frame = NDArray[np.uint8]

RATE_TOLERANCE = 0.5  # of a frame: largest distance of an instant from the even grid
SOUND_RATE = 16000  # hertz
H264 = {"preset": "veryfast", "tune": "zerolatency"}  # with look-ahead, x264 output differs between runs
BLOCK = 4096  # samples that are encoded at a time
# Playlists, which name further files, are none of these; nothing is fetched from anywhere.
LOCAL = {
    "protocol_whitelist": "file",
    "format_whitelist": "wav,flac,ogg,mp3,aac,aiff,mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts",
}
THREADS = 2  # a fixed number, so that the bytes do not depend on the machine


@dataclass(frozen=True)
class Film:
    """The properties of a video before decoding; `rate` is in frames per second."""

    path: Path
    rate: Fraction
    frames: int
    has_sound: bool


def open_film(path: Path) -> Film:
    """Open a video. Raises CorpusError when it cannot be read or its frame rate is not constant."""
    with _opened(path) as (_, stream):
        instants = sorted(_shown(stream.container.demux(stream)))
        declared, step = stream.average_rate, Fraction(stream.time_base)
        has_sound = bool(stream.container.streams.audio)
    if len(instants) < 2 or instants[-1] == instants[0]:
        raise CorpusError(f"{path}: contains {len(instants)} frames; a recording needs at least two")
    seconds = [(pts - instants[0]) * step for pts in instants]
    rate = frame_rate(seconds, declared)
    worst, off = _worst(seconds, rate)
    if abs(off) > RATE_TOLERANCE:
        raise CorpusError(
            f"{path}: its frame rate is not constant (frame {worst} is {off:+.1f} frames off the even "
            f"grid); {conversion_hint(path, round(rate))}"
        )
    return Film(path, rate, len(instants), has_sound)


def conversion_hint(path: Path, rate: Fraction | int) -> str:
    """The command that converts a video to another rate."""
    return f"convert it: ffmpeg -i {path.name} -vf fps={rate} {path.stem}_{float(rate):.0f}.mp4"


def _shown(packets: Iterable[Any]) -> Iterator[int]:
    """The instants of the frames that an edit list of the file does not cut away."""
    return (packet.pts for packet in packets if packet.pts is not None and not packet.is_discard)


def frame_rate(seconds: Sequence[Fraction], declared: Fraction | None) -> Fraction:
    """The rate that the file declares, or the rate of its instants (from 0), whichever fits these better.

    The declared rate may include a pause at the end of the video.
    """
    seen = (len(seconds) - 1) / seconds[-1]
    return min((declared or seen, seen), key=lambda rate: abs(_worst(seconds, rate)[1]))


def _worst(seconds: Sequence[Fraction], rate: Fraction) -> tuple[int, float]:
    """The frame that is farthest from the even grid of a rate, and its lateness in frames."""
    off = np.array(seconds, float) * float(rate) - np.arange(len(seconds))
    worst = int(np.abs(off).argmax())
    return worst, float(off[worst])


def read_frames(path: Path) -> Iterator[Frame]:
    """The frames of a video in order, (rows, columns, 3) sRGB, upright. Raises CorpusError."""
    with _opened(path) as (av, stream):
        stream.thread_type = "AUTO"
        try:
            for frame in stream.container.decode(stream):
                # a phone that is held upright stores pictures in landscape, with their rotation as metadata
                yield np.rot90(frame.to_ndarray(format="rgb24"), round(frame.rotation / 90))
        except av.error.FFmpegError as error:
            raise CorpusError(f"{path}: cannot be decoded: {error.strerror}; convert it to MP4") from error


def read_clip(path: Path) -> Frame:
    """All frames of a short video, (frames, rows, columns, 3) sRGB. Raises CorpusError."""
    return np.stack(list(read_frames(path)))


def read_sound(path: Path) -> NDArray[np.float32]:
    """The audio of a video from its first picture on, (samples,) mono at 16 kHz. Raises CorpusError."""
    av = library()
    resampler = av.AudioResampler(format="flt", layout="mono", rate=SOUND_RATE)
    with _opened(path) as (_, stream):
        frames = list(stream.container.decode(audio=0)) if stream.container.streams.audio else []
        if not frames:
            raise CorpusError(f"{path}: has no audio track; the phones are found in the audio")
        pieces = [piece.to_ndarray()[0] for frame in [*frames, None] for piece in resampler.resample(frame)]
        late = (frames[0].time or 0.0) - float((stream.start_time or 0) * stream.time_base)
    samples = np.concatenate(pieces).astype(np.float32)
    start = round(late * SOUND_RATE)
    return np.concatenate([np.zeros(max(start, 0), np.float32), samples[max(-start, 0) :]])


def write_film(
    frames: Iterable[Frame],
    path: Path,
    rate: Fraction,
    sound: NDArray[np.float32] | None = None,
    quality: int = 16,
) -> None:
    """Write frames (rows, columns, 3) as H.264 and audio (samples,) at 16 kHz as AAC.

    Rows and columns must be even. A lower `quality` number is finer. Raises OutputError.
    """
    av = library()
    with atomic_path(path) as partial, av.open(str(partial), "w") as film:
        stream = film.add_stream("libx264", rate=rate, options=H264 | {"crf": str(quality)})
        stream.pix_fmt = "yuv420p"
        stream.codec_context.thread_count = THREADS
        track = None if sound is None else film.add_stream("aac", rate=SOUND_RATE, layout="mono")
        for number, frame in enumerate(frames):
            if number == 0:
                stream.height, stream.width = frame.shape[:2]
            picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
            film.mux(stream.encode(picture.reformat(format="yuv420p")))
        film.mux(stream.encode(None))
        if track is not None and sound is not None:
            _encode_sound(film, track, sound.astype(np.float32)[None], "fltp")


def write_sound(samples: NDArray[np.float32], path: Path) -> None:
    """Write mono audio at 16 kHz, (samples,) in -1..1, as FLAC. Raises OutputError."""
    pcm = np.rint(np.clip(samples, -1, 1) * 32767).astype(np.int16)[None]
    with atomic_path(path) as partial, library().open(str(partial), "w") as file:
        _encode_sound(file, file.add_stream("flac", rate=SOUND_RATE, layout="mono", format="s16"), pcm, "s16")


def _encode_sound(file: Any, stream: Any, samples: NDArray[Any], kind: str) -> None:
    for start in range(0, samples.shape[1], BLOCK):
        piece = np.ascontiguousarray(samples[:, start : start + BLOCK])
        frame = library().AudioFrame.from_ndarray(piece, format=kind, layout="mono")
        frame.rate, frame.pts = SOUND_RATE, start
        file.mux(stream.encode(frame))
    file.mux(stream.encode(None))


def local_file(path: Path) -> str:
    """The address of a file, whatever its name looks like."""
    return f"file:{path.absolute()}"


def library() -> Any:
    """The `av` package. Raises MissingExtraError."""
    try:
        import av
    except ImportError as error:
        raise MissingExtraError("videos need the video library: pip install 'phonanim[video]'") from error
    return av


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Any, Any]]:
    av = library()
    try:
        with av.open(local_file(path), options=LOCAL) as container:
            if not container.streams.video:
                raise CorpusError(f"{path}: contains no picture; give a video of the speaking face")
            yield av, container.streams.video[0]
    except (av.error.FFmpegError, OSError) as error:
        raise CorpusError(f"{path}: cannot be read as a video: {error.strerror}") from error
