"""Models of audio and phones: both count, either may end first, and both are asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples, made_up_face, random_track, sound_of, track_of

from phonanim.__main__ import run
from phonanim.errors import ModelError, OptionError
from phonanim.features.inputs import n_features
from phonanim.media.audio import Sound, read_sound
from phonanim.options import DEFAULTS
from phonanim.pipeline import animate, load_model
from phonanim.regressors import Examples, Model, load, make_config, save
from phonanim.regressors.hybrid import Hybrid
from phonanim.stream.engine import PhoneStream

pytest.importorskip("torch")
SMALL = {"encoder": "mfcc", "hidden": 8, "depth": 1, "window": 20, "learning_rate": 0.02, "epochs": 2}


def trained(data: Examples, **more: Any) -> Hybrid:
    config = make_config("hybrid", SMALL | more, "test")
    return Hybrid.fit(config, data, data, np.random.default_rng(1), lambda done: None)


def silent(sound: Sound) -> Sound:
    return Sound(np.zeros_like(sound.samples), sound.rate)


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=6)


@pytest.fixture(scope="module")
def regressor(data: Examples) -> Hybrid:
    return trained(data, rate=25.0)


@pytest.fixture(scope="module")
def model(data: Examples, tmp_path_factory: pytest.TempPathFactory) -> str:
    """A small model for the shipped face."""
    face = load_model("default").face
    known = made_up_examples(np.random.default_rng(5), clips=3, modes=len(face.std))
    folder = tmp_path_factory.mktemp("models") / "both"
    save(Model(trained(known), face, {"fps": 25.0}), folder)
    return str(folder)


def test_both_move_the_face(regressor: Hybrid, data: Examples) -> None:
    track, times, sound = data.tracks[0], data.times[0], data.sounds[0]
    whole = regressor.predict(track, times, sound)
    assert regressor.input_modality == "both"
    assert np.abs(regressor.predict(track, times, silent(sound)) - whole).max() > 0.05
    mute = track_of(f"sil {track.duration}")
    assert np.abs(regressor.predict(mute, times, sound) - whole).max() > 0.05


def test_each_layer_has_the_phones_beside_it(regressor: Hybrid, data: Examples) -> None:
    track, sound = data.tracks[0], data.sounds[0]
    encoded = regressor.encode(sound, track)
    found = encoded.at(np.arange(7) / 25, 0.04)
    assert found.shape == (7, 1, encoded.values.shape[2] + n_features("gestures"))
    assert regressor.centre.shape == found.shape[1:]


def test_it_learns_from_what_is_not_in_the_sound() -> None:
    data = made_up_examples(np.random.default_rng(5), clips=10)
    deaf = replace(data, sounds=tuple(map(silent, data.sounds)))
    found = trained(deaf, hidden=24, epochs=15)
    mean = np.concatenate(data.targets).mean(axis=0)
    clips = list(zip(deaf.tracks, deaf.times, deaf.targets, deaf.sounds, strict=True))
    errors = [((found.predict(track, at, sound) - target) ** 2).mean() for track, at, target, sound in clips]
    spreads = [((target - mean) ** 2).mean() for target in data.targets]
    assert np.mean(errors) < 0.65 * np.mean(spreads)


@pytest.mark.parametrize("last", ["aa", "sil"])
def test_whichever_is_shorter_is_silent_after_its_end(last: str, regressor: Hybrid) -> None:
    track = track_of(f"sil 0.2 m 0.2 aa 0.3 iy 0.3 {last} 0.2")
    sound, times = sound_of(track), np.arange(60) / 40
    cut = Sound(sound.samples[: sound.rate // 2], sound.rate)
    quiet = Sound(np.pad(cut.samples, (0, len(sound.samples) - len(cut.samples))), sound.rate)
    short = regressor.predict(track, times, cut)
    assert np.array_equal(short, regressor.predict(track, times, quiet))
    assert np.ptp(short[24:], axis=0).max() > 0.05  # the phones go on
    longer = Sound(np.pad(sound.samples, (0, sound.rate)), sound.rate)
    rest = "sil 1.2" if last == "sil" else f"{last} 0.2 sil 1"
    said = track_of(f"sil 0.2 m 0.2 aa 0.3 iy 0.3 {rest}")
    found = regressor.predict(track, np.arange(80) / 40, longer)
    np.testing.assert_allclose(found, regressor.predict(said, np.arange(80) / 40, longer), atol=0.05)
    assert np.abs(found).max() < 100


@pytest.mark.parametrize("more", [{}, {"inputs": "all_enc", "beside": "classes"}, {"decoder": "mlp"}])
def test_stored_and_read_back(more: dict[str, Any], data: Examples, tmp_path: Path) -> None:
    regressor = trained(data, epochs=1, **more)
    save(Model(regressor, made_up_face(np.random.default_rng(0)), {"fps": 25.0}), tmp_path)
    track = random_track(np.random.default_rng(2))
    again = load(tmp_path).predict(track, 50, 30, sound=sound_of(track))
    assert np.array_equal(again, regressor.predict(track, np.arange(30) / 50, sound_of(track)))
    with pytest.raises(ModelError, match="a model of kind hybrid needs an alignment and a recording"):
        load(tmp_path).predict(None, 50, 30, sound=sound_of(track))


def test_what_never_moved_says_nothing(data: Examples) -> None:
    found = trained(replace(data, sounds=tuple(map(silent, data.sounds))), epochs=1)
    still = found.scale[0, : found.encode(silent(data.sounds[0]), data.tracks[0]).values.shape[2]]
    assert not still.all()
    assert np.abs(found.predict(data.tracks[0], data.times[0], data.sounds[0])).max() < 100


def test_both_are_needed(regressor: Hybrid, data: Examples) -> None:
    for track, sound in ((None, data.sounds[0]), (data.tracks[0], None)):
        with pytest.raises(ModelError, match="a hybrid model needs an alignment and a recording"):
            regressor.predict(track, np.zeros(1), sound)


def test_a_context_that_there_is_not() -> None:
    with pytest.raises(ModelError, match="hybrid: beside is 'phones'; use one of all, gestures, classes"):
        make_config("hybrid", {"beside": "phones"}, "test")


def test_animate_takes_both(line: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = animate(Path("a.TextGrid"), replace(DEFAULTS, model=model))
    assert len(found.phones) > 5
    assert found.audio == Path("a.wav")
    assert len(found.provenance["audio_sha256"]) == 64
    assert not any("lasts" in note for note in found.provenance["notes"])
    (line / "a.wav").unlink()
    assert run(["animate", "a.TextGrid", "--model", model, "-o", "a.csv"]) == 2
    said = capsys.readouterr().err
    assert said.endswith("has no recording next to it for this audio-driven model; give --audio\n")
    assert said.count("\n") == 1
    assert not (line / "a.csv").exists()


@pytest.mark.parametrize(("share", "shorter"), [(0.5, "recording"), (2.0, "alignment")])
def test_ends_that_lie_apart_are_told(line: Path, model: str, share: float, shorter: str) -> None:
    import wave

    sound = read_sound(line / "a.wav")
    with wave.open("b.wav", "wb") as file:
        file.setparams((1, 2, sound.rate, 0, "NONE", ""))
        whole = np.resize(sound.samples, round(share * len(sound.samples)))
        file.writeframes((whole * 32767).astype("<i2").tobytes())
    found = animate(Path("a.TextGrid"), replace(DEFAULTS, model=model), audio=Path("b.wav"))
    notes = [note for note in found.provenance["notes"] if "lasts" in note]
    assert [note.startswith("b.wav lasts ") for note in notes] == [False, True]
    assert notes[1].endswith(f"s; after its end, the {shorter} counts as silent")


def test_it_cannot_be_streamed(model: str) -> None:
    with pytest.raises(OptionError, match="needs an alignment and a recording, and cannot be streamed"):
        PhoneStream(replace(DEFAULTS, model=model))
