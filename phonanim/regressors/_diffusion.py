"""Denoising diffusion in NumPy: a network that removes noise, and the sampling that starts from noise.

After the text of FaceDiffuser (Stan 2023), sections 3.4, 5.2, 6 and 8. `_torch_diffusion` trains the same
layers under the same names. Time 0 is the motion without noise, time `timesteps` almost pure noise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import sigmoid, tensors_with_prefix
from phonanim.regressors._decoders import attentive, in_windows, recurrent_shapes, transformer_shapes
from phonanim.regressors._facediffuser_config import Config
from phonanim.regressors._recurrent import run_recurrent
from phonanim.regressors._tuned import block_shapes

Floats = NDArray[np.float32]
Weights = Mapping[str, Floats]
Shapes = dict[str, tuple[int, ...]]

CONVOLVED = ("conv", "max", "average")  # the embeddings with a convolution
TAPS = 9  # width of the kernel over features (the released code)
POOLED = 2  # channels that are merged into one
REACH = 1  # steps on each side in the convolution
SLOWEST = 1e4  # longest wavelength of the time embedding, relative to the shortest (Ho et al. 2020)
BETAS = (1e-4, 0.02)  # of the first and last of 1000 steps (Ho et al. 2020); the thesis gives none
STEEPEST = 0.999  # largest beta (Nichol and Dhariwal 2021)
OFFSET = 0.008  # of the cosine, so that the first betas are not too small (the same)
BLOCK = 1500  # steps whose noise has one seed


def signal_share(timesteps: int, schedule: str = "linear") -> NDArray[np.float64]:
    """The share of the signal's power that remains at each time, (timesteps + 1,), falling from 1.

    "linear": prod (1 - beta), with beta on a straight line (eq. 1), scaled so that the last share is the same
    for any number of timesteps. "cosine": cos² from 1 almost to 0, with each beta at most 0.999 (Nichol and
    Dhariwal 2021, eq. 17).
    """
    if schedule == "cosine":
        turns = (np.arange(timesteps + 1) / timesteps + OFFSET) / (1 + OFFSET)
        shares = np.cos(turns * np.pi / 2) ** 2
        kept = np.maximum(shares[1:] / shares[:-1], 1 - STEEPEST)
        return np.concatenate([[1.0], np.cumprod(kept)])
    betas = np.minimum(np.linspace(*BETAS, timesteps) * 1000 / timesteps, STEEPEST)
    return np.concatenate([[1.0], np.cumprod(1 - betas)])


def add_noise(motion: Floats, share: float, noise: Floats) -> Floats:
    """Add noise to motion so that `share` of the signal's power remains, any shape (eq. 1 from time 0 on)."""
    return np.asarray(np.sqrt(share) * motion + np.sqrt(1 - share) * noise, np.float32)


def sampling_times(timesteps: int, steps: int) -> NDArray[np.int64]:
    """The times at which the network is evaluated: `steps` of them, evenly from the last to the first."""
    return np.round(np.linspace(timesteps, 1, steps)).astype(np.int64)


def step_noise(seed: int, turn: int, first: int, count: int, modes: int) -> Floats:
    """Noise of `count` steps from `first` on, (count, modes); independent of how steps are divided.

    No more is drawn than the steps ask for: a short line of a mesh costs by its length.
    """
    found, end = [], first + count
    for block in range(first // BLOCK, (end - 1) // BLOCK + 1):
        start = block * BLOCK
        drawn = np.random.default_rng([seed, turn, block]).standard_normal(
            (min(end - start, BLOCK), modes), np.float32
        )
        found.append(drawn[max(first - start, 0) :])
    return np.concatenate(found)


def sample_motion(
    config: Config,
    weights: Weights,
    audio: Floats,
    noise: Callable[[int], Floats],
    no_audio: Floats | None = None,
    steps: int | None = None,
) -> Floats:
    """Motion from noise (section 3.4.1), audio (n, steps, dims) -> (n, steps, modes) in the targets' scale.

    "rediffuse": the motion that the network estimates is diffused again to the next time, with `noise` of
    that turn, (n, steps, modes), as the thesis writes. "posterior": the next motion is drawn between the
    estimate and the motion before (`draw_posterior`), as DDPM does and the released code; "strided" does so
    over `steps` of the times (Nichol and Dhariwal 2021, section 4).
    `audio` is the embedded sound, which is constant in the loop. If `no_audio`, the embedding of no sound, is
    given, both predictions are combined.
    """
    if not config.diffusion:
        return denoise(config, weights, noise(0), 0, audio)
    shares = signal_share(config.timesteps, config.schedule)
    times = sampling_times(config.timesteps, steps or config.steps)
    found = noisy = noise(0)
    for turn, time in enumerate(times):
        if turn and config.sampling == "rediffuse":
            noisy = add_noise(found, shares[time], noise(turn))
        elif turn:
            noisy = draw_posterior(noisy, found, shares[times[turn - 1]], shares[time], noise(turn))
        found = guided_motion(config, weights, noisy, int(time), audio, no_audio)
    return found


def draw_posterior(noisy: Floats, found: Floats, share: float, later: float, noise: Floats) -> Floats:
    """Motion at a time with less noise, drawn from the posterior of DDPM (Ho et al. 2020, eq. 6 and 7).

    `noisy` is the motion with the signal's power `share`, `found` the estimate without noise, `later` the
    larger share to go to; any shape. At the last time the estimate itself is the result.
    """
    beta = 1 - share / later
    mean = np.sqrt(later) * beta * found + np.sqrt(share / later) * (1 - later) * noisy
    deviation = np.sqrt((1 - later) / (1 - share) * beta)
    return np.asarray(mean / (1 - share) + deviation * noise, np.float32)


def guided_motion(
    config: Config, weights: Weights, noisy: Floats, time: int, audio: Floats, no_audio: Floats | None
) -> Floats:
    """The motion w F(x, t, a) + (1 - w) F(x, t, nothing), with w the `guidance`.

    Equation 8 has w at the unconditional part, but its text says that a low w uses less audio, as here.
    """
    found = denoise(config, weights, noisy, time, audio)
    if no_audio is None:
        return found
    free = denoise(config, weights, noisy, time, no_audio)
    return np.asarray(free + np.float32(config.guidance) * (found - free))


def denoise(config: Config, weights: Weights, noisy: Floats, time: int, audio: Floats) -> Floats:
    """The network's estimate of the motion without noise (eq. 4), (n, steps, modes) -> the same.

    The embeddings of sound, noise and time are concatenated; recurrent layers, the style as a factor of
    their output, and a linear layer follow.
    """
    signal = audio
    if config.diffusion:
        moment = embed_times(weights, np.array([time]))[:, None]
        embedding = tensors_with_prefix(weights, "noise_")
        parts = [audio, embed(config.noise, embedding, noisy, config.noise_over)]
        parts.append(np.broadcast_to(moment, (*noisy.shape[:2], moment.shape[2])))
        signal = np.concatenate(parts, axis=2)
    if config.decoder == "transformer":
        signal = in_windows(weights, signal, lambda part: attentive(config, weights, part))
    else:
        for layer in range(config.depth):
            signal = run_recurrent(config.decoder, signal, weights, layer)
    return np.asarray(signal * weights["style"][config.style] @ weights["output"] + weights["output_bias"])


def embed(kind: str, weights: Weights, signal: Floats, over: str = "time") -> Floats:
    """One of EMBEDDINGS, (n, steps, dims) -> (n, steps, size), with its convolution over time or features."""
    if kind == "none":
        return signal
    found = signal @ weights["first"] + weights["first_bias"]
    if kind == "linear":
        return np.asarray(found)
    if over == "features" and kind in CONVOLVED:
        return pool_channels(kind, convolve_features(found, weights))
    found = np.maximum(found, 0)
    if kind == "mlp":
        return np.asarray(found @ weights["second"] + weights["second_bias"])
    padded = np.pad(found, ((0, 0), (REACH, REACH), (0, 0)))
    taps = [padded[:, tap : tap + found.shape[1]] @ kernel for tap, kernel in enumerate(weights["second"])]
    return pool_channels(kind, np.asarray(sum(taps) + weights["second_bias"]))


def convolve_features(signal: Floats, weights: Weights) -> Floats:
    """One kernel over the features of each step, and a rectifier, (n, steps, size) -> the same."""
    kernel = weights["second"]
    padded = np.pad(signal, ((0, 0), (0, 0), (len(kernel) // 2,) * 2))
    spans = np.lib.stride_tricks.sliding_window_view(padded, len(kernel), axis=2)
    return np.maximum(np.asarray(spans @ kernel + weights["second_bias"]), 0)


def pool_channels(kind: str, signal: Floats) -> Floats:
    """The maximum or the mean of neighbouring channels, (n, steps, 2 size) -> (n, steps, size)."""
    if kind == "conv":
        return signal
    pairs = signal.reshape(*signal.shape[:2], -1, POOLED)
    return np.asarray(pairs.max(axis=3) if kind == "max" else pairs.mean(axis=3))


def embed_times(weights: Weights, times: NDArray[np.integer]) -> Floats:
    """Embedding of times by a network of two layers, (n,) -> (n, size)."""
    found = time_waves(times, len(weights["time_first"])) @ weights["time_first"] + weights["time_first_bias"]
    return np.asarray(found * sigmoid(found) @ weights["time_second"] + weights["time_second_bias"])


def time_waves(times: NDArray[np.integer], size: int) -> Floats:
    """Sines and cosines that encode times, (n,) -> (n, size) (Vaswani et al. 2017; Ho et al. 2020)."""
    angles = times[:, None] * SLOWEST ** -(np.arange(size // 2) / (size // 2))
    return np.concatenate([np.sin(angles), np.cos(angles)], axis=1).astype(np.float32)


def mask_sound(strategy: str, share: float, audio: Floats, rng: np.random.Generator) -> Floats:
    """Sound as the network gets it in training, (n, steps, dims) -> the same (section 6.1.1).

    "full" strategies mask all features of a `share` of the sequences, "partial" ones a `share` of the
    features of all sequences; masked features become zero or random numbers.
    """
    if strategy == "none":
        return audio
    shape = (len(audio), 1, 1) if strategy.startswith("full") else audio.shape
    return np.where(rng.random(shape) < share, no_sound(strategy, audio.shape, rng), audio)


def no_sound(strategy: str, shape: tuple[int, ...], rng: np.random.Generator) -> Floats:
    """The replacement of absent sound: zeros, or random numbers if the network was trained with them."""
    if strategy.endswith("random"):
        return rng.standard_normal(shape, np.float32)
    return np.zeros(shape, np.float32)


def weight_shapes(config: Config, dims: int, modes: int, norm_first: bool = True) -> Shapes:
    """Name and shape of every weight of a network with `dims` input features.

    `norm_first` is whether the encoder's blocks that are trained further normalize first.
    """
    shapes, before = embedding_shapes(config.sound, "sound_", dims, config.latent)
    if config.diffusion:
        more, size = embedding_shapes(config.noise, "noise_", modes, config.latent, config.noise_over)
        timing, moment = embedding_shapes("mlp", "time_", config.latent, config.latent)
        shapes |= more | timing
        before += size + moment
    body = transformer_shapes if config.decoder == "transformer" else recurrent_shapes
    layers, before = body(config, before)
    shapes |= layers
    tuned = block_shapes(config.tuned, dims // 2, norm_first)
    shapes |= {f"tuned_{name}": shape for name, shape in tuned.items()}
    return shapes | {"style": (config.styles, before), "output": (before, modes), "output_bias": (modes,)}


def embedding_shapes(kind: str, name: str, dims: int, size: int, over: str = "time") -> tuple[Shapes, int]:
    """The weights of an embedding, and its number of output channels."""
    if kind == "none":
        return {}, dims
    shapes: Shapes = {f"{name}first": (dims, size), f"{name}first_bias": (size,)}
    if kind == "linear":
        return shapes, size
    wide = size * (POOLED if kind in ("max", "average") else 1)
    if over == "features" and kind in CONVOLVED:
        shapes = {f"{name}first": (dims, wide), f"{name}first_bias": (wide,)}
        return shapes | {f"{name}second": (TAPS,), f"{name}second_bias": (1,)}, size
    second = (size, wide) if kind == "mlp" else (2 * REACH + 1, size, wide)
    return shapes | {f"{name}second": second, f"{name}second_bias": (wide,)}, size
