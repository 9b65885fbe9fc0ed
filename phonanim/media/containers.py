"""The sound of files that libsndfile does not read: AAC, M4A, and films (MP4, MOV, WebM, MKV), by FFmpeg."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.errors import AudioError, MissingExtraError

COMPRESSED = (".m4a", ".aac", ".wma")
FILMS = (".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi")
CONTAINERS = (*COMPRESSED, *FILMS)
LOCAL = {
    "protocol_whitelist": "file",
    "format_whitelist": "aac,asf,mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi",
}
"""Playlists, which name further files, are none of these; nothing is fetched from anywhere."""


def container_rate(path: Path) -> int:
    """Samples per second of the sound of a file. Raises AudioError, MissingExtraError."""
    with _opened(path) as (_, stream):
        return int(stream.rate)


def container_blocks(path: Path, size: int) -> Iterator[NDArray[np.float32]]:
    """The mono samples in blocks of about `size`, (n,) each; silent until the sound of a film begins.

    Raises AudioError, MissingExtraError.
    """
    with _opened(path) as (av, stream):
        resampler = av.AudioResampler(format="fltp", layout=stream.layout, rate=stream.rate)
        held: list[NDArray[np.float32]] = []
        count = 0
        for frame in _frames(av, stream):
            if count == 0 and not held and frame is not None:
                held.append(np.zeros(_lateness(frame, stream), np.float32))
            for piece in resampler.resample(frame):
                held.append(piece.to_ndarray().mean(axis=0).astype(np.float32))
                count += len(held[-1])
            if count >= size:
                yield np.concatenate(held)
                held, count = [np.zeros(0, np.float32)], 0
        if held and count:
            yield np.concatenate(held)


def _frames(av: Any, stream: Any) -> Iterator[Any]:
    """The frames of sound, and None at the end; packets that are damaged are passed over."""
    for packet in stream.container.demux(stream):
        try:
            yield from packet.decode()
        except av.error.InvalidDataError:
            continue
    yield None


def _lateness(frame: Any, stream: Any) -> int:
    """Samples between the begin of the pictures and of the sound."""
    pictures = stream.container.streams.video
    first = (pictures[0].start_time or 0) * pictures[0].time_base if pictures else 0
    return max(round(((frame.time or 0.0) - float(first)) * stream.rate), 0) if pictures else 0


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Any, Any]]:
    try:
        import av
    except ImportError as error:
        needed = "pip install 'phonanim[video]', or a WAV file"
        raise MissingExtraError(f"{path}: reading the sound of {path.suffix} needs {needed}") from error
    try:
        with av.open(f"file:{path.absolute()}", options=LOCAL) as container:
            if not container.streams.audio:
                raise AudioError(f"{path}: has no sound; give the recording that belongs to it")
            yield av, container.streams.audio[0]
    except (av.error.FFmpegError, OSError) as error:
        raise AudioError(f"{path}: is not a readable recording: {error.strerror}; export it again") from error
