"""The training of FaceDiffuser's network; imported by `fit` only."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from phonanim.regressors import Examples, Progress
from phonanim.regressors._denoiser import Denoiser
from phonanim.regressors._diffusion import (
    mask_sound,
    sample_motion,
    signal_share,
)
from phonanim.regressors._facediffuser_config import Config
from phonanim.regressors._journal import end_parts, part_of
from phonanim.regressors._steps import cached_encoder
from phonanim.regressors._torch import array, device, mixed_precision, seeded_generator, tensor
from phonanim.regressors._torch_audio import batches, step, training_key
from phonanim.regressors._torch_denoiser import Network
from phonanim.regressors._torch_journal import State
from phonanim.regressors._training_steps import BLOCK, Scaling, Steps, column_deviations, gather_steps

Floats = NDArray[np.float32]
Model = TypeVar("Model", bound=Denoiser)
CHECKED = 5  # sampling steps for validation clips after each epoch
FIRST_STAGE = "autoencoder"  # the folder of its journal


def fit_diffusion(
    build: type[Model],
    config: Config,
    train: Examples,
    validation: Examples,
    rng: np.random.Generator,
    progress: Progress,
    journal: Path | None,
) -> Model:
    """Train on random windows of the clips; the weights with the least validation error are kept.

    That error is the mean square of targets over whole clips, sampled in a few steps. Every epoch has a
    separate seed, so that an interrupted and continued training has the same result as an uninterrupted one.
    """
    seed = int(rng.integers(2**31))
    seeded_generator(np.random.default_rng(seed))
    learned = diffusion_steps(config, train)
    held_out = diffusion_steps(config, validation) if len(validation) else None
    scaling = scaled(config, learned)
    network = Network(config, learned.values.shape[2], learned.targets.shape[1]).to(device())
    identity = cached_encoder(config.encoder).identity
    whole = config.autoencoder + config.epochs

    def model() -> Model:
        return build(
            config, scaling.centre, scaling.scale, scaling.low, scaling.span, network.export(), identity
        )

    def reported(before: int) -> Progress:
        return lambda epochs: progress((before + epochs) / whole)

    if config.autoencoder:
        first = replace(config, epochs=config.autoencoder, patience=config.autoencoder)
        shown = Stage(first, network, learned, scaling, seed, autoencodes=True)
        shown.run(
            part_of(journal, FIRST_STAGE),
            lambda: autoencoding_error(network, scaling, held_out),
            reported(0),
        )
        freeze_but_sound(network)
    Stage(config, network, learned, scaling, seed).run(
        journal, lambda: sampled_error(model(), held_out), reported(config.autoencoder)
    )
    if config.autoencoder:
        end_parts(journal, [FIRST_STAGE])
    progress(1.0)
    return model()


def diffusion_steps(config: Any, examples: Examples) -> Steps:
    """Examples at the model's steps: the last layer of the encoder alone, or the two that `tuned` needs."""
    return gather_steps(Denoiser, config, examples, layers=2 if config.tuned else 1)


def scaled(config: Any, steps: Steps) -> Scaling:
    """Features to mean 0 and deviation 1; targets by one number for all modes, or one for each."""
    scaling = Scaling.of(config, steps)
    scaling = replace(scaling, centre=scaling.centre[-1:], scale=scaling.scale[-1:])
    if config.normalize == "modes":
        return replace(scaling, span=np.asarray(column_deviations(steps.targets) + 1e-6, np.float32))
    return scaling


def freeze_but_sound(network: Network) -> None:
    """Start the second stage of appendix B: freeze the decoder and train the audio part."""
    for part in network.parameters():
        part.requires_grad_(False)
    network.sound.requires_grad_(True)
    if network.tuned:
        network.tuned.requires_grad_(True)


@dataclass(frozen=True)
class Stage:
    """One training of a network: from sound, or from the target motion itself (`autoencodes`)."""

    config: Config
    network: Network
    steps: Steps
    scaling: Scaling
    seed: int
    autoencodes: bool = False

    def run(self, journal: Path | None, error: Callable[[], float], progress: Progress) -> None:
        """Train until all epochs are done or there is no improvement, then restore the best state."""
        config: Any = self.config
        optimizer = torch.optim.Adam(self.network.parameters(), lr=config.learning_rate)
        key = training_key(config, self.seed, self.steps)
        state = State(self.network, optimizer, [], [], key, journal)
        state.resume()
        while not state.ended(config):
            epoch = len(state.curve)
            if config.cosine:
                rate = config.learning_rate * (1 + np.cos(np.pi * epoch / config.epochs)) / 2
                optimizer.param_groups[0]["lr"] = float(rate)
            losses = self.epoch(optimizer, epoch)
            self.network.eval()
            state.add(float(np.mean(losses)), error())
            progress(epoch + 1)
        state.restore()

    def epoch(self, optimizer: Any, epoch: int) -> list[float]:
        """Train on every clip once; returns the losses."""
        self.network.train()
        settings: Any = self.config
        chance = np.random.default_rng([self.seed, epoch, 1])
        return [
            step(self.network, optimizer, self.loss(values, targets, styles, weights, chance))  # type: ignore[arg-type]
            for values, targets, _, _, styles, weights in batches(
                settings, self.steps, np.random.default_rng([self.seed, epoch])
            )
        ]

    def loss(
        self,
        values: Tensor,
        targets: Tensor,
        styles: NDArray[np.int64],
        weights: Tensor,
        rng: np.random.Generator,
    ) -> Tensor:
        """Huber's loss (eq. 5) of the motion that is estimated from noise at random times."""
        config, scaling = self.config, self.scaling
        motion = (array(targets) - scaling.low) / scaling.span
        times = rng.integers(1, config.timesteps + 1, len(motion))
        shares = signal_share(config.timesteps, config.schedule)[times][:, None, None]
        noise = rng.standard_normal(motion.shape, np.float32)
        noisy = np.sqrt(shares) * motion + np.sqrt(1 - shares) * noise
        wanted = tensor(motion)
        with mixed_precision():
            if self.autoencodes:
                assert self.network.face is not None
                audio = self.network.face(wanted)
            else:
                audio = self.network.sound(self.masked(values, rng))
            found = self.network(audio, tensor(noisy.astype(np.float32)), times, tensor(styles)).float()
        apart = nn.functional.huber_loss(found, wanted, reduction="none", delta=config.delta)
        return (apart.mean(dim=(1, 2)) * weights.to(device())).mean()

    def masked(self, values: Tensor, rng: np.random.Generator) -> Tensor:
        """Normalized features with a share of them masked, (n, steps, layers, dims) -> (n, steps, dims)."""
        config, centre, scale = self.config, self.scaling.centre[0], self.scaling.scale[0]
        if self.network.tuned is None:
            normal = (array(values)[:, :, 0] - centre) * scale
            return tensor(mask_sound(config.masking, config.masked, normal, rng))
        found = (self.network.tuned(values[:, :, 0].to(device())) - tensor(centre)) * tensor(scale)
        nothing = np.full(tuple(found.shape), np.nan, np.float32)
        covered = tensor(mask_sound(config.masking, config.masked, nothing, rng))
        return torch.where(torch.isnan(covered), found, covered)


def group_alike(steps: Steps, most: int = 100) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Rows of at most `most` whole clips of equal length and style: (style, (clips, steps))."""
    for length, style in np.unique(np.stack([steps.lengths, steps.styles], axis=1), axis=0):
        chosen = steps.starts[(steps.lengths == length) & (steps.styles == style)]
        count = max(1, min(most, BLOCK // max(1, int(length) * steps.targets[:1].nbytes)))
        for begin in range(0, len(chosen), count):
            yield int(style), chosen[begin : begin + count, None] + np.arange(length)


def sampled_error(model: Denoiser, steps: Steps | None) -> float:
    """Mean square error of whole clips, sampled in few steps; 0 without clips."""
    if steps is None:
        return 0.0
    total = 0.0
    for style, rows in group_alike(steps):
        one = model.with_settings(style=style)
        audio = one.embed_sound(one.normalize_features(steps.values[rows]))
        wide = (len(rows), rows.shape[1], len(one.low))

        def noise(turn: int, wide: tuple[int, int, int] = wide) -> Floats:
            return np.random.default_rng([0, turn]).standard_normal(wide, np.float32)

        found = sample_motion(one.config, one.weights, audio, noise, steps=min(CHECKED, one.config.steps))
        total += float(((one.unscale_modes(found) - steps.targets[rows]) ** 2).sum())
    return total / steps.targets.size


def autoencoding_error(network: Network, scaling: Scaling, steps: Steps | None) -> float:
    """The same for the first stage: motion reconstructed from itself, at the time with most noise."""
    if steps is None:
        return 0.0
    total = 0.0
    for style, rows in group_alike(steps):
        wanted = tensor((steps.targets[rows] - scaling.low) / scaling.span)
        noise = tensor(np.random.default_rng(0).standard_normal(wanted.shape, np.float32))
        times = np.full(len(rows), network.config.timesteps)
        assert network.face is not None
        with torch.no_grad():
            found = network(
                network.face(wanted), noise, times, torch.full((len(rows),), style, device=wanted.device)
            )
        total += float(((array(found - wanted) * scaling.span) ** 2).sum())
    return total / steps.targets.size
