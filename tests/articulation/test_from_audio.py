"""Articulation from sound: learned from phones, used without them, and only where it can be used."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import track_of

from phonanim import regressors
from phonanim.animation.motion import predict_controls
from phonanim.articulation import CHANNELS, articulate
from phonanim.articulation.from_audio import (
    AudioArticulation,
    can_predict_articulation,
    fit_audio_articulation,
)
from phonanim.encoders import HOP, RATE
from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.metrics import correlation, speech_mask
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.regressors import Examples, make_config
from phonanim.speech.phones import PhoneTrack, silent_track
from phonanim.training import recipes


def babble(seed: int) -> PhoneTrack:
    """Four phones in any order, each a tone of its own in `sound_of`."""
    rng = np.random.default_rng(seed)
    return track_of(
        "sil 0.3 " + "".join(f"{p} 0.15 " for p in rng.choice(["m", "aa", "s", "uw"], 20)) + "sil 0.3"
    )


def tones(track: PhoneTrack) -> Sound:
    """A recording in which every phone is a tone of its own, and silence is silent."""
    codes = track.sample(np.arange(round(track.duration * RATE)) / RATE).astype(int)
    phase = 2 * np.pi * np.cumsum((100 + 90 * codes) / RATE)
    return Sound(np.where(codes > 0, 0.3 * np.sin(phase), 0).astype(np.float32), RATE)


class Bands:
    """An encoder of which tone sounds."""

    layers, dims, identity, start, window, margin = 1, 41, "bands", 0.0, 30, 1

    def run(self, samples: np.ndarray) -> np.ndarray:
        steps = samples.reshape(-1, HOP) * np.hanning(HOP)
        pitches = 100 + 90 * np.arange(self.dims)
        waves = np.exp(2j * np.pi * pitches[:, None] * np.arange(HOP) / RATE)
        return np.abs(steps @ waves.T)[:, None].astype(np.float32) / 20


@pytest.fixture(scope="module", autouse=True)
def bands() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("phonanim.articulation.from_audio._encoder", lambda name: Bands())
        yield


TRACK = babble(0)
TIMES = np.arange(0, TRACK.duration, 1 / 60)


class Still:
    """An audio-driven model of a face that never moves."""

    input_modality = "audio"
    config: Any = None

    def predict(self, track: PhoneTrack, times: np.ndarray, sound: Sound | None = None) -> np.ndarray:
        return np.zeros((len(times), 14), np.float32)


@pytest.fixture(scope="module")
def learned(bands: None) -> AudioArticulation:
    tracks = [babble(seed) for seed in range(1, 13)]
    clips = ((track, np.arange(0, track.duration, 0.04), tones(track)) for track in tracks)
    return fit_audio_articulation("bands", clips)


def test_sound_tells_what_phones_would(learned: AudioArticulation) -> None:
    values, silent, _ = learned.at(tones(TRACK), TIMES)
    wanted, said = articulate(TRACK, TIMES).values, speech_mask(TRACK, TIMES)
    for name in ("jaw", "lip_gap", "lip_width", "protrusion"):
        place = CHANNELS.index(name)
        assert correlation(values[said, place], wanted[said, place]) > 0.8, name
    assert silent[0] > 0.5 > silent[len(silent) // 2]


def test_a_frame_does_not_depend_on_the_others(learned: AudioArticulation) -> None:
    whole, part = learned.at(tones(TRACK), TIMES)[0], learned.at(tones(TRACK), TIMES[50:60])[0]
    assert whole[50:60] == pytest.approx(part, abs=1e-3)


def test_the_jaw_of_an_audio_driven_model_comes_from_sound(learned: AudioArticulation) -> None:
    still = replace(load_model("default"), regressor=Still())
    model, rig, sound = (
        replace(still, articulation=learned.tensors()),
        load_cached_rig("arkit"),
        tones(TRACK),
    )
    silence = silent_track(sound.duration)
    motion = predict_controls(silence, model, rig, Options(), len(TIMES), sound=sound)
    assert motion.articulation is not None
    jaw = motion.values[:, rig.controls.index("jawOpen")]
    assert correlation(jaw, articulate(TRACK, TIMES).channel("jaw")) > 0.8
    assert predict_controls(silence, still, rig, Options(), len(TIMES), sound=sound).articulation is None
    poses = predict_controls(silence, model, rig, Options(retarget="poses"), len(TIMES), sound=sound)
    shapes = predict_controls(silence, model, load_cached_rig("oculus15"), Options(), len(TIMES), sound=sound)
    assert poses.articulation is None
    assert shapes.articulation is None  # chosen by phones


def test_it_is_kept_in_the_folder_of_the_model(learned: AudioArticulation, tmp_path: Path) -> None:
    regressors.save(replace(load_model("default"), articulation=learned.tensors()), tmp_path)
    kept = AudioArticulation.from_tensors(regressors.load(tmp_path).articulation or {})
    assert kept.encoder == "bands"
    assert np.array_equal(kept.weights, learned.weights)


def test_training_fits_it_for_audio_driven_models_of_whole_recordings(learned: AudioArticulation) -> None:
    tracks = tuple(babble(seed) for seed in range(1, 13))
    times = tuple(np.arange(0, track.duration, 0.04) for track in tracks)
    targets = tuple(np.zeros((len(at), 14), np.float32) for at in times)
    data = Examples(tracks, times, targets, (1.0,) * len(tracks), tuple(map(tones, tracks)))
    for kind, encoder, fitted in (("two_stage", "bands", True), ("cnn", "mfcc_live", False)):
        regressor = Still()
        regressor.config = make_config(kind, {"encoder": encoder}, "test")
        found = recipes.learn_articulation(regressor, data)
        assert (found is not None) == fitted, kind
        assert found is None or np.array_equal(found["weights"], learned.weights)
    assert recipes.learn_articulation(load_model("default").regressor, data) is None


def test_what_is_damaged_or_of_another_encoder_is_refused(learned: AudioArticulation) -> None:
    with pytest.raises(ModelError, match="shapes do not match"):
        AudioArticulation.from_tensors(learned.tensors() | {"offset": np.zeros(3)})
    with pytest.raises(ModelError, match="damaged"):
        AudioArticulation.from_tensors({"offset": np.zeros(3)})
    with pytest.raises(ModelError, match="was learned with 'another'"):
        replace(learned, identity="another").at(tones(TRACK), TIMES)


def test_streams_hear_too_little_ahead() -> None:
    assert can_predict_articulation("whisper")
    assert not can_predict_articulation("mfcc_live")
    assert not can_predict_articulation("phones")


def test_features_of_another_program_are_read_from_their_files(tmp_path: Path) -> None:
    """The encoder "precomputed" runs nothing: the features lie beside each recording."""
    clips = []
    for seed in range(3):
        track = babble(seed)
        sound = replace(tones(track), features=tmp_path / f"{seed}.features.npy")
        steps = (np.arange(round(sound.duration * 50)) + 0.5) / 50
        np.save(tmp_path / f"{seed}.features.npy", np.eye(41, dtype=np.float32)[track.sample(steps)])
        clips.append((track, np.arange(0, track.duration, 0.04), sound))
    learned = fit_audio_articulation("precomputed", clips[:2])
    track, times, sound = clips[2]
    found, wanted = learned.at(sound, times)[0], articulate(track, times).values
    jaw = CHANNELS.index("jaw")
    assert correlation(found[:, jaw], wanted[:, jaw]) > 0.5
