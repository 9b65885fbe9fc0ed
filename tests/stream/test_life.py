"""Life in a stream is that of the whole line, from phones and from sound."""

from __future__ import annotations

import numpy as np
import pytest
from prosodies import sentences, track_of
from streams import made_up_model

from phonanim.animation.motion import predict_controls
from phonanim.animation.rates import frame_count
from phonanim.inputs.prosody import life_ahead
from phonanim.life import add_life, life_of, mouth_freedom
from phonanim.media.voice import analyze_voice
from phonanim.options import Emotion, Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.speech.alignment import Interval
from phonanim.speech.phones import silent_track
from phonanim.speech.prosody import measure_prosody, read_prosody
from phonanim.stream.engine import PhoneStream
from phonanim.stream.events import Samples
from phonanim.stream.sound import SoundStream

EMOTIONS = (Emotion("joy", 0.5, (2.0, 6.0)), Emotion("sadness", 0.4, (6.0, 9.0)))
NONE = dict.fromkeys(("blinks", "gaze", "head", "brows", "breath"), 0.0)


def in_one(line, options, words=()):
    duration = line[-1].end + 1.0
    track, rig = track_of(line, duration), load_cached_rig(options.rig)
    frames = frame_count(duration, options.fps)
    values = predict_controls(track, load_model(options.model), rig, options, frames)[1]
    times = np.arange(frames) / options.fps
    prosody = read_prosody(track, words)
    free = mouth_freedom(prosody, track, times)
    return add_life(values, rig, life_of(options, "line"), prosody, times, free)


@pytest.mark.parametrize("rig", ["arkit_tongue", "metahuman"])
@pytest.mark.parametrize("most", [None, 1])
def test_of_phones(rig, most):
    options = Options(language="english", rig=rig, fps=30.0, emotions=EMOTIONS)
    line = sentences(14.0)
    words = (Interval("really?", line[3].start, line[6].end),)
    stream = PhoneStream(options, None, "line", words)
    found = []
    for phone in line:
        stream.push(phone.label, phone.start, phone.end)
        while len(frames := stream.frames(most)):
            found.append(frames)
    stream.tick(line[-1].end + 1.0)
    stream.end()
    while len(frames := stream.frames(most)):
        found.append(frames)
    assert len(stream.felt.intervals) < 100
    whole = in_one(line, options, words)
    np.testing.assert_allclose(np.concatenate(found), whole, atol=2e-5)
    assert np.ptp(whole, axis=0).max() > 0.5


@pytest.mark.parametrize("block", [160, 1111])
def test_of_sound(block, tmp_path):
    options = Options(model=str(made_up_model(tmp_path / "cnn", "cnn")), rig="arkit", fps=30.0)
    rate, seconds = 16000, 20.0
    times = np.arange(int(rate * seconds)) / rate
    spoken = (times % 5 > 0.8) & (times % 5 < 4)
    pitch = 120 + 30 * np.sin(2 * np.pi * 0.7 * times)
    sound = np.sign(np.sin(2 * np.pi * np.cumsum(pitch) / rate)) * (1 + np.sin(2 * np.pi * 3.1 * times))
    samples = (0.2 * sound * spoken).astype(np.float32)
    alive, still = (
        streamed(samples, block, Options(model=options.model, fps=30.0, life=life)) for life in ({}, NONE)
    )
    model, rig = load_model(options.model), load_cached_rig("arkit")
    prosody = measure_prosody(analyze_voice(samples, rate), life_ahead(model.regressor))
    assert len(prosody.starts) == 4
    assert len(prosody.accents) > 15
    instants = np.arange(len(still)) / 30.0
    free = mouth_freedom(prosody, silent_track(seconds), instants)
    whole = add_life(still, rig, life_of(options, "line"), prosody, instants, free)
    np.testing.assert_allclose(alive, whole, atol=2e-5)
    assert np.ptp(whole - still, axis=0).max() > 0.5


def streamed(samples, block, options):
    stream = SoundStream(options, 16000, "line")
    found = []
    for begin in range(0, len(samples), block):
        stream.take(Samples(samples[begin : begin + block]))
        found.append(stream.frames())
        assert len(stream.voice.voice.level) < 1300
        assert len(stream.voice.samples) < 16000 or not stream.life
    stream.end()
    return np.concatenate([*found, stream.frames()])


def test_without_life_nothing_is_kept():
    stream = PhoneStream(Options(language="english", life=NONE))
    for phone in sentences(5.0):
        stream.push(phone.label, phone.start, phone.end)
    assert stream.life is None
    assert stream.felt.intervals == []
