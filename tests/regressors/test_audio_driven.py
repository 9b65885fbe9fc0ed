"""Audio-driven regressors: trained in torch they run the same in NumPy, resume, and learn from sound."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
from speech import made_up_examples, made_up_face, random_track, sound_of, track_of

from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.regressors import CHECKPOINT, Examples, Model, load, make_config, regressor_class, save
from phonanim.regressors import _audio_input as audio_input
from phonanim.regressors._audio import AudioRegressor
from phonanim.regressors._decoders import decode
from phonanim.regressors._recurrent import run_gru
from phonanim.regressors._steps import cached_encoder, step_times

torch = pytest.importorskip("torch")
SMALL = {"encoder": "mfcc", "hidden": 8, "depth": 2, "window": 20, "learning_rate": 0.01, "epochs": 2}
DECODERS = ("mlp", "lstm", "gru", "rnn", "transformer")


def nothing(done: float) -> None:
    assert 0 <= done <= 1


def config_of(**more: Any) -> Any:
    return make_config("two_stage", SMALL | {"heads": 2, "widths": (5, 3)} | more, "test")


def trained(data: Examples, kind: str = "two_stage", journal: Path | None = None, **more: Any) -> Any:
    config = make_config(kind, SMALL | more, "test")
    fit: Any = regressor_class(kind).fit
    return fit(config, data, data, np.random.default_rng(1), nothing, journal=journal)


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=6)


@pytest.mark.parametrize("decoder", DECODERS)
@pytest.mark.parametrize("bidirectional", [False, True])
def test_torch_and_numpy_agree(decoder: str, bidirectional: bool) -> None:
    from phonanim.regressors._torch_decoders import Network, export_weights

    config = config_of(decoder=decoder, bidirectional=bidirectional, inputs="all_enc", window=12)
    torch.manual_seed(3)
    network = Network(config, 2, 6, 3).eval()
    values = torch.randn(4, 12, 2, 6)
    with torch.no_grad():
        found = network(values)[1].numpy()
    mix, weights = export_weights(network, np.zeros(3, np.float32), np.ones(3, np.float32))
    model = AudioRegressor(
        config, *np.zeros((1, 2, 6), np.float32), np.ones((2, 6), np.float32), mix, weights, ""
    )
    mine = decode(config, weights, np.stack([model.mix_layers(one) for one in values.numpy()]))
    np.testing.assert_allclose(mine, found, atol=1e-5)


def test_the_recurrent_unit_by_its_formula() -> None:
    rng = np.random.default_rng(0)
    forward, recurrent = rng.normal(size=(1, 3, 6)), rng.normal(size=(1, 2, 6))
    bias, recur_bias = rng.normal(size=(2, 1, 6))
    signal, state = rng.normal(size=(1, 5, 3)), np.zeros(2)
    found = run_gru(*(a.astype(np.float32) for a in (signal, forward, recurrent, bias, recur_bias)))
    for step, given in enumerate(signal[0]):
        a, b = given @ forward[0] + bias[0], state @ recurrent[0] + recur_bias[0]
        reset, update = (1 / (1 + np.exp(-(a[i : i + 2] + b[i : i + 2]))) for i in (0, 2))
        new = np.tanh(a[4:] + reset * b[4:])
        state = (1 - update) * new + update * state
        np.testing.assert_allclose(found[0, step], state, atol=1e-5)


@pytest.mark.parametrize("decoder", DECODERS)
def test_what_looks_ahead(decoder: str) -> None:
    """A change of the sound at a step moves earlier steps only where the decoder may look ahead."""
    from phonanim.regressors._torch_decoders import Network, export_weights

    config = config_of(decoder=decoder, bidirectional=False, window=10)
    torch.manual_seed(0)
    weights = export_weights(
        Network(config, 1, 4, 2).eval(), np.zeros(2, np.float32), np.ones(2, np.float32)
    )[1]
    signal = np.random.default_rng(0).normal(size=(1, 30, 4)).astype(np.float32)
    other = signal.copy()
    other[0, 20] += 1
    moved = np.flatnonzero(
        np.abs(decode(config, weights, other) - decode(config, weights, signal))[0].sum(axis=1)
    )
    ahead = {"gru": 0, "lstm": 0, "rnn": 0, "mlp": config.widths[1] - 1, "transformer": config.window - 1}[
        decoder
    ]
    assert 20 - ahead <= moved[0] <= 20


@pytest.mark.parametrize("decoder", DECODERS)
def test_every_decoder_is_stored_and_read_back(decoder: str, data: Examples, tmp_path: Path) -> None:
    regressor = trained(data, decoder=decoder, heads=2, widths=(5, 3))
    save(Model(regressor, made_up_face(np.random.default_rng(0)), {"fps": 25.0}), tmp_path)
    sound = data.sounds[0]
    assert sound is not None
    for seconds in (0.005, 0.3, 2.0):
        part = Sound(sound.samples[: round(seconds * sound.rate)], sound.rate)
        again = load(tmp_path).predict(None, 50, 7, sound=part)
        assert np.array_equal(again, regressor.predict(track_of("sil 0.1"), np.arange(7) / 50, part))
        assert np.isfinite(again).all()


def test_it_learns_from_sound() -> None:
    data = made_up_examples(np.random.default_rng(5), clips=12)
    regressor = trained(data, hidden=24, depth=1, epochs=20, learning_rate=0.02)
    mean = np.concatenate(data.targets).mean(axis=0)
    errors, spreads = [], []
    for track, times, target, sound in zip(data.tracks, data.times, data.targets, data.sounds, strict=True):
        errors.append(((regressor.predict(track, times, sound) - target) ** 2).mean())
        spreads.append(((target - mean) ** 2).mean())
    assert np.mean(errors) < 0.65 * np.mean(spreads)


def test_a_halt_changes_nothing(data: Examples, tmp_path: Path) -> None:
    whole = trained(data, "phisanet", tmp_path / "whole", epochs=4, dropout=0.3, cosine=True)

    def halt(done: float) -> None:
        if done >= 0.5:
            raise KeyboardInterrupt

    config = make_config("phisanet", SMALL | {"epochs": 4, "dropout": 0.3, "cosine": True}, "test")
    fit: Any = regressor_class("phisanet").fit
    with pytest.raises(KeyboardInterrupt):
        fit(config, data, data, np.random.default_rng(1), halt, journal=tmp_path / "cut")
    assert (tmp_path / "cut" / CHECKPOINT).is_file()
    assert len((tmp_path / "cut" / "loss.csv").read_text().splitlines()) == 3
    steps: list[float] = []
    resumed = fit(config, data, data, np.random.default_rng(1), steps.append, journal=tmp_path / "cut")
    assert steps == [0.75, 1.0, 1.0]
    for name, tensor in whole.tensors().items():
        assert np.array_equal(tensor, resumed.tensors()[name]), name
    curves = [(tmp_path / name / "loss.csv").read_text() for name in ("whole", "cut")]
    assert curves[0] == curves[1]
    assert curves[0].startswith("epoch,training_loss,validation_mm2\n1,")


def test_another_training_starts_anew(data: Examples, tmp_path: Path) -> None:
    trained(data, journal=tmp_path)
    again = trained(data, journal=tmp_path, learning_rate=0.02)
    fresh = trained(data, learning_rate=0.02)
    assert all(np.array_equal(t, again.tensors()[n]) for n, t in fresh.tensors().items())


def test_training_stops_when_nothing_is_gained(data: Examples, tmp_path: Path) -> None:
    trained(data, journal=tmp_path, epochs=30, patience=1, learning_rate=1.0)
    errors = [float(line.split(",")[2]) for line in (tmp_path / "loss.csv").read_text().splitlines()[1:]]
    assert len(errors) < 30
    assert len(errors) - 1 - int(np.argmin(errors)) == 2


def test_the_loss_by_its_equations() -> None:
    from phonanim.regressors import _torch_audio as training
    from phonanim.regressors._torch_decoders import Network

    rng = np.random.default_rng(0)
    values, targets = rng.normal(size=(2, 9, 1, 4)), rng.normal(size=(2, 9, 3))
    codes = np.array([[1, 1, 1, 2, 2, 2, 3, 3, 3], [4, 4, 4, 4, 4, 4, 4, 4, 4]])
    segments = codes * 10
    ones = np.ones((1, 4), np.float32)
    scaling = training.Scaling(0 * ones, ones, np.zeros(3, np.float32), np.full(3, 2, np.float32))
    network = Network(config_of(window=9), 1, 4, 3).eval()
    given = [torch.from_numpy(a.astype(np.float32)) for a in (values, targets)]

    def total(**weights: float) -> float:
        found = training.loss(
            config_of(**weights), network, scaling, *given, codes, segments, codes[:, 0], torch.ones(2)
        )
        return float(found.detach())

    with torch.no_grad():
        hidden, found = (part.numpy() for part in network(given[0]))
    apart = found - targets / 2
    first = np.mean(apart**2)
    velocity, acceleration = (np.mean(np.diff(apart, n, axis=1) ** 2) for n in (1, 2))
    np.testing.assert_allclose(total(), first, rtol=1e-5)
    np.testing.assert_allclose(
        total(velocity=0.5, acceleration=0.2), first + 0.5 * velocity + 0.2 * acceleration, rtol=1e-5
    )
    shares = network.classifier(torch.from_numpy(hidden)).softmax(dim=2).detach().numpy()
    entropy = -np.log(np.take_along_axis(shares, codes[..., None], axis=2)).mean()
    np.testing.assert_allclose(total(classifier=0.1), first + 0.1 * entropy, rtol=1e-5)
    labels = network.ctc(torch.from_numpy(hidden)).log_softmax(dim=2).detach().numpy()
    sequences = [[1, 2, 3], [4]]
    expected = np.mean([-all_paths(labels[n], phones) / len(phones) for n, phones in enumerate(sequences)])
    np.testing.assert_allclose(total(ctc=0.1), first + 0.1 * expected, rtol=1e-4)


def all_paths(scores: np.ndarray, phones: list[int]) -> float:
    """Log probability of a phone sequence, summed over all its alignments, (steps, labels) log shares."""
    blank = scores.shape[1] - 1
    labels = [blank]
    for phone in phones:
        labels += [phone, blank]
    paths = np.full(len(labels), -np.inf)
    paths[:2] = scores[0, labels[:2]]
    for score in scores[1:]:
        before = paths.copy()
        for i, label in enumerate(labels):
            ways = [before[i], *before[max(i - 1, 0) : i]]
            if i > 1 and label != blank and label != labels[i - 2]:
                ways.append(before[i - 2])
            paths[i] = np.logaddexp.reduce(ways) + score[label]
    return float(np.logaddexp(paths[-1], paths[-2]))


def test_minmax_and_scale_give_millimetres(data: Examples) -> None:
    sound = data.sounds[0]
    for normalize in ("minmax", "scale"):
        found = trained(data, normalize=normalize, epochs=15).predict(None, data.times[0], sound)
        assert np.abs(found.mean(axis=0) - np.concatenate(data.targets).mean(axis=0)).max() < 3


def test_shares_of_layers_sum_to_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: Examples) -> None:
    from encoder_samples import put_whisper

    put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    cached_encoder.cache_clear()
    regressor = trained(data, "phisanet", encoder="whisper")
    assert regressor.layer_shares.shape == (3,)
    assert regressor.layer_shares.sum() == pytest.approx(1)
    assert not np.allclose(regressor.layer_shares, 1 / 3)
    other = replace(regressor, identity="whisper of another kind")
    with pytest.raises(
        ModelError, match="trained with 'whisper of another kind', but the encoder is 'whisper .*': set"
    ):
        other.predict(None, np.zeros(1), data.sounds[0])
    cached_encoder.cache_clear()


def test_a_long_recording_is_decoded_in_stretches(data: Examples, monkeypatch: pytest.MonkeyPatch) -> None:
    regressor = trained(data)
    track = random_track(np.random.default_rng(2), segments=60)
    sound = sound_of(track)
    times = np.arange(0, sound.duration, 0.01)
    whole = regressor.predict(None, times, sound)
    monkeypatch.setattr(audio_input, "CHUNK", 2.0)
    assert sound.duration > 4
    np.testing.assert_allclose(regressor.predict(None, times, sound), whole, atol=1e-3)


def test_phones_come_from_the_alignment_if_there_is_one(data: Examples) -> None:
    regressor = trained(data, encoder="phones")
    track, sound = data.tracks[0], data.sounds[0]
    found = regressor.predict(track, data.times[0], sound)
    deaf = regressor.predict(track, data.times[0], Sound(np.zeros_like(sound.samples), sound.rate))  # type: ignore[union-attr]
    assert np.array_equal(found, deaf)


def test_the_rate_may_be_that_of_the_video(data: Examples) -> None:
    regressor = trained(data, rate=25.0)
    times = step_times(1.0, 25.0)
    np.testing.assert_allclose(times[:3], [0.02, 0.06, 0.1])
    np.testing.assert_allclose(step_times(1.0, 50.0)[:3], [0, 0.02, 0.04], atol=1e-12)
    assert len(times) == 25
    assert regressor.predict(None, data.times[0], data.sounds[0]).shape == data.targets[0].shape


def test_recordings_are_needed(data: Examples) -> None:
    deaf = Examples(data.tracks, data.times, data.targets, data.weights)
    with pytest.raises(ModelError, match="is trained on recordings: give it clips with sound"):
        trained(deaf)
    with pytest.raises(ModelError, match="an audio-driven model needs a recording"):
        trained(data).predict(track_of("sil 0.2"), np.zeros(1))


def test_weights_that_do_not_fit(data: Examples, tmp_path: Path) -> None:
    save(Model(trained(data), made_up_face(np.random.default_rng(0)), {"fps": 25.0}), tmp_path)
    path = tmp_path / "weights.safetensors"
    tensors = load_file(path)
    tensors["decoder_recur1"] = tensors["decoder_recur1"][:, :4].copy()
    save_file(tensors, path)
    with pytest.raises(
        ModelError, match=r"does not match its model.json \(decoder_recur1 is \(2, 4, 24\), not \(2, 8, 24\)"
    ):
        load(tmp_path)
    card = json.loads((tmp_path / "model.json").read_text())
    assert card["config"]["encoder"] == "mfcc"
