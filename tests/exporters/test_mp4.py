import wave
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from animations import line, only

from phonanim.errors import AudioError, MissingExtraError, OutputError, RigError
from phonanim.exporters import save
from phonanim.exporters.mp4 import _film_rate

av = pytest.importorskip("av", reason="needs the extra video")

SMALL = {"size": 96}


def click(path, time=0.5, rate=16000):
    """One second of silence with a click."""
    samples = np.zeros(rate, "<i2")
    samples[round(time * rate) : round(time * rate) + 40] = 20000
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, rate, len(samples), "NONE", ""))
        file.writeframes(samples.tobytes())
    return path


def flash(time=0.5):
    """A line whose jaw falls open at a time."""
    animation = only(line())
    values = animation.values.copy()
    values[round(time * 60) :, animation.channels.index("jawOpen")] = 0.9
    return replace(animation.with_values(values), phones=(), words=())


def pictures(path):
    with av.open(str(path)) as film:
        return [(frame.time, frame.to_ndarray(format="gray")) for frame in film.decode(video=0)]


def sound(path):
    with av.open(str(path)) as film:
        frames = list(film.decode(audio=0))
    samples = np.concatenate([frame.to_ndarray()[0] for frame in frames])
    return samples, frames[0].rate, frames[0].time


def test_picture_and_sound_are_in_step(tmp_path):
    save(replace(flash(), audio=click(tmp_path / "a.wav")), tmp_path / "a.mp4", **SMALL)
    frames = pictures(tmp_path / "a.mp4")
    changes = [np.abs(b.astype(float) - a).mean() for (_, a), (_, b) in pairwise(frames)]
    seen = frames[int(np.argmax(changes)) + 1][0]
    samples, rate, start = sound(tmp_path / "a.mp4")
    sounded = start + np.abs(samples).argmax() / rate
    assert abs(seen - sounded) < 1 / 30
    assert seen == pytest.approx(0.5, abs=1 / 60)


@pytest.mark.parametrize("changes", [{"start": 1e6}, {}])
def test_a_film_has_so_many_pictures_at_most(tmp_path, changes):
    animation = replace(line(), **changes)
    most = {} if changes else {"most_pictures": 10}
    with pytest.raises(
        OutputError, match=r"a\.mp4: would have [\d,]+ pictures, more than (27,000|10) .*cut the"
    ):
        save(animation, tmp_path / "a.mp4", **most)
    assert not list(tmp_path.iterdir())


def test_the_film_has_every_frame_and_no_sound_without_a_recording(tmp_path):
    save(line(), tmp_path / "a.mp4", **SMALL)
    frames = pictures(tmp_path / "a.mp4")
    assert len(frames) == 31
    assert frames[0][1].shape == (96, 96)
    with av.open(str(tmp_path / "a.mp4")) as film:
        assert film.streams.video[0].average_rate == 30
        assert not film.streams.audio


def test_the_same_line_gives_the_same_bytes_on_one_thread(tmp_path):
    films = []
    for name in ("a.mp4", "b.mp4"):
        save(replace(line(), audio=click(tmp_path / "a.wav")), tmp_path / name, **SMALL)
        films.append((tmp_path / name).read_bytes())
    assert films[0] == films[1]
    assert b" threads=1 lookahead_threads=1 " in films[0]  # x264 writes its settings down
    assert b" rc=crf mbtree=0 " in films[0]


NTSC = Fraction(24000, 1001)
RATES = [
    (25, 25),
    (30, 30),
    (60, 30),
    (50, 25),
    (120, 30),
    (float(NTSC), NTSC),
    (float(NTSC * 5 / 2), NTSC * 5 / 4),
]


@pytest.mark.parametrize(("fps", "rate"), RATES)
def test_fast_animations_are_sampled(fps, rate):
    assert _film_rate(fps) == rate


def test_films_that_cannot_be_made(tmp_path):
    with pytest.raises(
        OutputError, match=r"a\.mp4: a video of 101 pixels cannot be made; choose an even size"
    ):
        save(line(), tmp_path / "a.mp4", size=101)
    with pytest.raises(RigError, match=r"the head has none of the channels"):
        save(replace(line(), channels=tuple(f"x{i}" for i in range(52))), tmp_path / "a.mp4")
    (tmp_path / "a.wav").write_bytes(b"no sound")
    with pytest.raises(AudioError, match=r"a\.wav: cannot be decoded"):
        save(replace(line(frames=2), audio=tmp_path / "a.wav"), tmp_path / "a.mp4", **SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["a.wav"]


def test_a_missing_library_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(
        MissingExtraError, match=r"video needs the video library: pip install 'phonanim\[video\]'"
    ):
        save(line(), tmp_path / "a.mp4")
