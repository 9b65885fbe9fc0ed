"""Phones in one by one, frames out: the same frames as the whole line gives, and what makes no sense."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from speech import random_track

from phonanim.animation.motion import predict_controls
from phonanim.animation.rates import frame_count
from phonanim.articulation.styles import read_styles
from phonanim.errors import OptionError, StreamError
from phonanim.options import Options, Overlay
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.language import to_phones
from phonanim.stream.engine import PhoneStream

ENGLISH = Options(life=0, language="english")


def spoken(seed: int, segments: int = 60) -> list[Interval]:
    """Phones at random, with pauses."""
    track = random_track(np.random.default_rng(seed), segments)
    names = [INVENTORY.phones[code].upper() for code in track.codes]
    labels = ["sil" if name in ("SIL", "SP") else name for name in names]
    return [Interval(*line) for line in zip(labels, track.bounds[:-1], track.bounds[1:], strict=True)]


MARKED = ("AA", "AE", "AH", "IY", "UW", "EH", "IH", "OW")


def held() -> list[tuple[int, Interval]]:
    """Phones at random, of which every fifth lasts a second."""
    found, end = [], 0.0
    for number, one in enumerate(spoken(5, 40)):
        length = 1.0 if number % 5 == 4 else one.end - one.start
        found.append((number, Interval(one.label, end, end + length)))
        end += length
    return found


LONG = held()


def streamed(intervals: list[Interval], options: Options, look_ahead: float | None) -> PhoneStream:
    stream = PhoneStream(options, look_ahead)
    found = []
    for interval in intervals:
        stream.push(interval.label, interval.start, interval.end)
        found.append(stream.frames())
    stream.end()
    found.append(stream.frames())
    stream.made = np.concatenate(found)  # type: ignore[attr-defined]
    return stream


def whole(intervals: list[Interval], options: Options) -> np.ndarray:
    duration = intervals[-1].end
    track, _ = to_phones(Alignment(tuple(intervals), duration, "phones", "test"), options.language)
    frames = frame_count(duration, options.fps)
    return predict_controls(track, load_model(options.model), load_cached_rig(options.rig), options, frames)[
        1
    ]


def test_stress_rate_and_held_vowels_are_those_of_the_whole_line() -> None:
    options = replace(ENGLISH, **{**read_styles()["sung"], "reduction": 3.0})
    marked = [replace(one, label=f"{one.label}{n % 3}") if one.label in MARKED else one for n, one in LONG]
    found = streamed(marked, options, None).made  # type: ignore[attr-defined]
    expected = whole(marked, options)
    assert np.allclose(found, expected, atol=2e-6)
    assert np.abs(expected - whole(marked, replace(options, reduction=0.0, hold=0.0))).max() > 0.02


@pytest.mark.parametrize("fps", [60.0, 24.0])
@pytest.mark.parametrize("rig", ["arkit", "arkit_tongue", "metahuman", "rhubarb"])
def test_a_stream_gives_what_the_whole_line_gives(rig: str, fps: float) -> None:
    options = Options(life=0, language="english", rig=rig, fps=fps, jaw=1.2)
    intervals = spoken(3)
    found = streamed(intervals, options, None).made  # type: ignore[attr-defined]
    assert np.allclose(found, whole(intervals, options), atol=2e-6)


def test_less_look_ahead_comes_sooner_and_is_less_exact() -> None:
    intervals = spoken(4)
    truth = whole(intervals, ENGLISH)
    errors = []
    for look_ahead in (0.5, 0.2, 0.05):
        stream = PhoneStream(ENGLISH, look_ahead)
        found = []
        for interval in intervals:
            stream.push(interval.label, interval.start, interval.end)
            found.append(stream.frames())
            assert stream.emitted == math.floor((interval.end - look_ahead) * 60 + 1e-6) + 1 or (
                interval.end < look_ahead
            )
        stream.end()
        found.append(stream.frames())
        errors.append(np.sqrt(np.mean((np.concatenate(found) - truth) ** 2)))
    assert errors[0] < errors[1] < errors[2] < 0.1


def test_time_passes_without_phones() -> None:
    """A stream that stalls goes on with a mouth at rest."""
    stream = PhoneStream(ENGLISH, 0.2)
    stream.push("AA1", 0.0, 0.3)
    stream.pass_time(2.0)
    found = stream.frames()
    assert len(found) == 109  # up to 1.8 s
    jaw = stream.rig.controls.index("jawOpen")
    assert found[5, jaw] > 3 * abs(found[-1, jaw])
    assert len(stream.frames()) == 0


def test_memory_stays_flat() -> None:
    stream = streamed(spoken(5, 400), ENGLISH, 0.3)
    assert len(stream.known) < 60


def test_an_empty_stream_has_no_frames() -> None:
    stream = PhoneStream(ENGLISH)
    stream.end()
    assert stream.frames().shape == (0, 55)
    assert stream.notes == ("no phone was received",)


@pytest.mark.parametrize(
    ("phone", "message"),
    [
        (("AA1", 0.1, 0.2), 'phone "AA1" at 0.1 s was sent twice; the second is left out'),
        (("B", 0.15, 0.3), r'phone "B" at 0.15 s begins before the last one ends \(0.2 s\); phones must'),
        (("B", 0.3, 0.3), 'phone "B" from 0.3 to 0.3 s: has no duration; send it again'),
        (("B", math.nan, 0.3), "has no duration"),
        (("B", -1.0, 0.3), "has no duration"),
    ],
)
def test_what_makes_no_sense_is_said_and_left_out(phone: tuple[str, float, float], message: str) -> None:
    stream = PhoneStream(ENGLISH)
    stream.push("AA1", 0.1, 0.2)
    with pytest.raises(StreamError, match=message):
        stream.push(*phone)
    stream.push("B", 0.2, 0.3)
    assert [i.label for i in stream.known] == ["AA1", "B"]


def test_a_phone_that_comes_too_late() -> None:
    stream = PhoneStream(ENGLISH, 0.1)
    stream.pass_time(1.0)
    assert len(stream.frames()) == 55
    with pytest.raises(StreamError, match=r'"B" at 0.5 s arrives after its frames were due; raise the look'):
        stream.push("B", 0.5, 0.6)


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (Options(smooth=0.1), "--smooth"),
        (Options(pitch="praat"), "--pitch praat"),
        (Options(retarget="solve"), "--retarget solve"),
        (Options(overlays=(Overlay("smile.toml"),)), "--overlay"),
    ],
)
def test_layers_that_look_at_a_whole_line(options: Options, name: str) -> None:
    with pytest.raises(OptionError, match=f"{name} needs a whole line and cannot be streamed"):
        PhoneStream(options)
