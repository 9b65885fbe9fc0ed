"""FaceDiffuser: its equations, its seeds, its stages; trained in torch it runs the same in NumPy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
from speech import made_up_examples, made_up_face, sound_of

from phonanim.encoders import HOP, RATE
from phonanim.errors import ModelError
from phonanim.media.audio import Sound
from phonanim.regressors import CHECKPOINT, Examples, Model, load, make_config, save
from phonanim.regressors import _audio_input as audio_input
from phonanim.regressors import _diffusion as diffusion
from phonanim.regressors._facediffuser_config import EMBEDDINGS, MASKS, Config
from phonanim.regressors._steps import step_times
from phonanim.regressors.facediffuser import FaceDiffuser

torch = pytest.importorskip("torch")
SMALL: dict[str, Any] = {
    **{"encoder": "mfcc", "latent": 8, "hidden": 12, "depth": 1, "timesteps": 50, "steps": 5},
    **{"window": 30, "batch": 6, "epochs": 4, "learning_rate": 0.02},
}


def nothing(done: float) -> None:
    assert 0 <= done <= 1


def trained(data: Examples, journal: Path | None = None, **more: Any) -> FaceDiffuser:
    config = make_config("facediffuser", SMALL | more, "test")
    return FaceDiffuser.fit(config, data, data, np.random.default_rng(1), nothing, journal)


def random_weights(config: Config, dims: int, modes: int) -> dict[str, Any]:
    rng = np.random.default_rng(3)
    shapes = diffusion.weight_shapes(config, dims, modes)
    return {name: rng.normal(0, 0.4, shape).astype(np.float32) for name, shape in shapes.items()}


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=6)


@pytest.fixture(scope="module")
def model(data: Examples) -> FaceDiffuser:
    return trained(data)


@pytest.mark.parametrize("embedding", EMBEDDINGS)
@pytest.mark.parametrize("more", [{}, {"diffusion": False}, {"bidirectional": True, "depth": 2}])
def test_torch_and_numpy_agree(embedding: str, more: dict[str, Any]) -> None:
    from phonanim.regressors._torch_denoiser import Network

    config = make_config("facediffuser", SMALL | {"noise": embedding, "sound": embedding} | more, "test")
    torch.manual_seed(0)
    network = Network(config, 6, 3).eval()
    with torch.no_grad():
        network.style.uniform_(0.5, 1.5)
        sound, noisy = torch.randn(2, 9, 6), torch.randn(2, 9, 3)
        styles = torch.zeros(2, dtype=torch.long)
        expected = network(network.sound(sound), noisy, np.array([7, 7]), styles)
    weights = network.export()
    assert {name: t.shape for name, t in weights.items()} == diffusion.weight_shapes(config, 6, 3)
    audio = diffusion.embed(config.sound, diffusion.tensors_with_prefix(weights, "sound_"), sound.numpy())
    found = diffusion.denoise(config, weights, noisy.numpy(), 7, audio)
    np.testing.assert_allclose(found, expected.numpy(), atol=1e-5)


def test_noise_grows_as_its_equation_says() -> None:
    """Step by step by equation 1, and at once: the same share of signal and of noise."""
    shares = diffusion.signal_share(200)
    betas = np.linspace(1e-4, 0.02, 200) * 5
    signal, noise = 1.0, 0.0
    for time, beta in enumerate(betas, start=1):
        signal, noise = signal * np.sqrt(1 - beta), noise * (1 - beta) + beta
        np.testing.assert_allclose([signal**2, noise], [shares[time], 1 - shares[time]])
    assert shares[0] == 1
    assert np.all(np.diff(shares) < 0)
    for timesteps in (100, 500, 1000):
        assert 1e-5 < diffusion.signal_share(timesteps)[-1] < 1e-4
    motion, chance = np.float32([2.0]), np.float32([3.0])
    np.testing.assert_allclose(diffusion.add_noise(motion, 0.36, chance), [2 * 0.6 + 3 * 0.8], rtol=1e-6)


@pytest.mark.parametrize(("timesteps", "steps"), [(500, 50), (500, 500), (20, 1), (7, 5)])
def test_strides_go_from_the_last_time_to_the_first(timesteps: int, steps: int) -> None:
    times = diffusion.sampling_times(timesteps, steps)
    assert times[0] == timesteps
    assert steps == 1 or times[-1] == 1
    assert len(set(times.tolist())) == steps
    assert np.all(np.diff(times) < 0)


def test_noise_is_the_same_whoever_asks() -> None:
    whole = diffusion.step_noise(4, 2, 0, 3500, 3)
    assert np.array_equal(diffusion.step_noise(4, 2, 1400, 300, 3), whole[1400:1700])
    assert not np.array_equal(diffusion.step_noise(4, 3, 0, 10, 3), whole[:10])
    assert not np.array_equal(diffusion.step_noise(5, 2, 0, 10, 3), whole[:10])
    assert abs(whole.mean()) < 0.05
    assert abs(whole.std() - 1) < 0.05


def test_what_is_found_is_diffused_to_the_next_time() -> None:
    """Sampling by its definition, with a network asked one time after the other."""
    config = make_config("facediffuser", SMALL | {"steps": 4}, "test")
    weights, rng = random_weights(config, 5, 2), np.random.default_rng(0)
    audio, noise = rng.normal(size=(1, 6, 8)).astype(np.float32), rng.normal(size=(4, 1, 6, 2))
    noise = noise.astype(np.float32)
    found = noise[0]
    for turn, time in enumerate((50, 34, 17, 1)):
        if turn:
            share = diffusion.signal_share(50)[time]
            found = np.sqrt(share) * found + np.sqrt(1 - share) * noise[turn]
        found = diffusion.denoise(config, weights, found.astype(np.float32), time, audio)
    sampled = diffusion.sample_motion(config, weights, audio, lambda turn: noise[turn])
    np.testing.assert_allclose(sampled, found, atol=1e-5)


def test_guidance_weighs_the_audio() -> None:
    config = make_config("facediffuser", SMALL | {"guidance": 1.5}, "test")
    weights, rng = random_weights(config, 5, 2), np.random.default_rng(0)
    audio, no_audio, noisy = (rng.normal(size=(1, 6, size)).astype(np.float32) for size in (8, 8, 2))
    with_sound, without = (diffusion.denoise(config, weights, noisy, 9, part) for part in (audio, no_audio))
    found = diffusion.guided_motion(config, weights, noisy, 9, audio, no_audio)
    np.testing.assert_allclose(found, 1.5 * with_sound - 0.5 * without, atol=1e-5)
    assert np.array_equal(diffusion.guided_motion(config, weights, noisy, 9, audio, None), with_sound)


def test_guidance_of_a_model(model: FaceDiffuser, data: Examples) -> None:
    times = np.arange(9) / 25
    takes = [model.with_settings(guidance=w).predict(None, times, data.sounds[0]) for w in (1.0, 1.0, 0.5)]
    assert np.array_equal(takes[0], takes[1])
    assert not np.array_equal(takes[0], takes[2])
    deaf = [model.with_settings(guidance=0.0).predict(None, times, sound) for sound in data.sounds[:2]]
    np.testing.assert_allclose(deaf[0], deaf[1], atol=1e-4)


def test_masks_by_their_definition() -> None:
    rng = np.random.default_rng(0)
    audio = np.full((4000, 2, 3), 7, np.float32)
    found = {name: diffusion.mask_sound(name, 0.25, audio, rng) for name in MASKS}
    hidden = {name: one != 7 for name, one in found.items()}
    assert not hidden["none"].any()
    for name in MASKS[1:]:
        assert abs(hidden[name].mean() - 0.25) < 0.03
        whole = hidden[name].reshape(4000, -1)
        together = np.all(whole == whole[:, :1], axis=1).mean()
        assert together == 1 if name.startswith("full") else together < 0.4
        values = found[name][hidden[name]]
        assert np.all(values == 0) if name.endswith("zero") else abs(values.std() - 1) < 0.05


@pytest.mark.parametrize("masking", MASKS)
def test_it_trains_with_every_mask(masking: str, data: Examples) -> None:
    found = trained(data, masking=masking, epochs=1)
    assert np.isfinite(found.predict(None, np.arange(5) / 25, data.sounds[0])).all()


def test_the_loss_by_its_equation(data: Examples) -> None:
    from phonanim.regressors._torch_denoiser import Network
    from phonanim.regressors._torch_diffusion import Stage, diffusion_steps, scaled

    config = make_config(
        "facediffuser", SMALL | {"diffusion": False, "masking": "none", "delta": 0.5}, "test"
    )
    steps = diffusion_steps(config, data)
    scaling = scaled(config, steps)
    network = Network(config, steps.values.shape[2], 3).eval()
    rows = np.arange(20).reshape(2, 10)
    values, targets = steps.values[rows].astype(np.float32), steps.targets[rows]
    parts = (
        torch.from_numpy(values),
        torch.from_numpy(targets),
        np.zeros(2, np.int64),
        torch.tensor([1.0, 3.0]),
    )
    total = Stage(config, network, steps, scaling, 0).loss(*parts, np.random.default_rng(0))
    model = FaceDiffuser(
        config, scaling.centre, scaling.scale, scaling.low, scaling.span, network.export(), ""
    )
    audio = model.embed_sound(np.stack([model.normalize_features(one) for one in values]))
    found = diffusion.denoise(config, model.weights, np.zeros((2, 10, 3), np.float32), 0, audio)
    apart = np.abs(found - (targets - scaling.low) / scaling.span)
    huber = np.where(apart < 0.5, apart**2 / 2, 0.5 * apart - 0.125)
    np.testing.assert_allclose(float(total.detach()), (huber.mean(axis=(1, 2)) * [1, 3]).mean(), rtol=1e-4)


def test_seeds(model: FaceDiffuser, data: Examples, tmp_path: Path) -> None:
    """The same seed gives the same bytes, from a stored model too; another one another take."""
    times = np.arange(20) / 25
    takes = [model.with_settings(seed=seed).predict(None, times, data.sounds[0]) for seed in (0, 0, 1)]
    assert takes[0].tobytes() == takes[1].tobytes()
    assert np.abs(takes[0] - takes[2]).max() > 1e-3
    save(Model(model.with_settings(seed=1), made_up_face(np.random.default_rng(0)), {"fps": 25.0}), tmp_path)
    again = load(tmp_path).regressor.predict(None, times, data.sounds[0])
    assert again.tobytes() == takes[2].tobytes()


def test_without_diffusion_there_is_one_take(data: Examples) -> None:
    plain = trained(data, diffusion=False)
    assert not any(name.startswith(("noise", "time")) for name in plain.weights)
    takes = [
        plain.with_settings(seed=seed).predict(None, np.arange(9) / 25, data.sounds[0]) for seed in (0, 1)
    ]
    assert np.array_equal(*takes)


@pytest.mark.parametrize("more", [{"diffusion": False}, {"normalize": "modes"}])
def test_it_learns_from_sound(more: dict[str, Any]) -> None:
    data = made_up_examples(np.random.default_rng(5), clips=10)
    model = trained(data, hidden=24, epochs=25, batch=3, bidirectional=True, masking="none", **more)
    mean = np.concatenate(data.targets).mean(axis=0)
    errors, spreads = [], []
    for times, target, sound in zip(data.times, data.targets, data.sounds, strict=True):
        errors.append(((model.predict(None, times, sound) - target) ** 2).mean())
        spreads.append(((target - mean) ** 2).mean())
    assert np.mean(errors) < 0.75 * np.mean(spreads)


def test_styles_are_told_apart() -> None:
    data = made_up_examples(np.random.default_rng(5), clips=8)
    both = replace(
        data + replace(data, targets=tuple(target * 2 for target in data.targets)), styles=(0,) * 8 + (1,) * 8
    )
    model = trained(both, diffusion=False, styles=2, epochs=25, masking="none")
    calm, lively = (model.with_settings(style=n).predict(None, data.times[0], data.sounds[0]) for n in (0, 1))
    assert lively.std() > 1.2 * calm.std()


def test_long_sounds_are_sampled_in_parts(
    model: FaceDiffuser, data: Examples, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = data.sounds[0]
    times = np.arange(0, sound.duration, 0.02)
    whole = model.predict(None, times, sound)
    monkeypatch.setattr(audio_input, "CHUNK", 0.6)
    monkeypatch.setattr(audio_input, "AROUND", 0.8)
    parts = model.predict(None, times, sound)
    np.testing.assert_allclose(parts, whole, atol=0.02 * np.ptp(whole))


def test_the_last_step_is_as_if_the_sound_went_on(model: FaceDiffuser, data: Examples) -> None:
    """What sees the noise looks a step ahead, and in training there was none after the last."""
    features = model.encode(data.sounds[0])
    grid = step_times(data.sounds[0].duration, model.config.rate)
    longer = np.append(grid, grid[-1] + np.arange(1, 20) / model.config.rate)
    found, expected = model.modes_at_steps(features, grid), model.modes_at_steps(features, longer)
    assert found.shape == (len(grid), 3)
    np.testing.assert_allclose(found, expected[: len(grid)], atol=0.01 * np.ptp(expected))


def test_the_sound_is_embedded_once(
    model: FaceDiffuser, data: Examples, monkeypatch: pytest.MonkeyPatch
) -> None:
    times: list[int] = []
    encode = audio_input.sound_features
    monkeypatch.setattr(audio_input, "sound_features", lambda *given: times.append(1) or encode(*given))
    model.with_settings(steps=50).predict(None, np.arange(5) / 25, data.sounds[0])
    assert times == [1]


def test_sounds_of_any_length(model: FaceDiffuser) -> None:
    for count in (1, HOP, RATE):
        found = model.predict(None, np.arange(4) / 25, Sound(np.zeros(count, np.float32), RATE))
        assert found.shape == (4, 3)
        assert np.isfinite(found).all()


@pytest.mark.parametrize("more", [{"cosine": True, "dropout": 0.2, "depth": 2}, {"autoencoder": 3}])
def test_a_halt_changes_nothing(more: dict[str, Any], data: Examples, tmp_path: Path) -> None:
    whole = trained(data, tmp_path / "whole", **more)

    for end in (0.2, 0.7):

        def halt(done: float, end: float = end) -> None:
            if done >= end:
                raise KeyboardInterrupt

        config = make_config("facediffuser", SMALL | more, "test")
        with pytest.raises(KeyboardInterrupt):
            FaceDiffuser.fit(config, data, data, np.random.default_rng(1), halt, tmp_path / "cut")
    resumed = trained(data, tmp_path / "cut", **more)
    for name, tensor in whole.tensors().items():
        assert np.array_equal(tensor, resumed.tensors()[name]), name
    curves = [(tmp_path / name / "loss.csv").read_text() for name in ("whole", "cut")]
    assert curves[0] == curves[1]
    assert len(curves[0].splitlines()) == 5


def test_the_second_stage_keeps_what_draws_faces(data: Examples, tmp_path: Path) -> None:
    """Appendix B: a decoder that was learned without sound stays as it was."""
    short, long = (trained(data, tmp_path / str(n), autoencoder=2, epochs=n, patience=9) for n in (1, 3))
    same = {name for name, tensor in short.weights.items() if np.array_equal(tensor, long.weights[name])}
    assert set(short.weights) - same == {"sound_first", "sound_first_bias"}
    assert len((tmp_path / "3/autoencoder/loss.csv").read_text().splitlines()) == 3
    assert not (tmp_path / "3/autoencoder" / CHECKPOINT).exists()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"sound": "liner"}, "facediffuser: sound is 'liner'; did you mean 'linear'?"),
        ({"noise": "xyz"}, "facediffuser: noise is 'xyz'; take none, linear, mlp, conv, max, average"),
        ({"masking": "full zeros"}, "masking is 'full zeros'; did you mean 'full zero'?"),
        ({"steps": 600}, "facediffuser: steps is 600; take 1 to 500, the number of timesteps"),
        ({"style": 2, "styles": 2}, "facediffuser: there is no style 2; take 0 to 1"),
        ({"latent": 7}, "facediffuser: latent is 7; take an even number"),
        ({"seed": -1}, "facediffuser: seed is -1; take 0 or more"),
    ],
)
def test_settings_that_cannot_be(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match="^mine.toml: .*" + said.replace("?", r"\?")):
        make_config("facediffuser", settings, "mine.toml")


def test_examples_that_cannot_be_learned_from(data: Examples) -> None:
    with pytest.raises(ModelError, match="is trained on recordings: give it clips with sound"):
        trained(replace(data, sounds=()))
    with pytest.raises(ModelError, match="the examples have style 3; set styles to 4 or more"):
        trained(replace(data, styles=(0, 0, 0, 3, 0, 0)), styles=2)


def test_a_model_of_one_style_learns_all_as_one(data: Examples) -> None:
    plain, styled = trained(data), trained(replace(data, styles=(0, 0, 0, 3, 0, 0)))
    for name, values in plain.tensors().items():
        np.testing.assert_array_equal(values, styled.tensors()[name])


def test_it_needs_a_recording(model: FaceDiffuser) -> None:
    with pytest.raises(ModelError, match="an audio-driven model needs a recording"):
        model.predict(None, np.arange(3) / 25)


def test_weights_of_another_size(model: FaceDiffuser, tmp_path: Path) -> None:
    save(Model(model, made_up_face(np.random.default_rng(0)), {"fps": 25.0}), tmp_path)
    path = tmp_path / "weights.safetensors"
    tensors = load_file(path)
    tensors["network_recur0"] = tensors["network_recur0"][:, :-1]
    save_file(tensors, path)
    with pytest.raises(
        ModelError, match=r"does not match its model.json \(network_recur0 is .*train it again"
    ):
        load(tmp_path)


def test_weights_of_another_encoder(model: FaceDiffuser, data: Examples) -> None:
    with pytest.raises(
        ModelError, match="the model was trained with 'whisper of another', but the encoder is 'mfcc"
    ):
        replace(model, identity="whisper of another").predict(
            None, np.arange(3) / 25, sound_of(data.tracks[0])
        )
