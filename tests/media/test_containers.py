"""The sound of M4A, AAC and films."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from phonanim.errors import AudioError, MissingExtraError
from phonanim.media.audio import audio_duration, find_audio, level, read_audio

RATE = 48000


def write(path: Path, codec: str, samples: np.ndarray, late: float = 0.0) -> None:
    """A file with a track of sound; with `late`, a film whose sound begins so many seconds later."""
    av = pytest.importorskip("av", reason="needs the extra video")
    with av.open(str(path), "w") as film:
        pictures = film.add_stream("libx264", rate=25) if late else None
        track = film.add_stream(codec, rate=RATE, layout="mono")
        if pictures is not None:
            pictures.width = pictures.height = 32
            for _ in range(50):
                film.mux(pictures.encode(av.VideoFrame.from_ndarray(np.zeros((32, 32, 3), np.uint8))))
            film.mux(pictures.encode(None))
        for begin in range(0, len(samples), 960):
            part = (32767 * samples[begin : begin + 960]).astype("<i2")[None]
            frame = av.AudioFrame.from_ndarray(part, format="s16", layout="mono")
            frame.rate, frame.pts = RATE, begin + round(late * RATE)
            film.mux(track.encode(frame))
        film.mux(track.encode(None))


def click() -> np.ndarray:
    """A second of silence with a short tone at 0.5 s."""
    samples = np.zeros(RATE)
    samples[RATE // 2 :][:2400] = np.sin(2 * np.pi * 440 * np.arange(2400) / RATE)
    return samples


def onset(path: Path) -> float:
    samples, rate = read_audio(path)
    return float(np.argmax(np.abs(samples) > 0.2)) / rate


@pytest.mark.parametrize(
    ("name", "codec"), [("a.m4a", "aac"), ("a.mp4", "aac"), ("a.aac", "aac"), ("a.webm", "libopus")]
)
def test_sound_is_where_it_was(name: str, codec: str, tmp_path: Path) -> None:
    write(tmp_path / name, codec, click())
    assert onset(tmp_path / name) == pytest.approx(0.5, abs=0.03)
    assert audio_duration(tmp_path / name) == pytest.approx(1.0, abs=0.06)


def test_sound_that_begins_after_the_pictures(tmp_path: Path) -> None:
    write(tmp_path / "a.mp4", "aac", click(), late=0.4)
    assert onset(tmp_path / "a.mp4") == pytest.approx(0.9, abs=0.03)


def test_films_are_no_recordings_of_an_alignment(tmp_path: Path) -> None:
    """They may be outputs of that name."""
    for name in ("a.mp4", "b.m4a"):
        (tmp_path / name).touch()
    assert find_audio(tmp_path / "a.TextGrid") is None
    assert find_audio(tmp_path / "b.TextGrid") == tmp_path / "b.m4a"
    assert find_audio(tmp_path / "a.mp4") == tmp_path / "a.mp4"


def test_what_is_no_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("av", reason="needs the extra video")
    path = tmp_path / "a.m4a"
    path.write_bytes(b"no sound" * 100)
    with pytest.raises(AudioError, match=r"a\.m4a: is not a readable recording: .*; export it again"):
        read_audio(path)
    with pytest.raises(AudioError, match="is not a readable recording"):
        audio_duration(path)
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(MissingExtraError, match=r"a\.m4a: reading the sound of \.m4a needs pip install"):
        read_audio(path)


def test_a_film_without_sound(tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="needs the extra video")
    with av.open(str(tmp_path / "a.mp4"), "w") as film:
        pictures = film.add_stream("libx264", rate=25)
        pictures.width = pictures.height = 32
        film.mux(pictures.encode(av.VideoFrame.from_ndarray(np.zeros((32, 32, 3), np.uint8))))
        film.mux(pictures.encode(None))
    with pytest.raises(AudioError, match=r"a\.mp4: has no sound; give the recording that belongs to it"):
        read_audio(tmp_path / "a.mp4")


def test_offsets_and_quiet_sound() -> None:
    tone = np.sin(np.arange(4000) / 9).astype(np.float32)
    np.testing.assert_array_equal(level(0.3 * tone), 0.3 * tone)
    assert abs(level(0.3 * tone + np.float32(0.3)).mean()) < 1e-6
    assert np.abs(level(0.002 * tone)).max() == pytest.approx(0.25)
    np.testing.assert_array_equal(level(np.zeros(10, np.float32)), np.zeros(10))
    assert len(level(np.zeros(0, np.float32))) == 0
