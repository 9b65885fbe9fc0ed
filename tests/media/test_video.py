"""Films are read back as they were written; what is no usable film is told in one line."""

from __future__ import annotations

import struct
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from phonanim.errors import CorpusError, MissingExtraError
from phonanim.media.video import (
    frame_rate,
    open_film,
    read_clip,
    read_frames,
    read_sound,
    write_film,
    write_sound,
)

av = pytest.importorskip("av")
TONE = 0.3 * np.sin(2 * np.pi * 440 * np.arange(8000) / 16000).astype(np.float32)


def frames(count: int = 12) -> list[np.ndarray]:
    return [np.full((48, 64, 3), 60 + 10 * n, np.uint8) for n in range(count)]


def test_a_film_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_film(frames(), tmp_path / "a.mp4", Fraction(25), TONE)
    film = open_film(tmp_path / "a.mp4")
    assert (film.rate, film.frames, film.has_sound) == (25, 12, True)
    clip = read_clip(tmp_path / "a.mp4")
    assert clip.shape == (12, 48, 64, 3)
    assert np.abs(clip.astype(int) - np.array(frames())).max() <= 4


def test_the_sound_of_a_film(tmp_path: Path) -> None:
    write_film(frames(), tmp_path / "a.mp4", Fraction(25), TONE)
    samples = read_sound(tmp_path / "a.mp4")
    assert abs(len(samples) - len(TONE)) <= 2048
    spectrum = np.abs(np.fft.rfft(samples))
    assert np.fft.rfftfreq(len(samples), 1 / 16000)[spectrum.argmax()] == pytest.approx(440, abs=3)


def test_sound_is_kept_to_the_bit(tmp_path: Path) -> None:
    soundfile = pytest.importorskip("soundfile")
    write_sound(TONE, tmp_path / "a.flac")
    samples, rate = soundfile.read(tmp_path / "a.flac", dtype="float32")
    assert rate == 16000
    assert np.abs(samples - TONE).max() < 1 / 32000


def test_the_same_film_has_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.mp4", "b.mp4"):
        write_film(frames(), tmp_path / name, Fraction(25), TONE)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def uneven(path: Path) -> None:
    """A film whose second half comes three frames late."""
    with av.open(str(path), "w") as film:
        stream = film.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 25)
        for number, picture in enumerate(frames()):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = number + (3 if number > 6 else 0), Fraction(1, 25)
            film.mux(stream.encode(frame))
        film.mux(stream.encode(None))


def test_an_uneven_rate(tmp_path: Path) -> None:
    uneven(tmp_path / "a.mp4")
    with pytest.raises(
        CorpusError,
        match=r"a\.mp4: its frame rate is not constant .*: ffmpeg -i a\.mp4 -vf fps=2\d a_2\d\.mp4",
    ):
        open_film(tmp_path / "a.mp4")


def test_a_rate_that_the_file_tells_wrongly() -> None:
    """A last frame that stays for long lowers the mean rate, not the rate of the frames."""
    seconds = [Fraction(n, 12) for n in range(105)]
    assert frame_rate(seconds, Fraction(105, 9)) == 12
    assert frame_rate(seconds, Fraction(12)) == 12
    assert frame_rate(seconds, None) == 12


def test_sound_that_begins_after_the_picture(tmp_path: Path) -> None:
    write_film(frames(), tmp_path / "a.mp4", Fraction(25), TONE)
    with av.open(str(tmp_path / "a.mp4")) as source, av.open(str(tmp_path / "b.mp4"), "w") as target:
        copies = [target.add_stream_from_template(stream) for stream in source.streams]
        for packet in source.demux():
            if packet.dts is None:
                continue
            packet.stream = copies[packet.stream.index]
            late = packet.stream.type == "audio"
            packet.pts, packet.dts = packet.pts + 3200 * late, packet.dts + 3200 * late
            target.mux(packet)
    prompt, delayed = (read_sound(tmp_path / name) for name in ("a.mp4", "b.mp4"))
    assert len(delayed) - len(prompt) == pytest.approx(3200, abs=1100)
    assert np.abs(delayed[:2000]).max() == 0
    assert np.abs(delayed[4500:8000]).max() > 0.2


def test_a_film_of_a_turned_telephone_is_upright(tmp_path: Path) -> None:
    corner = np.zeros((48, 64, 3), np.uint8)
    corner[:24, :32] = 255
    write_film([corner] * 3, tmp_path / "a.mp4", Fraction(25))
    data = (tmp_path / "a.mp4").read_bytes()
    header = data.index(b"tkhd")
    straight = struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30)
    clockwise = struct.pack(">9i", 0, 1 << 16, 0, -1 << 16, 0, 0, 48 << 16, 0, 1 << 30)
    turned = data[:header] + data[header:].replace(straight, clockwise, 1)
    (tmp_path / "b.mp4").write_bytes(turned)
    (picture, *_) = read_frames(tmp_path / "b.mp4")
    assert picture.shape == (64, 48, 3)
    assert [int(picture[y, x, 0]) > 128 for y, x in ((8, 8), (8, 40), (56, 8), (56, 40))] == [
        False, True, False, False
    ]  # fmt: skip


def test_one_frame_is_no_recording(tmp_path: Path) -> None:
    write_film(frames(1), tmp_path / "a.mp4", Fraction(25))
    with pytest.raises(CorpusError, match=r"a\.mp4: contains 1 frames; a recording needs at least two"):
        open_film(tmp_path / "a.mp4")


def test_no_sound(tmp_path: Path) -> None:
    write_film(frames(), tmp_path / "a.mp4", Fraction(25))
    assert not open_film(tmp_path / "a.mp4").has_sound
    with pytest.raises(CorpusError, match=r"a\.mp4: has no audio track; the phones are found in the audio"):
        read_sound(tmp_path / "a.mp4")


def test_no_picture(tmp_path: Path) -> None:
    write_sound(TONE, tmp_path / "a.flac")
    with pytest.raises(CorpusError, match=r"a\.flac: contains no picture; give a video of the speaking face"):
        open_film(tmp_path / "a.flac")


def test_no_film_at_all(tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_text("this is no film")
    with pytest.raises(CorpusError, match=r"a\.mp4: cannot be read as a video: "):
        open_film(tmp_path / "a.mp4")
    with pytest.raises(CorpusError, match=r"none\.mp4: cannot be read as a video: "):
        list(read_frames(tmp_path / "none.mp4"))


def test_without_the_library(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(
        MissingExtraError, match=r"videos need the video library: pip install 'phonanim\[video\]'"
    ):
        open_film(tmp_path / "a.mp4")
