"""The choices of FaceDiffuser, as published and as released: each builds, trains, and is what it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from speech import made_up_examples

from phonanim.core.neural import tensors_with_prefix
from phonanim.encoders import load_encoder
from phonanim.errors import ModelError
from phonanim.regressors import Examples, make_config
from phonanim.regressors import _diffusion as diffusion
from phonanim.regressors._denoiser import Denoiser
from phonanim.regressors._facediffuser_config import SAMPLINGS
from phonanim.regressors._steps import features_at_steps, sound_features, step_times
from phonanim.regressors.facediffuser import FaceDiffuser

torch = pytest.importorskip("torch")
SMALL: dict[str, Any] = {
    **{"encoder": "mfcc", "latent": 8, "hidden": 12, "depth": 1, "timesteps": 20, "steps": 4},
    **{"window": 20, "batch": 6, "epochs": 1, "learning_rate": 0.02},
}
CHOICES: tuple[dict[str, Any], ...] = (
    {"schedule": "cosine"},
    {"sampling": "strided"},
    {"sampling": "posterior", "steps": 20},
    {"noise_over": "features", "noise": "conv"},
    {"noise_over": "features", "noise": "max"},
    {"noise_over": "features", "noise": "average"},
    {"decoder": "rnn", "depth": 2, "bidirectional": True},
    {"decoder": "transformer", "depth": 2},
    {"zero_output": True},
    {"pairs": "concatenate"},
    {"noise": "none", "sound": "none", "pairs": "concatenate"},
)


def config_of(**more: Any) -> Any:
    return make_config("facediffuser", SMALL | more, "test")


@pytest.fixture(scope="module")
def data() -> Examples:
    return made_up_examples(np.random.default_rng(5), clips=4)


@pytest.mark.parametrize("choice", CHOICES, ids=str)
def test_every_choice_trains_and_predicts(choice: dict[str, Any], data: Examples) -> None:
    rng = np.random.default_rng(1)
    model = FaceDiffuser.fit(config_of(**choice), data, data, rng, lambda done: None)
    again = FaceDiffuser.from_tensors(model.config, model.tensors())
    times = np.arange(40) / 30
    found = again.predict(None, times, data.sounds[0])
    assert found.shape == (40, data.targets[0].shape[1])
    assert np.isfinite(found).all()
    assert np.array_equal(found, model.predict(None, times, data.sounds[0]))


@pytest.mark.parametrize("choice", CHOICES, ids=str)
def test_torch_and_numpy_agree(choice: dict[str, Any]) -> None:
    from phonanim.regressors._torch_denoiser import Network

    config = config_of(**choice)
    torch.manual_seed(0)
    network = Network(config, 6, 10).eval()
    with torch.no_grad():
        network.output.weight.add_(0.1)
        sound, noisy = torch.randn(2, 20, 6), torch.randn(2, 20, 10)
        styles = torch.zeros(2, dtype=torch.long)
        expected = network(network.sound(sound), noisy, np.array([7, 7]), styles)
    weights = network.export()
    assert {name: t.shape for name, t in weights.items()} == diffusion.weight_shapes(config, 6, 10)
    audio = diffusion.embed(config.sound, tensors_with_prefix(weights, "sound_"), sound.numpy())
    found = diffusion.denoise(config, weights, noisy.numpy(), 7, audio)
    np.testing.assert_allclose(found, expected.numpy(), atol=1e-5)


@pytest.mark.parametrize(("controls", "width"), [(192, 1856), (51, 1715)])
def test_the_version_for_rigs_has_the_inputs_of_the_thesis(controls: int, width: int) -> None:
    """Section 6.4: 1536 features of sound, the controls with noise, and 128 of the time."""
    config = config_of(noise="none", sound="none", latent=128, hidden=256, depth=2)
    shapes = diffusion.weight_shapes(config, 2 * 768, controls)
    assert shapes["forward0"][1] == width
    assert not any(name.startswith(("noise_", "sound_")) for name in shapes)


def test_the_cosine_is_that_of_its_equation() -> None:
    shares = diffusion.signal_share(100, "cosine")
    assert shares[0] == 1
    wanted = [np.cos((t / 100 + 0.008) / 1.008 * np.pi / 2) ** 2 for t in (0, 30, 70)]
    np.testing.assert_allclose(shares[[30, 70]], np.array(wanted[1:]) / wanted[0])
    assert (np.diff(shares) < 0).all()
    assert 0 < shares[-1] < 1e-5
    # It keeps more of the signal in the middle than the line does.
    assert shares[50] > 2 * diffusion.signal_share(100)[50]


def test_the_posterior_by_its_equation() -> None:
    """Ho et al. 2020, equation 7, at time 7 of 20."""
    shares, rng = diffusion.signal_share(20), np.random.default_rng(0)
    noisy, found, noise = (rng.normal(size=5).astype(np.float32) for _ in range(3))
    beta = 1 - shares[7] / shares[6]
    mean = np.sqrt(shares[6]) * beta / (1 - shares[7]) * found
    mean = mean + np.sqrt(1 - beta) * (1 - shares[6]) / (1 - shares[7]) * noisy
    wanted = mean + np.sqrt((1 - shares[6]) / (1 - shares[7]) * beta) * noise
    drawn = diffusion.draw_posterior(noisy, found, shares[7], shares[6], noise)
    np.testing.assert_allclose(drawn, wanted, rtol=1e-5)
    # Without noise to come, it is the estimate itself.
    np.testing.assert_allclose(
        diffusion.draw_posterior(noisy, found, shares[1], 1.0, noise), found, rtol=1e-5
    )


def test_drawn_motion_has_as_much_noise_as_its_time() -> None:
    rng, shares = np.random.default_rng(0), diffusion.signal_share(20, "cosine")
    motion, (first, second) = np.float32(3.0), (rng.standard_normal(100_000, np.float32) for _ in range(2))
    noisy = diffusion.add_noise(np.full(100_000, motion), shares[15], first)
    drawn = diffusion.draw_posterior(noisy, motion, shares[15], shares[4], second)
    assert drawn.mean() == pytest.approx(np.sqrt(shares[4]) * 3, abs=0.01)
    assert drawn.var() == pytest.approx(1 - shares[4], abs=0.01)


def test_each_sampling_goes_its_own_way() -> None:
    rng = np.random.default_rng(3)
    shapes = diffusion.weight_shapes(config_of(), 5, 2)
    weights = {name: rng.normal(0, 0.4, shape).astype(np.float32) for name, shape in shapes.items()}
    audio = rng.normal(size=(1, 6, 8)).astype(np.float32)
    noise = rng.standard_normal((20, 1, 6, 2), np.float32)

    def sample(sampling: str, steps: int = 20) -> Any:
        config = config_of(sampling=sampling, steps=steps)
        return diffusion.sample_motion(config, weights, audio, lambda turn: noise[turn])

    found = {sampling: sample(sampling) for sampling in SAMPLINGS}
    assert np.array_equal(found["posterior"], found["strided"])
    assert not np.allclose(found["posterior"], found["rediffuse"])
    assert not np.allclose(sample("strided", 5), found["strided"])


def test_a_zero_output_begins_at_the_mean() -> None:
    from phonanim.regressors._torch_denoiser import Network

    network = Network(config_of(zero_output=True), 6, 3)
    found = network(
        network.sound(torch.randn(1, 9, 6)), torch.randn(1, 9, 3), np.array([3]), torch.zeros(1).long()
    )
    assert not found.detach().numpy().any()


def test_pairs_are_the_two_halves_of_a_step(data: Examples) -> None:
    sound = data.sounds[0]
    paired = Denoiser.input_features(config_of(pairs="concatenate"), sound, None)
    alone = sound_features(load_encoder("mfcc"), sound, None)
    grid = step_times(sound.duration, 25.0)
    both = features_at_steps(paired, grid, 25.0)
    flat = both[:, 0].reshape(2 * len(both), -1)[2:-2]
    places = np.floor((grid[1] - 0.01 - alone.start) * 50 + 1e-6)
    np.testing.assert_array_equal(flat, alone.values[int(places) :, 0][: len(flat)])
    # At another rate they are interpolated.
    slow = step_times(sound.duration, 20.0)
    both, dims = features_at_steps(paired, slow, 20.0), alone.values.shape[2]
    np.testing.assert_allclose(both[:, :, dims:], alone.at(slow + 0.0125, 0.025), atol=1e-5)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"schedule": "cosin"}, "schedule is 'cosin'; did you mean 'cosine'"),
        ({"sampling": "posterior"}, 'takes every timestep: set steps to 20, or sampling to "strided"'),
        ({"decoder": "lstm"}, "decoder is 'lstm'; take gru, rnn, transformer"),
        ({"decoder": "transformer", "heads": 5}, "hidden is 12; take a multiple of heads, which is 5"),
        ({"decoder": "transformer", "bidirectional": True}, "a transformer sees both sides"),
    ],
)
def test_choices_that_cannot_be(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        config_of(**settings)
